#!/usr/bin/env python3
"""Small rovers where truth is exact: what each thing that their recordings say wrongly costs the map's path.

usage: rovers.py FOLDER_OF_PROGRAMS [options]

  --presets a,b          default: rover_5hz,rover_7hz
  --variants a,b,...     default: all of VARIANTS
  --seeds N              default 3
  --beside FOLDER        another marco-map, run on the same logs
  --config TOML          for the first marco-map
  --keep FOLDER          logs and maps stay there, and logs are simulated only once
  --jobs N               at once (default 2)

A row a preset and variant: rms of the path against the true poses after the best fit in the plane, of every seed [m],
the largest distance of all [m], the mean share of scans with a pose, CPU time [s], and the map's verdict of every seed
(g = good or doubtful, W = wrong).
"""
import argparse
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# World and tour, and what is laid over the preset. Of `empty_foyer` nobody walks.
VARIANTS = {
    "right": ("flat", {}),
    "milliseconds": ("flat", {"logger": {"beam_times": "milliseconds"}}),
    "reversed": ("flat", {"logger": {"beam_times": "reversed"}}),
    "equal": ("flat", {"logger": {"beam_times": "equal"}}),
    "missing": ("flat", {"logger": {"beam_times": "missing"}}),
    "drift": ("flat", {"logger": {"clock_drift": 0.004}}),
    "still": ("flat", {"robot": {"odometry": "still"}}),
    "gyro": ("flat", {"robot": {"odometry": "gyro"}}),
    "gyro_drift": ("flat", {"logger": {"clock_drift": 0.004}, "robot": {"odometry": "gyro"}}),
    "wheels": ("flat", {"robot": {"odometry": "wheels"}}),
    "empty_foyer": ("foyer", {}),
    "people": ("foyer", {}),
    "all_wrong": ("foyer", {"logger": {"beam_times": "milliseconds", "clock_drift": 0.004}, "robot": {"odometry": "still"}}),
}


def run(command):
    return subprocess.run(command, capture_output=True, text=True)


def toml_of(sections):
    # JSON writes numbers and plain text as TOML does.
    return "".join(f"[{name}]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())
                   for name, keys in sections.items())


def world_of(variant, log):
    world = f"{ROOT}/config/worlds/{VARIANTS[variant][0]}.toml"
    if variant != "empty_foyer":
        return world
    with open(world, encoding="utf-8") as file:
        standing = file.read().split("[[people]]")[0]
    with open(log + ".world.toml", "w", encoding="utf-8") as file:
        file.write(standing)
    return log + ".world.toml"


def simulated(options, folder, preset, variant, seed):
    log = os.path.join(folder, f"{preset}.{variant}.{seed}.lcm")
    if os.path.exists(log):
        return log
    place, over = VARIANTS[variant]
    config = log + ".toml"
    with open(config, "w", encoding="utf-8") as file:
        file.write(toml_of(over))
    part = log + ".part"
    done = run([f"{options.programs}/marco-simulate", "--world", world_of(variant, log),
                "--tour", f"{ROOT}/config/tours/{place}.toml", "--preset", preset, "--config", config,
                "--seed", str(seed), "--out", part])
    if done.returncode != 0:
        sys.exit(done.stdout + done.stderr)
    os.rename(part, log)
    return log


def mapped(options, folder, log, by):
    """(rms, largest, scans with a pose, CPU seconds, exit code) or None."""
    programs, config = (options.beside, None) if by else (options.programs, options.config)
    out = os.path.join(folder, os.path.basename(log)[:-4] + ("." + by if by else ""))
    done = run([f"{programs}/marco-map", log, "--out", out, *(["--config", config] if config else [])])
    if done.returncode not in (0, 3):
        return None
    said = run([f"{options.programs}/marco-evaluate", f"{out}/trajectory.tum", "--truth", log])
    found = re.search(r"n=(\d+) .*?rms=([\d.]+) max=([\d.]+)", said.stdout)
    with open(os.path.join(out, "report.json"), encoding="utf-8") as file:
        cpu_s = json.load(file)["cpu_s"]
    return (float(found[2]), float(found[3]), int(found[1]), cpu_s, done.returncode) if found else None


def scans_of(log):
    """How many TRUE_POSE events: one a scan."""
    with open(log, "rb") as file:
        return file.read().count(b"TRUE_POSE")


def one(options, folder, preset, variant, seed):
    log = simulated(options, folder, preset, variant, seed)
    scans = scans_of(log)
    results = {by: mapped(options, folder, log, by) for by in (["", "beside"] if options.beside else [""])}
    if not options.keep:
        os.remove(log)
    return scans, results


def row(results):
    """@param results  of every seed: scans, and what mapped() gave"""
    good = [(scans, r) for scans, r in results if r]
    rms = " ".join(f"{r[0]:7.3f}" if r else " failed" for _, r in results)
    if not good:
        return rms
    n = len(good)
    return (f"{rms}  {max(r[1] for _, r in good):7.3f} {sum(r[2] / scans for scans, r in good) / n:6.2f}"
            f" {sum(r[3] for _, r in good) / n:6.1f}  {''.join('-' if not r else 'W' if r[4] == 3 else 'g' for _, r in results)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--presets", default="rover_5hz,rover_7hz")
    parser.add_argument("--variants", default=",".join(VARIANTS))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--beside")
    parser.add_argument("--config")
    parser.add_argument("--keep")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary, concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        seeds = range(1, options.seeds + 1)
        heads = " ".join(f"{f'seed {seed}':>7}" for seed in seeds)
        print(f"{'preset':10} {'variant':13} {'by':7} {heads}  {'max':>7} {'posed':>6} {'cpu_s':>6}  verdicts", flush=True)
        for preset in options.presets.split(","):
            for variant in options.variants.split(","):
                done = list(pool.map(lambda seed, p=preset, v=variant: one(options, folder, p, v, seed), seeds))
                for by in done[0][1]:
                    print(f"{preset:10} {variant:13} {by:7} {row([(scans, r[by]) for scans, r in done])}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
