#!/usr/bin/python3
"""The floor plan of simulated buildings beside their world files: rooms, areas, clear sizes, doors, ends of walls.

usage: plans.py FOLDER_OF_PROGRAMS [--seeds 3] [--worlds office,flat] [--turn 0,37] [--keep FOLDER]

Each world is simulated as it is and turned by each angle (the map, not the world, decides how the plan lies). The truth
is the world's walls with their thickness, drawn at 5 mm, flooded; doors are the gaps between two walls on one line.
Exit code 1 when a goal is missed: every room, areas within 1 %, sizes within 2 cm, 95 % of the doors, none invented,
98 % of the walls' ends meet. Needs numpy, OpenCV.
"""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import tomllib

import cv2
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CELL_M = 0.005
THICKNESS_M = 0.12
MARGIN_M = 1.0


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def segments_of(world):
    """(a, b, thickness) of each wall."""
    found = []
    for wall in world["walls"]:
        corners = np.array(wall["corners_m"], float).reshape(-1, 2)
        found += [(a, b, wall.get("thickness_m", THICKNESS_M)) for a, b in zip(corners, corners[1:])]
    return found


def doors_of(segments):
    """The gap from each free end of a wall along it to the next wall, up to 1.3 m: (middle, clear width), each once."""
    doors = []
    for a, b, thickness in segments:
        for end, other in ((a, b), (b, a)):
            way = (end - other) / np.linalg.norm(end - other)
            nearest = 1.5
            for c, d, t in segments:
                if c is a and d is b:
                    continue
                along = d - c
                turn = way[0] * along[1] - way[1] * along[0]
                off = c - end
                if abs(turn) < 1e-9:
                    for tip in (c, d):
                        s, side = way @ (tip - end), way[0] * (tip - end)[1] - way[1] * (tip - end)[0]
                        if abs(side) < 1e-6 and -1e-6 < s < nearest:
                            nearest = s
                else:
                    s = (off[0] * along[1] - off[1] * along[0]) / turn
                    u = (off[0] * way[1] - off[1] * way[0]) / turn
                    if -1e-6 <= u <= 1 + 1e-6 and -1e-6 < s < nearest:
                        nearest = s
            if 0.3 < nearest < 1.3:
                middle, width = end + way * nearest / 2, nearest - thickness
                if all(np.linalg.norm(middle - known) > 0.1 for known, _ in doors):
                    doors.append((middle, width))
    return doors


class Truth:
    def __init__(self, world):
        segments = segments_of(world)
        self.doors = doors_of(segments)
        points = np.array([p for a, b, _ in segments for p in (a, b)])
        self.low = points.min(0) - MARGIN_M
        width, height = np.ceil((points.max(0) + MARGIN_M - self.low) / CELL_M).astype(int)
        self.solid = np.zeros((height, width), np.uint8)
        closed = np.zeros_like(self.solid)
        for a, b, thickness in segments:
            self.box(self.solid, a, b, thickness)
        closed |= self.solid
        for middle, _ in self.doors:  # closed by a square of the wall's thickness: counted in neither room
            for a, b, thickness in segments:
                way = (b - a) / np.linalg.norm(b - a)
                if abs(way[0] * (middle - a)[1] - way[1] * (middle - a)[0]) < 1e-6 and \
                        min(np.linalg.norm(middle - a), np.linalg.norm(middle - b)) < 0.8:
                    self.box(closed, middle - way * 0.7, middle + way * 0.7, thickness)
                    break
        _, self.room, stats, _ = cv2.connectedComponentsWithStats(255 - closed, connectivity=4)
        self.area = {i: s[cv2.CC_STAT_AREA] * CELL_M ** 2 for i, s in enumerate(stats)}
        outside = self.room[0, 0]
        self.rooms = [i for i, area in self.area.items() if i not in (0, outside) and area > 1.0]

    def box(self, image, a, b, thickness):
        way = (b - a) / np.linalg.norm(b - a) * thickness / 2
        side = np.array([-way[1], way[0]])
        corners = np.array([a - way + side, b + way + side, b + way - side, a - way - side])
        cv2.fillPoly(image, [np.round(((corners - self.low) / CELL_M - 0.5) * 256).astype(np.int32)], 255, shift=8)

    def cell(self, point):
        x, y = ((point - self.low) / CELL_M).astype(int)
        return (y, x) if 0 <= y < self.room.shape[0] and 0 <= x < self.room.shape[1] else (0, 0)

    def clear(self, point, way):
        """Clear size through a point along a direction; doors count as closed."""
        room, length = self.room[self.cell(point)], 0.0
        for sign in (1, -1):
            s = 0.0
            while self.room[self.cell(point + way * sign * s)] == room and s < 100:
                s += CELL_M
            length += s - CELL_M / 2
        return length


