#!/usr/bin/env python3
"""What damage to a log costs: the map's error of noisy copies of it, damaged and not, the worst of them all.

usage: damages.py FOLDER_OF_PROGRAMS --log NAME=LOG:TRUTH [--log ...] --alter ALTER_CARMEN.py [options]

  --log NAME=LOG:TRUTH   a CARMEN log, and its relations (*.relations), or true poses by its stamps (TUM)
  --alter PROGRAM        what makes damaged copies (alter_carmen.py of the test data's tools)
  --beside FOLDER        other programs, run on the same copies
  --damages a,b,...      default: all of DAMAGES
  --copies N             of each damage, with 1 mm of range noise and its own seed (default 10)
  --config TOML          for the first programs
  --keep FOLDER          copies and maps stay there, and copies are made only once
  --jobs N               at once (default 2)

Relations: mean translation error, pooled over the copies (n is their number) and of the worst one, and the largest of
all. Poses: rms and largest distance after the best fit in the plane. A copy that fails counts as 'failed'.
"""
import argparse
import concurrent.futures
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile

NOISE = ["--noise", "0.001"]
DAMAGES = {
    "none": NOISE,
    "half": [*NOISE, "--drop", "0.5"],
    "fifth": [*NOISE, "--drop", "0.8"],
    "tenth": [*NOISE, "--drop", "0.9"],
    "bursts": [*NOISE, "--drop-bursts", "9", "10"],
    "every_2nd_beam": [*NOISE, "--every-beam", "2"],
    "field_90": [*NOISE, "--field", "90"],
    "range_8": [*NOISE, "--max-range", "8"],
    "range_4": [*NOISE, "--max-range", "4"],
    "no_odometry": [*NOISE, "--lost-odometry"],
    "late_0.3": [*NOISE, "--odometry-late", "0.3"],
    "noise_2cm": ["--noise", "0.02"],
    "noise_3cm": ["--noise", "0.03"],
    "noise_5cm": ["--noise", "0.05"],
    "turned_180": [*NOISE, "--turn-odometry", "180"],
    "turned_30": [*NOISE, "--turn-odometry", "30"],
    "scale_0.5": [*NOISE, "--left-scale", "0.5", "--right-scale", "0.5"],
    "unequal_0.1": [*NOISE, "--left-scale", "1.1"],
    "forward_sign": [*NOISE, "--forward-sign"],
    "hand_3": NOISE,
    "hand_10": NOISE,
    "box_10": NOISE,
    "crowd_10": NOISE,
    "twice": NOISE,
}
COVERS = 8  # of hand_3 (s) and the like, one after the other all through the log


def covered_ranges_m(kind, count, draw):
    """What covers a laser: a hand on it, a box put over it, people who stand all around and leave gaps (0)."""
    if kind == "hand":
        return [draw.uniform(0.15, 0.25) for _ in range(count)]
    if kind == "box":
        bearings = (math.pi * (beam / max(count - 1, 1) - 0.5) for beam in range(count))
        return [0.5 / max(abs(math.cos(a)), abs(math.sin(a))) + draw.gauss(0, 0.005) for a in bearings]
    people = [(draw.uniform(0, count), draw.uniform(0.45, 0.95)) for _ in range(14)]
    half = count / 20
    near = [min((r for at, r in people if abs(beam - at) < half), default=0.0) for beam in range(count)]
    return [r + draw.gauss(0, 0.01) if r > 0 else 0.0 for r in near]


def cover(path, kind, seconds, draw):
    """Covers the laser of a CARMEN log COVERS times."""
    with open(path, encoding="utf-8") as file:
        lines = file.readlines()
    stamps = [float(line.split()[-3]) for line in lines if line.startswith("FLASER")]
    gap_s = (stamps[-1] - stamps[0]) / (COVERS + 1)
    starts = [stamps[0] + gap_s * (i + 1) for i in range(COVERS)]
    with open(path, "w", encoding="utf-8") as file:
        for line in lines:
            words = line.split()
            if words and words[0] == "FLASER" and any(0 <= float(words[-3]) - t < seconds for t in starts):
                count = int(words[1])
                ranges = covered_ranges_m(kind, count, draw)
                words[2:2 + count] = [f"{r:.3f}" if r > 0 else old for r, old in zip(ranges, words[2:2 + count])]
                line = " ".join(words) + "\n"
            file.write(line)


def damage_copy(path, damage, seed):
    """Damages that the program for the copies does not know."""
    if damage == "twice":
        with open(path, encoding="utf-8") as file:
            lines = file.readlines()
        with open(path, "w", encoding="utf-8") as file:
            file.writelines(line for line in lines for _ in range(2 if line.startswith("FLASER") else 1))
    elif damage.startswith(("hand_", "box_", "crowd_")):
        kind, seconds = damage.split("_")
        cover(path, kind, float(seconds), random.Random(seed))


def run(command):
    return subprocess.run(command, capture_output=True, text=True)


