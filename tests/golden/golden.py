#!/usr/bin/env python3
"""Whether the maps of all recordings are what they were: their figures beside those in figures.json.

usage: golden.py FOLDER_OF_PROGRAMS [--write] [--jobs N] [--figures FILE] [NAME...]

  --write      keeps today's figures, of every recording that can be mapped, or of those named
  --jobs N     maps at a time (as many as there are processors); live runs have the machine to themselves
  NAME         recordings whose name begins so; a recording is named by its path below MARCO_TEST_DATA

Exit code 1: a figure moved. `./marco test --golden` calls this. Files are compared byte for byte, by the first 16 letters of
their SHA-256. CPU time is told and not compared. Live runs are not the same twice: their figures may move by
LIVE_BOUNDS.
"""
import argparse
import concurrent.futures
import json
import os
import subprocess
import sys

import entries
from map_figures import NotMapped

FIGURES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "figures.json")
NOT_COMPARED = ("cpu_s",)
MACHINE = "machine"
LIVE_PART = 0.15  # of how long it drove, and how far: the robot waits where something is late
LIVE_BOUNDS = {
    "errors.path error rms_m": 0.01, "errors.path error max_m": 0.03, "errors.odometry error rms_m": 0.1,
    "errors.map error rms_m": 0.01, "errors.map error p95_m": 0.02, "errors.map error p99_m": 0.05, "live_from_batch_m": 0.02}


def machine():
    """What floating point depends on, though it should not: shown where it is another one than the figures' own."""
    compiler = subprocess.run(["c++", "--version"], capture_output=True, text=True, check=False).stdout.splitlines()
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        processor = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), "unknown")
    return {"compiler": compiler[0] if compiler else "unknown", "processor": processor}


def flat(figures, before=""):
    """{"a": {"b": 1}} as {"a.b": 1}."""
    result = {}
    for key, value in figures.items():
        result.update(flat(value, f"{before}{key}.") if isinstance(value, dict) else {before + key: value})
    return result


def is_within(name, key, before, now):
    if before == now:
        return True
    numbers = isinstance(before, (int, float)) and isinstance(now, (int, float))
    return name.startswith("live/") and numbers and abs(now - before) <= LIVE_BOUNDS.get(key, LIVE_PART * before)


def moved(name, before, now):
    """(figure, before, now) of each that moved."""
    before, now = flat(before), flat(now)
    keys = [*before, *(key for key in now if key not in before)]
    return [(key, before.get(key), now.get(key)) for key in keys
            if key not in NOT_COMPARED and not is_within(name, key, before.get(key), now.get(key))]


def shown(value):
    return "-" if value is None else value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def row(key, before, now):
    numbers = all(isinstance(value, (int, float)) for value in (before, now))
    return f"  {key:34} {shown(before)}  ->  {shown(now)}{f'  ({now - before:+.4g})' if numbers else ''}"


def cpu_of(figures):
    return f"{figures['cpu_s']} s of CPU" if "cpu_s" in figures else "done"


def computed(programs, data, names, jobs):
    """Yields (name, figures, or why there are none) as they come."""
    def one(name):
        try:
            return name, entries.figures_of(programs, data, name)
        except NotMapped as why:
            return name, {"not mapped": str(why)}

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        results = [pool.submit(one, name) for name in names if name not in entries.LIVE]
        for done in concurrent.futures.as_completed(results):
            yield done.result()
    yield from (one(name) for name in names if name in entries.LIVE)


def chosen(options, known, data):
    """The names to compute, of those that are known or, to write, there may be; and how many need data that is not here."""
    names = list(dict.fromkeys([*entries.all_names(data), *known])) if options.write else list(known)
    for word in options.names:
        if not any(name.startswith(word) for name in names):
            sys.exit(f"golden: no recording begins with {word}")
    names = [name for name in names if not options.names or any(name.startswith(word) for word in options.names)]
    here = [name for name in names if data or name.startswith(entries.OF_US)]
    return here, len(names) - len(here)


def compare(known, now):
    """@returns how many recordings moved."""
    count = 0
    for name in sorted(now):
        figures = moved(name, known[name], now[name])
        if figures:
            count += 1
            print(name)
            print("\n".join(row(*figure) for figure in figures))
    return count


def write(path, known, now):
    kept = {**known, **{name: figures for name, figures in now.items() if name in known or "not mapped" not in figures}}
    kept[MACHINE] = machine()
    with open(path, "w", encoding="utf-8") as file:
        json.dump(kept, file, indent=1, sort_keys=True, ensure_ascii=False)
        file.write("\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--figures", default=FIGURES)
    options = parser.parse_intermixed_args()
    known = {}
    if os.path.exists(options.figures):
        with open(options.figures, encoding="utf-8") as file:
            known = json.load(file)
    of_machine = known.pop(MACHINE, None)
    data = os.environ.get("MARCO_TEST_DATA")
    names, missing = chosen(options, known, data)
    now = {}
    for name, figures in computed(os.path.abspath(options.programs), data, names, options.jobs):
        print(f"{name}: {figures.get('not mapped') or cpu_of(figures)}", file=sys.stderr, flush=True)
        now[name] = figures
        if options.write:
            write(options.figures, known, now)
    if missing:
        print(f"SKIPPED: {missing} recordings: MARCO_TEST_DATA is not set")
    if options.write:
        return 0
    count = compare(known, now)
    if count and of_machine != machine():
        print(f"the figures kept are of another machine: {of_machine}; this one: {machine()}")
    print(f"golden: {len(now)} recordings, {count} moved")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
