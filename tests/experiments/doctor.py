#!/usr/bin/env python3
"""How well the verdict on a map goes with the truth: maps of damaged recordings, labelled, and the ROC of the verdict.

usage: doctor.py FOLDER_OF_PROGRAMS [--worlds office:office,...] [--log NAME=LOG:POSES ... --alter ALTER_CARMEN.py] [options]

  --worlds WORLD:TOUR,...  simulated, where truth is exact; names of config/, or paths of TOML files
  --simulator PROGRAM      default: marco-simulate of the programs
  --log NAME=LOG:POSES     a CARMEN log, and poses by its stamps (TUM) that count as true: those of a map of the
                           undamaged log that was checked
  --alter PROGRAM          what makes damaged copies of CARMEN logs (alter_carmen.py of the test data's tools)
  --drawn FOLDER           logs that drawn_worlds.py wrote: buildings and damages drawn by a seed, with exact truth
  --damages a,b,...        default: all
  --copies N               of each damage, each with its own seed (default 2)
  --keep FOLDER            logs and maps stay there, and are made only once

Labels: wrong = 2 % of the path or more is off by over 0.3 m after the best robust fit, or a pose by over 1 m; good = no
pose is, and the median is within 1.5 times that of the undamaged recording's worst copy; the rest is not counted.
Printed are both kinds by verdict, every mistake, the ROC of the largest figure in units of its limit, and the maps that
are worse than 1.1 times their own odometry (and by over 5 cm rms): !! says that the verdict is no "wrong".
"""
import argparse
import bisect
import concurrent.futures
import json
import math
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CARMEN = {
    "none": ["--noise", "0.001"],
    "half": ["--drop", "0.5"],
    "tenth": ["--drop", "0.9"],
    "bursts": ["--drop-bursts", "9", "10"],
    "range_4": ["--max-range", "4"],
    "noise_3cm": ["--noise", "0.03"],
    "noise_5cm": ["--noise", "0.05"],
    "every_2nd_beam": ["--every-beam", "2"],
    "forward_sign": ["--forward-sign"],
    "no_odometry": ["--lost-odometry"],
}
SIMULATED = {
    "none": "",
    "slow": "[laser]\nscans_per_s = 1.0\n",
    "noise_3cm": "[laser]\nrange_sigma_m = 0.03\nscans_per_s = 5.0\n",
    "noise_6cm": "[laser]\nrange_sigma_m = 0.06\nscans_per_s = 5.0\n",
    "range_4": "[laser]\nrange_max_m = 4.0\nscans_per_s = 5.0\n",
    "range_3_slow": "[laser]\nrange_max_m = 3.0\nscans_per_s = 1.0\n",
    "few_beams": "[laser]\nbeams = 46\nstep_deg = 4.0\nscans_per_s = 5.0\n",
    "dropped": "[laser]\nscans_per_s = 5.0\n[logger]\ndropped_scans = 0.9\n",
    "bad_odometry": "[laser]\nscans_per_s = 2.0\n[odometry]\ndrift_deg_per_m = 15.0\ndistance_error = 0.3\n",
}
# As in slam/doctor: where a figure makes a map doubtful.
LIMITS = {"contradicting": 0.30, "odometry_sigmas": 6.0, "loop_surprise": 100.0, "unmatched": 0.2, "disagreement_m": 0.5,
          "spread_m": 0.3}


def run(command):
    return subprocess.run(command, capture_output=True, text=True)


