#!/usr/bin/env python3
"""Walls of the line SLAM that were drawn twice.

usage: lines.py FOLDER_OF_PROGRAMS LOG...

A row a recording: walls, their length in all [m], the share of that length [%] beside which another wall lies that
faces the same way (within 15 degrees) and is less than 0.3 m off, the share of scans with a wall that matched [%], the
map's verdict, CPU time [s], and where a file of relations lies beside the log, the mean error of the path [m].
"""
import json
import math
import os
import subprocess
import sys
import tempfile

NEAR_M, SAME_FACING = 0.3, math.cos(math.radians(15))
STEP_M = 0.02


def doubled_m(walls):
    """Length of the walls, and what of it lies beside another one [m]."""
    pieces = []
    for wall in walls:
        (ax, ay), (bx, by) = wall["start_m"], wall["end_m"]
        length = math.hypot(bx - ax, by - ay)
        if length > 0.0:
            pieces.append((ax, ay, (bx - ax) / length, (by - ay) / length, length))

    def is_beside(x, y, wall, other):
        ax, ay, ux, uy, length = other
        along, across = ux * (x - ax) + uy * (y - ay), ux * (y - ay) - uy * (x - ax)
        return 0 < along < length and abs(across) < NEAR_M and wall[2] * ux + wall[3] * uy > SAME_FACING

    doubled = 0.0
    for wall in pieces:
        count = max(2, round(wall[4] / STEP_M))
        hits = 0
        for i in range(count):
            along = (i + 0.5) / count * wall[4]
            x, y = wall[0] + along * wall[2], wall[1] + along * wall[3]
            hits += any(is_beside(x, y, wall, other) for other in pieces if other is not wall)
        doubled += hits / count * wall[4]
    return sum(wall[4] for wall in pieces), doubled


def relations_beside(log):
    path = os.path.splitext(log)[0] + ".relations"
    return path if os.path.exists(path) else None


def row(programs, log, out):
    subprocess.run([f"{programs}/marco-map", log, "--lines", "--out", out], stdout=subprocess.DEVNULL, check=False)
    with open(f"{out}/report.json", encoding="utf-8") as file:
        report = json.load(file)
    with open(f"{out}/lines.json", encoding="utf-8") as file:
        length, doubled = doubled_m(json.load(file)["walls"])
    error = ""
    if relations := relations_beside(log):
        error = subprocess.run([f"{programs}/marco-evaluate", f"{out}/trajectory.tum", relations],
                               capture_output=True, text=True, check=True).stdout.split("mean=")[1].split()[0]
    matched = 100 * report["scans"]["matched"] / max(1, report["scans"]["level"])
    return (f"{os.path.basename(log):28} {report['walls']:6} {length:9.1f} {100 * doubled / max(1e-9, length):8.1f} "
            f"{matched:8.0f} {report['verdict']:>9} {report['cpu_s']:7.1f} {error:>8}")


def main():
    programs, logs = sys.argv[1], sys.argv[2:]
    print(f"{'log':28} {'walls':>6} {'length':>9} {'doubled':>8} {'matched':>8} {'verdict':>9} {'CPU':>7} {'path':>8}")
    for log in logs:
        with tempfile.TemporaryDirectory() as out:
            print(row(programs, log, out), flush=True)


if __name__ == "__main__":
    main()
