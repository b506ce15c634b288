#!/usr/bin/env python3
"""What a scan costs, and what is held, as a recording grows: the office's tour once, twice, four and ten times.

usage: growth.py FOLDER_OF_PROGRAMS [--rounds 1,2,4,10] [--keep FOLDER]

Batch: `marco-map` keeps every keyframe of a recording, so its memory grows with the recording. (What a live SLAM keeps
follows the place: `marco soak`.) Exit code 1 when a scan of the longest recording costs over 10 % more than one of the
second: in the first round nothing is seen again, so no loop is looked at.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")


def log_of(programs, folder, rounds):
    """The tour's steps `rounds` times; it ends near its start, and goes there between two rounds."""
    log = os.path.join(folder, f"rounds.{rounds}.lcm")
    if os.path.exists(log):
        return log
    with open(f"{ROOT}/config/tours/office.toml", encoding="utf-8") as file:
        text = file.read()
    start = text.index("[[steps]]")
    home = text[text.index("start_m"):].splitlines()[0].replace("start_m", "to_m")
    tour = os.path.join(folder, f"rounds.{rounds}.toml")
    with open(tour, "w", encoding="utf-8") as file:
        file.write(text[:start] + (text[start:] + f"\n[[steps]]\n{home}\n") * (rounds - 1) + text[start:])
    run([f"{programs}/marco-simulate", "--world", f"{ROOT}/config/worlds/office.toml", "--tour", tour, "--seed", "1",
         "--out", log + ".part"])
    os.rename(log + ".part", log)
    return log


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--rounds", default="1,2,4,10")
    parser.add_argument("--keep")
    options = parser.parse_args()
    print("rounds   scans  keys  match [us/scan]  optimize [us/scan]  memory [MB]  rms [mm]", flush=True)
    costs = {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        for rounds in map(int, options.rounds.split(",")):
            log, out = log_of(options.programs, folder, rounds), os.path.join(folder, f"rounds.{rounds}")
            run([f"{options.programs}/marco-map", log, "--out", out])
            if not options.keep:
                os.remove(log)
            with open(os.path.join(out, "report.json"), encoding="utf-8") as file:
                report = json.load(file)
            scans = report["scans"]["posed"]
            stage = {stage["name"].split()[0]: 1e6 * stage["cpu_s"] / scans for stage in report["stages"]}
            costs[rounds] = stage["read"] + stage["optimize"]
            print(f"{rounds:6} {scans:7} {report['scans']['keyframes']:5} {stage['read']:16.1f} {stage['optimize']:19.1f} "
                  f"{report['peak_memory_mb']:12.1f} {1e3 * report['errors']['path error rms_m']:9.1f}", flush=True)
    first, last = sorted(costs)[min(1, len(costs) - 1)], max(costs)
    growth = costs[last] / costs[first] - 1.0
    print(f"a scan of {last} rounds costs {100 * growth:+.1f} % of one of {first} (goal: at most +10)")
    return 1 if growth > 0.10 else 0


if __name__ == "__main__":
    sys.exit(main())
