#!/usr/bin/env python3
"""Posts and curved walls that the line SLAM finds.

usage: circles.py FOLDER_OF_PROGRAMS [--seeds 3] [LOG...]

A row a simulated drive (config/worlds/rotunda.toml and office.toml, where the truth is known): columns found of
columns, posts where neither a column nor a table's leg stands, the largest error of a centre and of a radius [mm],
faces of curved walls found of faces, walls of another radius, and their largest errors. Then a row a recording: posts,
pieces of curved walls, CPU time [s].
"""
import argparse
import json
import math
import os
import subprocess
import tempfile
import tomllib

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
POST_M, NEAR_M, LEG_M = 0.5, 0.3, 0.05  # a leg: as in simulator/world.cpp


def poses(path):
    with open(path, encoding="utf-8") as file:
        rows = [line.split() for line in file if line.strip() and not line.startswith("#")]
    return {row[0]: (float(row[1]), float(row[2])) for row in rows}


def world_from_map(out):
    """The rotation and shift that bring the path onto the truth with least squares."""
    made, truth = poses(f"{out}/trajectory.tum"), poses(f"{out}/truth.tum")
    pairs = [(made[t], truth[t]) for t in made if t in truth]
    count = len(pairs)
    (ax, ay), (bx, by) = [[sum(p[k][i] for p in pairs) / count for i in (0, 1)] for k in (0, 1)]
    dot = sum((a[0] - ax) * (b[0] - bx) + (a[1] - ay) * (b[1] - by) for a, b in pairs)
    cross = sum((a[0] - ax) * (b[1] - by) - (a[1] - ay) * (b[0] - bx) for a, b in pairs)
    turn = math.atan2(cross, dot)
    c, s = math.cos(turn), math.sin(turn)
    return lambda p: (c * (p[0] - ax) - s * (p[1] - ay) + bx, s * (p[0] - ax) + c * (p[1] - ay) + by)


def truth_of(world):
    """Columns, and faces of bent walls: centre, radius, seen from inside."""
    columns = [(*c["at_m"], c.get("radius_m", 0.2), False) for c in world.get("columns", [])]
    faces = []
    for arc in world.get("arcs", []):
        half = 0.5 * arc.get("thickness_m", 0.12)
        faces.append((*arc["centre_m"], arc["radius_m"] - half, True))
        faces.append((*arc["centre_m"], arc["radius_m"] + half, False))
    return columns, faces


def legs_of(world):
    for table in world.get("tables", []):
        (x, y), yaw = table["at_m"], math.radians(table.get("yaw_deg", 0.0))
        w, d = (0.5 * (size - LEG_M) for size in table.get("size_m", (1.4, 0.8)))
        for a, b in ((-w, -d), (-w, d), (w, -d), (w, d)):
            yield x + a * math.cos(yaw) - b * math.sin(yaw), y + a * math.sin(yaw) + b * math.cos(yaw)


def is_leg(post, legs):
    return post[2] <= 1.5 * LEG_M and any(math.hypot(post[0] - x, post[1] - y) < 2 * LEG_M for x, y in legs)


def compare(found, truth):
    """@returns how many of the true ones were found, how many of the found ones are none, largest errors [mm]."""
    hits, wrong, centre, radius = set(), set(), 0.0, 0.0
    for x, y, r, inside, number in found:
        near = [k for k, t in enumerate(truth)
                if t[3] == inside and math.hypot(x - t[0], y - t[1]) < NEAR_M and abs(r - t[2]) < 0.05]
        if not near:
            wrong.add(number)
            continue
        best = min(near, key=lambda k: math.hypot(x - truth[k][0], y - truth[k][1]) + abs(r - truth[k][2]))
        hits.add(best)
        centre = max(centre, math.hypot(x - truth[best][0], y - truth[best][1]))
        radius = max(radius, abs(r - truth[best][2]))
    return f"{len(hits):3} of {len(truth):2}  {len(wrong):6}  {1000 * centre:6.1f}  {1000 * radius:6.1f}"


def map_lines(programs, log, out):
    subprocess.run([f"{programs}/marco-map", log, "--lines", "--out", out], stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL, check=False)
    with open(f"{out}/lines.json", encoding="utf-8") as file:
        return json.load(file)["round_walls"]


def simulated(programs, name, seed, folder):
    log, out = f"{folder}/{name}.{seed}.lcm", f"{folder}/{name}.{seed}"
    world_file = f"{ROOT}/config/worlds/{name}.toml"
    subprocess.run([f"{programs}/marco-simulate", "--world", world_file, "--tour", f"{ROOT}/config/tours/{name}.toml",
                    "--seed", str(seed), "--out", log], stdout=subprocess.DEVNULL, check=True)
    walls = map_lines(programs, log, out)
    place = world_from_map(out)
    found = [(*place(w["centre_m"]), w["radius_m"], w["from_inside"], w["id"]) for w in walls]
    with open(world_file, "rb") as file:
        world = tomllib.load(file)
    columns, faces = truth_of(world)
    legs = list(legs_of(world))
    found = [f for f in found if not is_leg(f, legs)]
    os.remove(log)
    print(f"{name:10} {seed:4}  {compare([f for f in found if f[2] <= POST_M], columns)}   "
          f"{compare([f for f in found if f[2] > POST_M], faces)}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("logs", nargs="*")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print("world      seed  columns    none  centre  radius   faces      none  centre  radius")
        for name in ("rotunda", "office"):
            for seed in range(1, options.seeds + 1):
                simulated(options.programs, name, seed, folder)
        for log in options.logs:
            out = f"{folder}/log"
            walls = map_lines(options.programs, log, out)
            posts = sum(w["radius_m"] <= POST_M for w in walls)
            with open(f"{out}/report.json", encoding="utf-8") as file:
                cpu_s = json.load(file)["cpu_s"]
            print(f"{os.path.basename(log):24} {posts:4} posts {len(walls) - posts:4} curved {cpu_s:7.1f} s", flush=True)


if __name__ == "__main__":
    main()
