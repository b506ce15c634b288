#!/usr/bin/env python3
"""How good a live pose can be: at sampled relations, the error of the poses as first published, of those that a map made
of everything until then ends with, and of the final ones. A live pose cannot be expected to beat a whole map of all that
was recorded until then.

usage: live_bound.py FOLDER_OF_PROGRAMS LOG RELATIONS [--relations 100] [--jobs 2]

LOG is a CARMEN log. Mean and largest translation error, m, of the relations that all three know; then of those alone
whose two times are more than 60 s apart.
"""
import argparse
import concurrent.futures
import math
import os
import subprocess
import sys
import tempfile

TOLERANCE_S = 2e-6


def poses_of(path):
    with open(path, encoding="utf-8") as file:
        rows = [[float(v) for v in line.split()] for line in file if line.strip() and not line.startswith("#")]
    return [(r[0], r[1], r[2], math.atan2(2 * r[7] * r[6], 1 - 2 * r[6] * r[6])) for r in rows]


def pose_at(poses, time_s):
    pose = min(poses, key=lambda p: abs(p[0] - time_s))
    return pose if abs(pose[0] - time_s) < TOLERANCE_S else None


def error_m(a, b, relation):
    """Of pose `b` seen from pose `a`."""
    dx, dy = b[1] - a[1], b[2] - a[2]
    x, y = math.cos(a[3]) * dx + math.sin(a[3]) * dy, -math.sin(a[3]) * dx + math.cos(a[3]) * dy
    return math.hypot(x - relation[2], y - relation[3])


def mapped(programs, log, out):
    done = subprocess.run([f"{programs}/marco-map", log, "--out", out], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(done.stderr)
    return out


def last_pose(programs, lines, until_s, folder):
    """Of a map of the log until then."""
    log = os.path.join(folder, f"until_{until_s:.6f}.log")
    with open(log, "w", encoding="utf-8") as file:
        for stamp, line in lines:
            if stamp is None or stamp <= until_s + TOLERANCE_S:
                file.write(line)
    out = mapped(programs, log, log + ".map")
    os.remove(log)
    return pose_at(poses_of(os.path.join(out, "trajectory.tum")), until_s)


def stamped(line):
    words = line.split()
    return (float(words[-3]) if words and words[0] in ("FLASER", "ODOM") else None), line


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("log")
    parser.add_argument("relations")
    parser.add_argument("--relations", dest="count", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    with open(options.relations, encoding="utf-8") as file:
        relations = [[float(v) for v in line.split()] for line in file if line.strip()]
    step = max(1, len(relations) // options.count)
    relations = relations[::step]
    with open(options.log, encoding="utf-8") as file:
        lines = [stamped(line) for line in file]
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        whole = mapped(options.programs, options.log, os.path.join(folder, "whole"))
        times = sorted({t for r in relations for t in r[:2]})
        found = dict(zip(times, pool.map(lambda t: last_pose(options.programs, lines, t, folder), times)))
        of = {"live": poses_of(os.path.join(whole, "trajectory_live.tum")),
              "final": poses_of(os.path.join(whole, "trajectory.tum"))}
        rows = []
        for r in relations:
            pairs = {name: (pose_at(poses, r[0]), pose_at(poses, r[1])) for name, poses in of.items()}
            pairs["until then"] = (found[r[0]], found[r[1]])
            if all(a and b for a, b in pairs.values()):
                rows.append((r[1] - r[0], {name: error_m(a, b, r) for name, (a, b) in pairs.items()}))
    for title, chosen in (("all", rows), ("over 60 s", [row for row in rows if row[0] > 60])):
        for name in ("live", "until then", "final"):
            errors = [row[1][name] for row in chosen]
            if errors:
                print(f"{title:10} {name:10} n={len(errors)} mean={sum(errors) / len(errors):.4f} max={max(errors):.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
