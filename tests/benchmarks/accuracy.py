#!/usr/bin/env python3
"""How right the maps are: every recording below MARCO_TEST_DATA, and the simulated worlds, as tables in Markdown.

usage: accuracy.py FOLDER_OF_PROGRAMS [--only WORD] [--copies N] [--write]

  --only WORD  recordings whose path below MARCO_TEST_DATA holds it
  --copies N   of each recording, with 1 mm of range noise and its own seed (10)
  --write      into docs/benchmarks.md, between its two marks

A recording's reference is NAME.relations beside NAME.log (hand-checked relative poses), or the true poses that it holds.
Where there is none, the verdict is what the map says of itself, and copies tell how far noise moves the path.
`./marco bench --accuracy` calls this.
"""
import argparse
import array
import bisect
import glob
import json
import math
import os
import random
import re
import struct
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, ROOT + "/tests/experiments")
from damages import distances_after_fit, poses_of, run  # noqa: E402

PAGE = ROOT + "/docs/benchmarks.md"
BEGIN, END = "<!-- ./marco bench --accuracy --write -->\n", "<!-- end -->\n"
FILES = (".log", ".clf", ".lcm", ".lcmlog", ".bag", ".mcap")
NOISE_M = 0.001
LASERS = ("LIDAR", "LIDAR_RAW")  # both begin with a stamp, the number of ranges, and the ranges


def recordings(data):
    """Files that may be recordings, and folders that are one: rosbag2 and scans of a tilted laser."""
    for folder, folders, names in sorted(os.walk(data)):
        if "metadata.yaml" in names or any(name.endswith((".db3", ".3d")) or name == "scan_polar.csv" for name in names):
            folders.clear()
            yield folder
            continue
        yield from (os.path.join(folder, name) for name in sorted(names) if name.endswith(FILES))


def mapped(programs, recording, out, *options):
    """report.json of its map, or None and why there is none."""
    done = run(["nice", f"{programs}/marco-map", recording, "--out", out, *options])
    if done.returncode not in (0, 3):
        return None, done.stderr.strip().splitlines()[-1]
    with open(f"{out}/report.json", encoding="utf-8") as file:
        return json.load(file), ""


def events(path):
    """The head of each event of an LCM log, its channel and its bytes."""
    with open(path, "rb") as log:
        while len(head := log.read(28)) == 28:
            name_size, data_size = struct.unpack(">ii", head[20:])
            yield head, log.read(name_size).decode(), log.read(data_size)


def ranges_of(data):
    ranges = array.array("f", data[20:20 + 4 * struct.unpack_from(">i", data, 16)[0]])
    ranges.byteswap()
    return ranges


def write_noisy_copy(log, copy, seed):
    """An LCM log of ours with normal noise on each range that is a return. What stands for no return is left alone: 0, what
    is not finite, and the log's largest range where it stands more than a hundred times."""
    largest, times = 0.0, 0
    for _, channel, data in events(log):
        for r in ranges_of(data) if channel in LASERS else ():
            if r > largest and math.isfinite(r):
                largest, times = r, 0
            times += r == largest
    lost = largest if times > 100 else math.inf
    draw = random.Random(seed)
    with open(copy, "wb") as out:
        for head, channel, data in events(log):
            if channel in LASERS:
                ranges = ranges_of(data)
                for i, r in enumerate(ranges):
                    if 0.0 < r < lost:
                        ranges[i] = max(0.001, r + draw.gauss(0.0, NOISE_M))
                ranges.byteswap()
                data = data[:20] + ranges.tobytes() + data[20 + 4 * len(ranges):]
            out.write(head + channel.encode() + data)


def rms(distances):
    return math.sqrt(sum(d * d for d in distances) / len(distances)) if distances else math.inf


def true_poses_at(stamps, truth, late_s):
    """Interpolated where two true poses are half a second apart at most."""
    times = sorted(truth)
    found = {}
    for stamp in stamps:
        i = bisect.bisect(times, stamp + late_s)
        if 0 < i < len(times) and times[i] - times[i - 1] <= 0.5:
            part = (stamp + late_s - times[i - 1]) / (times[i] - times[i - 1])
            before, after = truth[times[i - 1]], truth[times[i]]
            found[stamp] = tuple((1 - part) * a + part * b for a, b in zip(before, after))
    return found