def poses_of(path):
    poses = {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            values = line.split()
            if values and values[0] != "#":
                poses[round(float(values[0]), 4)] = (float(values[1]), float(values[2]))
    return poses


def distances_after_fit(ours, true):
    """Of the poses (by stamp) that both have, after the rigid motion in the plane that fits best."""
    pairs = [(complex(*ours[t]), complex(*true[t])) for t in ours if t in true]
    if len(pairs) < 2:
        return []
    a0, b0 = sum(a for a, _ in pairs) / len(pairs), sum(b for _, b in pairs) / len(pairs)
    cross = sum((a - a0).conjugate() * (b - b0) for a, b in pairs)
    turn = cross / abs(cross) if abs(cross) > 0 else 1
    return [abs(turn * (a - a0) - (b - b0)) for a, b in pairs]


def path_of_laser(path, turned_deg):
    """The path is the robot's, and relations are those of a laser that looks so far to the left of its front."""
    c, s = math.cos(math.radians(turned_deg) / 2), math.sin(math.radians(turned_deg) / 2)
    with open(path, encoding="utf-8") as file, open(path + ".laser", "w", encoding="utf-8") as laser:
        for line in file:
            *place, z, w = line.split()
            if place[0] != "#":
                z, w = float(z) * c + float(w) * s, float(w) * c - float(z) * s
                laser.write(f"{' '.join(place)} {z:.9f} {w:.9f}\n")
    return path + ".laser"


def judged(programs, out, truth, damage):
    """(n, mean or rms, largest, degrees) of one map."""
    path = os.path.join(out, "trajectory.tum")
    if truth.endswith(".relations") and damage.startswith("turned_"):
        # Odometry that drives backwards all the way is taken to count backwards: the robot drives ahead.
        path = path_of_laser(path, float(damage.split("_")[1]) % 180)
    if truth.endswith(".relations"):
        said = run([f"{programs}/marco-evaluate", path, truth])
        found = re.search(r"n=(\d+) .*?mean=([\d.]+).*?max=([\d.]+).*?mean=([\d.]+)", said.stdout)
        return (int(found[1]), float(found[2]), float(found[3]), float(found[4])) if found else None
    off = distances_after_fit(poses_of(path), poses_of(truth))
    return (len(off), math.sqrt(sum(d * d for d in off) / len(off)), max(off), 0.0) if off else None


def one(options, programs, config, name, log, truth, damage, seed, folder):
    copy = os.path.join(folder, f"{name}.{damage}.{seed}.log")
    if not os.path.exists(copy):
        part = f"{copy}.{os.getpid()}.{os.path.basename(os.path.dirname(programs)) or 'part'}"
        made = run([sys.executable, options.alter, log, part, *DAMAGES[damage], "--seed", str(seed)])
        if made.returncode != 0:
            sys.exit(made.stderr)
        damage_copy(part, damage, seed)
        os.rename(part, copy)
    mark = re.sub(r"\W+", "_", programs)
    out = os.path.join(folder, f"{name}.{damage}.{seed}.{mark}")
    done = run([f"{programs}/marco-map", copy, "--out", out, *(["--config", config] if config else [])])
    if done.returncode not in (0, 3):
        return None
    with open(os.path.join(out, "report.json"), encoding="utf-8") as file:
        report = json.load(file)
    result = judged(programs, out, truth, damage)
    return (*result, report["cpu_s"], len(report["loops"]), done.returncode) if result else None


def row(results):
    good = [r for r in results if r]
    failed = len(results) - len(good)
    if not good:
        return f"failed {failed}"
    n = sum(r[0] for r in good)
    pooled = sum(r[0] * r[1] for r in good) / n
    return (f"{pooled:8.4f} {max(r[1] for r in good):8.4f} {max(r[2] for r in good):8.3f} {max(r[3] for r in good):7.3f}"
            f" {n:6d} {sum(r[4] for r in good) / len(good):6.1f} {sum(r[5] for r in good) / len(good):6.0f}"
            f" {sum(r[6] == 3 for r in good):5d}" + (f" failed {failed}" if failed else ""))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--log", action="append", required=True)
    parser.add_argument("--alter", required=True)
    parser.add_argument("--beside")
    parser.add_argument("--damages", default=",".join(DAMAGES))
    parser.add_argument("--copies", type=int, default=10)
    parser.add_argument("--config")
    parser.add_argument("--keep")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    print(f"{'log':10} {'damage':15} {'by':7} {'mean':>8} {'worst':>8} {'max':>8} {'deg':>7} {'n':>6} {'cpu_s':>6}"
          f" {'loops':>6} wrong", flush=True)
    with tempfile.TemporaryDirectory() as temporary, concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        who = [("", options.programs, options.config)] + ([("beside", options.beside, None)] if options.beside else [])
        for entry in options.log:
            name, files = entry.split("=", 1)
            log, truth = files.rsplit(":", 1)
            for damage in options.damages.split(","):
                for by, programs, config in who:
                    results = list(pool.map(
                        lambda seed, p=programs, c=config: one(options, p, c, name, log, truth, damage, seed, folder),
                        range(1, options.copies + 1)))
                    print(f"{name:10} {damage:15} {by:7} {row(results)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
