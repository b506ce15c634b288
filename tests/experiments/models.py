#!/usr/bin/env python3
"""The 3D model of simulated worlds, each a row: simulated, mapped, and its written model judged.

usage: models.py FOLDER_OF_PROGRAMS [--worlds lab,office,random] [--seeds 3] [--keep FOLDER] [--config TOML]

lab: config/worlds/lab.toml, its own tour. office: three stops about a room, the door and the corridor of
config/worlds/office.toml. random: a room of another shape, with other furniture, by seed.
Exit code 1 when a goal is missed: rms <= 8 mm, p99 <= 30 mm, >= 97 % covered, no two sheets over 20 mm apart.
"""
import argparse
import os
import random
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SWEEP = '[[steps]]\nkind = "sweep"\npans_deg = [0, 90, 180, 270]\n'


def tour(start_m, stops):
    """Sweeps at the start, and at the end of each way of points."""
    lines = [f"start_m = {start_m}\nstart_heading_deg = 0\n[[steps]]\nkind = \"wait\"\nseconds = 1.0\n", SWEEP]
    for way in stops:
        lines += [f"[[steps]]\nto_m = {point}\n" for point in way] + [SWEEP]
    return "".join(lines + ['[[steps]]\nkind = "wait"\nseconds = 1.0\n'])


def random_world(seed):
    """A room of 9-13 m x 7-9 m with a recess, walls that are not square, and boxes, tables and columns off the way
    down its middle."""
    draw = random.Random(seed)
    width, depth = round(draw.uniform(9, 13), 2), round(draw.uniform(7, 9), 2)
    skew = round(draw.uniform(0.3, 0.9), 2)
    text = f"""floor_m = [-1, -1, {width + 1}, {depth + 1}]
ceiling_m = {round(draw.uniform(2.4, 3.2), 2)}
[[walls]]
corners_m = [0, 0, {width}, {skew}, {width - skew}, {depth}, {width * 0.6:.2f}, {depth}, {width * 0.6:.2f}, {depth - 1.3:.2f}, {width * 0.4:.2f}, {depth - 1.3:.2f}, {width * 0.4:.2f}, {depth}, {skew}, {depth - skew}, 0, 0]
"""
    for i in range(10):
        x, yaw = round(draw.uniform(1.5, width - 1.5), 2), round(draw.uniform(0, 180), 1)
        y = round(draw.uniform(0.9, 1.6) if i % 2 == 0 else depth - draw.uniform(2.4, 3.0), 2)
        if i % 3 == 0:
            text += f"[[boxes]]\nat_m = [{x}, {y}]\nsize_m = [{draw.uniform(.3, 1.2):.2f}, {draw.uniform(.3, .8):.2f}, {draw.uniform(.3, 2):.2f}]\nyaw_deg = {yaw}\n"
        elif i % 3 == 1:
            text += f"[[tables]]\nat_m = [{x}, {y}]\nsize_m = [{draw.uniform(.6, 1.8):.2f}, {draw.uniform(.5, .9):.2f}]\nyaw_deg = {yaw}\n"
        else:
            text += f"[[columns]]\nat_m = [{x}, {y}]\nradius_m = {draw.uniform(.1, .3):.2f}\nheight_m = 2.4\n"
    middle = round(depth * 0.46, 2)
    return text, tour([2.0, middle], [[[round(width / 2, 2), middle]], [[round(width - 2.5, 2), middle]]])


def described(world, seed, folder):
    """Files of a world and a tour."""
    if world == "lab":
        return f"{ROOT}/config/worlds/lab.toml", f"{ROOT}/config/tours/lab.toml"
    if world == "office":
        text, way = None, tour([4.0, 3.3], [[[4.0, 7.0]], [[8.0, 7.0]]])
    else:
        text, way = random_world(seed)
    names = [os.path.join(folder, f"{world}.{seed}.{what}.toml") for what in ("world", "tour")]
    for name, content in zip(names, (text, way)):
        if content:
            with open(name, "w", encoding="utf-8") as file:
                file.write(content)
    return names[0] if text else f"{ROOT}/config/worlds/office.toml", names[1]


def run(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def one(options, folder, world, seed):
    log, out = (os.path.join(folder, f"{world}.{seed}{end}") for end in (".lcm", ""))
    world_file, tour_file = described(world, seed, folder)
    if not os.path.exists(log):
        run([f"{options.programs}/marco-simulate", "--world", world_file, "--tour", tour_file, "--seed", str(seed),
             "--out", log + ".part"])
        os.rename(log + ".part", log)
    run([f"{options.programs}/marco-map", log, "--out", out] + (["--config", options.config] if options.config else []))
    return run([f"{options.programs}/marco-evaluate-model", f"{out}/model.ply", world_file, "--beams", log,
                "--trajectory", f"{out}/trajectory.tum"])


def missed(judged):
    """The goals that a judgement misses, in words."""
    def number(pattern):
        return float(re.search(pattern, judged)[1])
    figures = (("rms [m]", number(r"\nerror: .* rms=([\d.]+)"), 0.008),
               ("p99 [m]", number(r"\nerror: .* p99=([\d.]+)"), 0.030),
               ("not covered [%]", 100.0 - number(r"coverage: ([\d.]+) %"), 3.0),
               ("sheets apart [m]", number(r"sheets .* max=([\d.]+)"), 0.020))
    return [f"{name} {value:.3f} > {goal}" for name, value, goal in figures if value > goal]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("programs")
    parser.add_argument("--worlds", default="lab,office,random")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--keep")
    parser.add_argument("--config")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        any_missed = False
        for world in options.worlds.split(","):
            for seed in range(1, options.seeds + 1):
                judged = one(options, folder, world, seed)
                goals = missed(judged)
                any_missed = any_missed or bool(goals)
                print(f"== {world} {seed}\n{judged}missed: {', '.join(goals) or 'nothing'}", flush=True)
    sys.exit(1 if any_missed else 0)


if __name__ == "__main__":
    main()