def judged(programs, path, relations, out):
    """(mean or rms, largest [m], heading [deg] or None) of a path, by relations or the true poses of the folder `out`; None
    without a reference."""
    if relations:
        said = run([f"{programs}/marco-evaluate", path, relations]).stdout
        found = re.search(r"mean=([\d.]+).*?max=([\d.]+).*?mean=([\d.]+)", said)
        return tuple(float(value) for value in found.groups()) if found else None
    if not os.path.exists(f"{out}/truth.tum"):
        return None
    with open(f"{out}/report.json", encoding="utf-8") as file:
        late_s = json.load(file)["errors"].get("true poses late_s", 0.0)
    ours = poses_of(path)
    off = distances_after_fit(ours, true_poses_at(ours, poses_of(f"{out}/truth.tum"), late_s))
    return (rms(off), max(off), None) if off else None


def moved(out, copy):
    """How far noise moved the path: rms [m] after the best fit in the plane."""
    return rms(distances_after_fit(poses_of(f"{copy}/trajectory.tum"), poses_of(f"{out}/trajectory.tum")))


def of_copies(programs, out, relations, copies, folder):
    """What judged() and moved() say of each noisy copy, and their verdicts."""
    errors, moves, verdicts = [], [], []
    for seed in range(1, copies + 1):
        write_noisy_copy(f"{out}/slam.lcm", f"{folder}/copy.lcm", seed)
        report, why = mapped(programs, f"{folder}/copy.lcm", f"{folder}/copy")
        if report is None:
            verdicts.append(why)
            continue
        verdicts.append(report.get("verdict", "none"))
        moves.append(moved(out, f"{folder}/copy"))
        errors.append(judged(programs, f"{folder}/copy/trajectory.tum", relations, out))
    return errors, moves, verdicts


def cost(report):
    return f"{report['cpu_s']:.1f} | {report['peak_memory_mb']:.0f}"


def counted(words):
    return ", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(words))


def error_cell(error):
    return f"{error[0]:.4f} ({error[1]:.3f})" + (f", {error[2]:.2f}°" if error[2] is not None else "")


def rows_of(options, recording, data, folder):
    """A row of the table with references, a row of the one without, or a line of what could not be mapped."""
    name, out = os.path.relpath(recording, data), f"{folder}/map"
    relations = os.path.splitext(recording)[0] + ".relations"
    relations = relations if os.path.exists(relations) else None
    report, why = mapped(options.programs, recording, out)
    if report is None:
        return ("without", None) if "no laser" in why else ("failed", f"* `{name}`: {why}")
    scans = f"`{name}` | {report['scans']['posed']} | {report['distance_m']:.0f}"
    errors, moves, verdicts = of_copies(options.programs, out, relations, options.copies, folder)
    final = judged(options.programs, f"{out}/trajectory.tum", relations, out)
    if final is None:
        of_noise = f"{max(moves):.3f}" if moves else "-"
        doctor = report.get("doctor", {})
        doubts = [reason["cause"].replace("_", " ") for reason in doctor.get("reasons", [])]
        doubts = "; ".join(dict.fromkeys(doubts or ["open question"] * bool(doctor.get("open_questions"))))
        return "without", (f"| {scans} | {report['scans']['matched'] / max(1, report['scans']['level']):.1%} | {len(report['loops'])} | "
                           f"{report.get('verdict', '-')}{f' ({doubts})' if doubts else ''} | {of_noise} | {counted(verdicts)} | {cost(report)} |")
    good = [error[0] for error in errors if error]
    spread = f"{sum(good) / len(good):.4f}, {min(good):.4f} to {max(good):.4f}" if good else "-"
    odometry = judged(options.programs, f"{out}/odometry.tum", relations, out)
    live = judged(options.programs, f"{out}/trajectory_live.tum", relations, out)
    return "with", (f"| {scans} | {error_cell(odometry) if odometry else '-'} | {error_cell(live)} | {error_cell(final)} | {spread} | "
                    f"{report.get('verdict', '-')} | {cost(report)} |")