def poses_of(path, stamps=None):
    poses = {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            values = line.split()
            if values and values[0] != "#":
                at = round(float(values[0]), 4)
                poses[(stamps or {}).get(at, at)] = complex(float(values[1]), float(values[2]))
    return poses


def stamps_of(path):
    """The original stamp by that of a damaged copy."""
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as file:
        return {round(float(a), 4): round(float(b), 4) for a, b in (line.split() for line in file)}


class Truth:
    """True poses, which are not taken at the scans' stamps."""

    def __init__(self, poses):
        self.poses, self.times = poses, sorted(poses)

    def at(self, time):
        i = bisect.bisect_left(self.times, time)
        if i < len(self.times) and self.times[i] == time:
            return self.poses[time]
        if i == 0 or i == len(self.times) or self.times[i] - self.times[i - 1] > 0.5:
            return None
        part = (time - self.times[i - 1]) / (self.times[i] - self.times[i - 1])
        return self.poses[self.times[i - 1]] * (1 - part) + self.poses[self.times[i]] * part


def distances(ours, truth):
    """After the rigid motion that fits most poses: weights 1 / (1 + (e / 5 cm)^2)."""
    pairs = [(pose, truth.at(at)) for at, pose in ours.items()]
    pairs = [pair for pair in pairs if pair[1] is not None]
    if len(pairs) < 10:
        return []
    weights, off = [1.0] * len(pairs), []
    for _ in range(30):
        total = sum(weights)
        a0 = sum(w * a for w, (a, _) in zip(weights, pairs)) / total
        b0 = sum(w * b for w, (_, b) in zip(weights, pairs)) / total
        cross = sum(w * (a - a0).conjugate() * (b - b0) for w, (a, b) in zip(weights, pairs))
        turn = cross / abs(cross) if abs(cross) > 0 else 1
        off = [abs(turn * (a - a0) - (b - b0)) for a, b in pairs]
        weights = [1.0 / (1.0 + (e / 0.05) ** 2) for e in off]
    return sorted(off)


def rms_m(ours, truth):
    """After the rigid motion of least squares."""
    pairs = [(pose, truth.at(at)) for at, pose in ours.items()]
    pairs = [pair for pair in pairs if pair[1] is not None]
    a0, b0 = (sum(pair[k] for pair in pairs) / len(pairs) for k in (0, 1))
    cross = sum((a - a0).conjugate() * (b - b0) for a, b in pairs)
    turn = cross / abs(cross) if abs(cross) > 0 else 1
    return math.sqrt(sum(abs(turn * (a - a0) - (b - b0)) ** 2 for a, b in pairs) / len(pairs))


def score(figures):
    parts = [(math.inf if figures[name] is None else figures[name]) / limit for name, limit in LIMITS.items()]
    parts.append(figures["refused_loop_m"] / 0.3 if figures["refused_loops"] >= 2 else 0.0)
    parts.append(figures["joint_m"] / (0.3 if figures["has_odometry"] else 0.045))
    parts.append(figures["joint_deg"] / 5.0)
    return max(parts)


def judged(options, log, truth, stamps, out):
    """The map of a log: its verdict, score and errors."""
    if not os.path.exists(os.path.join(out, "report.json")):
        done = run([f"{options.programs}/marco-map", log, "--out", out])
        if done.returncode not in (0, 3):
            return None
    with open(os.path.join(out, "report.json"), encoding="utf-8") as file:
        report = json.load(file)
    true = Truth(poses_of(truth or os.path.join(out, "truth.tum")))
    ours = poses_of(os.path.join(out, "trajectory.tum"), stamps)
    off = distances(ours, true)
    if not off:
        return None
    return {"verdict": report["verdict"], "score": score(report["doctor"]["figures"]),
            "causes": sorted({reason["cause"] for reason in report["doctor"]["reasons"]}),
            "median": off[len(off) // 2], "max": off[-1], "off": sum(e > 0.3 for e in off) / len(off),
            "rms": rms_m(ours, true), "odometry": odometry_m(log, out, stamps, true)}


def odometry_m(log, out, stamps, true):
    """The rms of the recording's own odometry; nothing where there is none."""
    for path in (log[:-4] + ".odometry.tum", os.path.join(out, "odometry.tum")):
        if os.path.exists(path):
            return rms_m(poses_of(path, stamps), true)
    return math.inf


def simulated(options, folder, world, damage, seed):
    world_file, tour_file = (part if part.endswith(".toml") else f"{ROOT}/config/{kind}/{part}.toml"
                             for kind, part in zip(("worlds", "tours"), world.split(":")))
    name = f"{os.path.basename(tour_file)[:-5]}.{damage}.{seed}"
    log = os.path.join(folder, name + ".lcm")
    if not os.path.exists(log):
        config = os.path.join(folder, name + ".toml")
        with open(config, "w", encoding="utf-8") as file:
            file.write(SIMULATED[damage])
        done = run([options.simulator or f"{options.programs}/marco-simulate", "--world", world_file, "--tour", tour_file,
                    "--preset", "harsh" if seed % 2 else "default", "--seed", str(seed), "--config", config,
                    "--out", log + ".part"])
        if done.returncode != 0:
            sys.exit(done.stdout + done.stderr)
        os.rename(log + ".part", log)
    return world, damage, seed, judged(options, log, None, None, os.path.join(folder, name))


def altered(options, folder, given, damage, seed):
    name, files = given.split("=")
    original, truth = files.split(":")
    log = os.path.join(folder, f"{name}.{damage}.{seed}.log")
    if not os.path.exists(log):
        done = run([sys.executable, options.alter, original, log, "--noise", "0.001", *CARMEN[damage], "--seed", str(seed)])
        if done.returncode != 0:
            sys.exit(done.stdout + done.stderr)
    return name, damage, seed, judged(options, log, truth, stamps_of(log + ".stamps"), log[:-4])


def drawn(options, folder, log):
    kind, world, copy = os.path.basename(log)[:-4].split(".")
    out = os.path.join(folder, os.path.basename(log)[:-4])
    with open(log[:-4] + ".json", encoding="utf-8") as file:
        damages = "+".join(json.load(file)["damages"]) or "none"
    return f"{kind}.{world}", damages, copy, judged(options, log, log[:-4] + ".tum", None, out)


def is_worse_than_odometry(result):
    return result["rms"] > max(1.1 * result["odometry"], 0.05)


def label(result, undamaged_m):
    if result["off"] >= 0.02 or result["max"] > 1.0:
        return "wrong"
    if result["max"] <= 0.3 and result["median"] <= 1.5 * undamaged_m:
        return "good"
    return "-"


def print_roc(rows):
    good = sorted(r["score"] for _, _, _, r, kind in rows if kind == "good")
    wrong = sorted(r["score"] for _, _, _, r, kind in rows if kind == "wrong")
    if not good or not wrong:
        return
    print("limit   good called good   wrong called wrong or doubtful")
    for limit in (0.25, 0.4, 0.6, 0.8, 1.0, 1.25, 1.6, 2.5, 4.0):
        print(f"{limit:5.2f}   {sum(s <= limit for s in good) / len(good):16.3f}   "
              f"{sum(s > limit for s in wrong) / len(wrong):10.3f}")
    pairs = sum((w > g) + 0.5 * (w == g) for g in good for w in wrong)
    print(f"area under the curve: {pairs / (len(good) * len(wrong)):.4f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--worlds", default="")
    parser.add_argument("--simulator")
    parser.add_argument("--log", action="append", default=[])
    parser.add_argument("--alter")
    parser.add_argument("--drawn")
    parser.add_argument("--damages", default="")
    parser.add_argument("--copies", type=int, default=2)
    parser.add_argument("--keep")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    chosen = [d for d in options.damages.split(",") if d]
    rows = []
    with tempfile.TemporaryDirectory() as temporary, concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        jobs = []
        for sources, damages, make in (([w for w in options.worlds.split(",") if w], SIMULATED, simulated),
                                       (options.log, CARMEN, altered)):
            for source in sources:
                for damage in damages:
                    if not chosen or damage in chosen:
                        jobs += [pool.submit(make, options, folder, source, damage, seed)
                                 for seed in range(1, options.copies + 1)]
        if options.drawn:
            jobs += [pool.submit(drawn, options, folder, os.path.join(options.drawn, name))
                     for name in sorted(os.listdir(options.drawn)) if name.endswith(".log")]
        results = [job.result() for job in jobs]
    undamaged = {}
    for source, damage, _, result in results:
        if damage == "none" and result:
            undamaged[source] = max(undamaged.get(source, 0.01), result["median"])
    for source, damage, seed, result in results:
        if result is None:
            print(f"{source} {damage} {seed}: no map")
            continue
        rows.append((source, damage, seed, result, label(result, undamaged.get(source, math.inf))))
    for source, damage, seed, result, kind in rows:
        lost = is_worse_than_odometry(result) and result["verdict"] != "wrong"
        print(f"{'!!' if lost else '  '} {source:24} {damage:15} {seed}  {kind:5} called {result['verdict']:8}  score {result['score']:6.2f}  median "
              f"{result['median']:.3f}  max {result['max']:.2f} m  {100 * result['off']:.1f} % off  {','.join(result['causes'])}")
    for kind in ("good", "wrong", "-"):
        of_kind = [r["verdict"] for _, _, _, r, k in rows if k == kind]
        print(f"{kind:5} {len(of_kind):4}: " + ", ".join(f"{v} {of_kind.count(v)}" for v in ("good", "doubtful", "wrong")))
    print_roc(rows)
    worse = [r for _, _, _, r, _ in rows if is_worse_than_odometry(r)]
    print(f"worse than 1.1 times the odometry: {len(worse)}, called wrong {sum(r['verdict'] == 'wrong' for r in worse)}")


if __name__ == "__main__":
    main()