def turned(world, angle_deg):
    """The same world and tour, turned about the origin; only what holds places and angles changes."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))

    def walk(value, key=""):
        if isinstance(value, dict):
            out = {k: walk(v, k) for k, v in value.items()}
            if "at_m" in value and "size_m" in value:
                out["yaw_deg"] = value.get("yaw_deg", 0) + angle_deg
            return out
        if isinstance(value, list) and value and isinstance(value[0], dict):
            return [walk(v, key) for v in value]
        if key in ("corners_m", "at_m", "hinge_m", "to_m", "start_m", "from_m") and isinstance(value, list):
            flat = []
            for x, y in zip(value[0::2], value[1::2]):
                flat += [c * x - s * y, s * x + c * y]
            return flat
        if key == "floor_m":
            corners = [(c * x - s * y, s * x + c * y) for x in value[0::2] for y in value[1::2]]
            xs, ys = [p[0] for p in corners], [p[1] for p in corners]
            return [min(xs), min(ys), max(xs), max(ys)]
        if key in ("start_heading_deg",):
            return value + angle_deg
        return value

    return walk(world)


def toml(value):
    lines = [f"{k} = {json.dumps(v)}" for k, v in value.items()
             if not isinstance(v, dict) and not (isinstance(v, list) and v and isinstance(v[0], dict))]
    for key, entries in value.items():
        if isinstance(entries, list) and entries and isinstance(entries[0], dict):
            for entry in entries:
                lines += [f"[[{key}]]"] + [f"{k} = {json.dumps(v)}" for k, v in entry.items()]
    return "\n".join(lines) + "\n"


def read_tum(path):
    return np.loadtxt(path, ndmin=2)


def world_from_map(folder):
    """By the true poses, least squares."""
    path, truth = read_tum(os.path.join(folder, "trajectory.tum")), read_tum(os.path.join(folder, "truth.tum"))
    near = np.abs(truth[:, 0][:, None] - path[:, 0][None, ::5]).argmin(0)
    a, b = path[::5, 1:3], truth[near, 1:3]
    u, _, v = np.linalg.svd((a - a.mean(0)).T @ (b - b.mean(0)))
    turn = (u @ np.diag([1, np.sign(np.linalg.det(u @ v))]) @ v).T
    return turn, b.mean(0) - turn @ a.mean(0)


def judge(world, folder):
    truth = Truth(world)
    with open(os.path.join(folder, "plan.json"), encoding="utf-8") as file:
        plan = json.load(file)
    turn, shift = world_from_map(folder)
    pose = plan["map_from_plan"]
    c, s = math.cos(pose["theta_rad"]), math.sin(pose["theta_rad"])
    plan_turn = np.array([[c, -s], [s, c]])

    def to_world(point):
        return turn @ (plan_turn @ np.array(point) + [pose["x_m"], pose["y_m"]]) + shift

    def of_kind(kind):
        return [f for f in plan["features"] if f["properties"]["kind"] == kind]

    found, area_errors, size_errors, ratios = set(), [], [], []
    for room in of_kind("room"):
        p = room["properties"]
        at = to_world(p["label_at_m"])
        which = truth.room[truth.cell(at)]
        if which not in truth.rooms or which in found:
            continue
        found.add(which)
        area_errors.append(abs(p["area_m2"] / truth.area[which] - 1))
        ratios.append(abs(p["area_m2"] - truth.area[which]) / p["area_sigma_m2"])
        for axis in (0, 1):
            way = turn @ plan_turn @ np.eye(2)[axis]
            size_errors.append(abs(p["clear_size_m"][axis] - truth.clear(at, way)))
    doors, invented, width_errors = set(), 0, []
    for opening in of_kind("opening"):
        middle = to_world(np.mean(opening["geometry"]["coordinates"], axis=0))
        off = [np.linalg.norm(middle - door) for door, _ in truth.doors]
        best = int(np.argmin(off)) if off else -1
        if best < 0 or off[best] > 0.3 or best in doors:
            invented += 1
            continue
        doors.add(best)
        width_errors.append(abs(opening["properties"]["width_m"] - truth.doors[best][1]))
    # An end of a wall's stretch meets when the next edge is a wall, an opening, or goes on, unseen, to a corner.
    meet = ends = 0
    for room in of_kind("room"):
        edges, at = room["properties"]["edges"], 0
        for ring in room["geometry"]["coordinates"]:
            points = np.array(ring)
            count = len(ring) - 1
            for i in range(count):
                if edges[at + i] != "wall":
                    continue
                for k in (-1, 1):
                    other = edges[at + (i + k) % count]
                    one, way = (points[(i + k) % count], points[(i + k) % count + 1] - points[(i + k) % count])
                    mine = points[i + 1] - points[i]
                    crossing = abs(mine[0] * way[1] - mine[1] * way[0]) / max(1e-9, np.linalg.norm(mine) * np.linalg.norm(way))
                    ends += 1
                    meet += other != "not seen" or crossing < 0.02 or crossing > 0.98
            at += count
    return {"rooms": (len(found), len(truth.rooms)), "area": max(area_errors, default=1), "size": max(size_errors, default=9),
            "ratio": float(np.sqrt(np.mean(np.square(ratios)))) if ratios else 0, "doors": (len(doors), len(truth.doors)),
            "invented": invented, "width": max(width_errors, default=0), "meet": meet / max(1, ends)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--worlds", default="office,flat")
    parser.add_argument("--turn", default="0,37")
    parser.add_argument("--keep")
    options = parser.parse_args()
    missed = False
    with tempfile.TemporaryDirectory() as temporary:
        work = options.keep or temporary
        os.makedirs(work, exist_ok=True)
        print("world   turn seed   rooms  area[%]  size[cm]  area error/sigma   doors  invented  width[cm]  ends meet[%]")
        for name in options.worlds.split(","):
            for angle in map(float, options.turn.split(",")):
                texts = {}
                for kind in ("worlds", "tours"):
                    with open(f"{ROOT}/config/{kind}/{name}.toml", "rb") as file:
                        texts[kind] = turned(tomllib.load(file), angle)
                    with open(f"{work}/{name}.{angle:g}.{kind}.toml", "w", encoding="utf-8") as file:
                        file.write(toml(texts[kind]))
                for seed in range(1, options.seeds + 1):
                    log, out = f"{work}/{name}.{angle:g}.{seed}.lcm", f"{work}/{name}.{angle:g}.{seed}"
                    if not os.path.exists(out + "/map.marco"):
                        run([f"{options.programs}/marco-simulate", "--world", f"{work}/{name}.{angle:g}.worlds.toml",
                             "--tour", f"{work}/{name}.{angle:g}.tours.toml", "--seed", str(seed), "--out", log])
                        run([f"{options.programs}/marco-map", log, "--out", out])
                        os.remove(log)
                    run([f"{options.programs}/marco-plan", out])
                    r = judge(texts["worlds"], out)
                    good = (r["rooms"][0] == r["rooms"][1] and r["area"] <= 0.01 and r["size"] <= 0.02 and r["invented"] == 0 and
                            r["doors"][0] >= 0.95 * r["doors"][1] and r["meet"] >= 0.98)
                    missed |= not good
                    print(f"{name:7} {angle:4g} {seed:4}  {r['rooms'][0]:3}/{r['rooms'][1]:2} {100 * r['area']:8.2f} "
                          f"{100 * r['size']:9.1f} {r['ratio']:17.2f}  {r['doors'][0]:3}/{r['doors'][1]:2} {r['invented']:9} "
                          f"{100 * r['width']:10.1f} {100 * r['meet']:13.1f}{'' if good else '   missed'}", flush=True)
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