def simulated_rows(options, data, folder):
    tours = [(world, f"{ROOT}/config/tours/{world}.toml") for world in ("lab", "office", "foyer")]
    tours += [(os.path.basename(path).split("_")[0], path) for path in sorted(glob.glob(f"{data}/tours/*.toml") if data else [])]
    for world, tour in tours:
        name, world_file = os.path.basename(tour)[:-5], f"{ROOT}/config/worlds/{world}.toml"
        done = run(["nice", f"{options.programs}/marco-simulate", "--world", world_file, "--tour", tour, "--seed", "1",
                    "--out", f"{folder}/simulated.lcm"])
        if done.returncode != 0:
            yield f"| {name} | {done.stderr.strip()} |"
            continue
        report, why = mapped(options.programs, f"{folder}/simulated.lcm", f"{folder}/map", "--world", world_file)
        if report is None:
            yield f"| {name} | {why} |"
            continue
        errors = report["errors"]
        model = " | ".join(f"{1000 * errors[key]:.1f}" if (key := f"model error {of}_m") in errors else "-" for of in ("rms", "p95", "p99"))
        yield (f"| {name} | {report['scans']['posed']} | {report['distance_m']:.0f} | {errors['odometry error rms_m']:.2f} | "
               f"{1000 * errors['path error rms_m']:.1f} ({1000 * errors['path error max_m']:.1f}) | "
               f"{1000 * errors['map error rms_m']:.1f} | {model} | {report['verdict']} | {cost(report)} |")


def machine(programs):
    lscpu = dict(line.split(":", 1) for line in run(["lscpu"]).stdout.splitlines() if ":" in line)
    version = run([f"{programs}/marco-map", "--version"]).stdout.strip()
    return f"{version}, on {os.cpu_count()} cores of {lscpu.get('Model name', 'an unknown processor').strip()}; one run at a time."


def table(head, rows):
    if not rows:
        return ""
    columns = head.count("|") - 1
    return f"\n{head}\n{'|---' * columns}|\n" + "".join(row + "\n" for row in rows)


def measured(options):
    data = os.environ.get("MARCO_TEST_DATA")
    rows = {"with": [], "without": [], "failed": []}
    with tempfile.TemporaryDirectory() as folder:
        for recording in recordings(data) if data else []:
            if options.only in os.path.relpath(recording, data):
                kind, row = rows_of(options, recording, data, folder)
                if row:
                    rows[kind].append(row)
                    print(row, file=sys.stderr, flush=True)
        simulated = [] if options.only else list(simulated_rows(options, data, folder))
    text = machine(options.programs) + "\n"
    if not data:
        text += "\nSKIPPED: recordings, for MARCO_TEST_DATA is not set.\n"
    copies = f"{options.copies} noisy copies"
    text += table(f"| recording | scans | driven [m] | odometry | live path | final path | of {copies}: mean, min to max | verdict | CPU [s] | MB |", rows["with"])
    text += table(f"| recording | scans | driven [m] | matched | loops | verdict | {copies} move the path by at most [m] | their verdicts | CPU [s] | MB |", rows["without"])
    if rows["failed"]:
        text += "\nNot mapped:\n\n" + "".join(row + "\n" for row in rows["failed"])
    return text + table("| simulated tour | scans | driven [m] | odometry rms [m] | path rms (max) [mm] | map rms [mm] | model rms [mm] | p95 | p99 | verdict | CPU [s] | MB |", simulated)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--only", default="")
    parser.add_argument("--copies", type=int, default=10)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    if options.write and (options.only or options.copies != 10 or "MARCO_TEST_DATA" not in os.environ):
        parser.error("--write takes all recordings: MARCO_TEST_DATA set, no --only, no --copies")
    text = measured(options)
    if not options.write:
        print(text, end="")
        return 0
    with open(PAGE, encoding="utf-8") as page:
        before, _, rest = page.read().partition(BEGIN)
    with open(PAGE, "w", encoding="utf-8") as page:
        page.write(before + BEGIN + text + END + rest.partition(END)[2])
    return 0


if __name__ == "__main__":
    sys.exit(main())
