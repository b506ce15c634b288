#!/usr/bin/python3
"""A drawn plan beside a drive: simulated buildings against plans of their world files, as built and with changes.

usage: known_plan.py FOLDER_OF_PROGRAMS [--seeds 3] [--worlds office,flat] [--keep FOLDER]

The plan is written by ezdxf: walls as rectangles on A-WALL, doors on A-DOOR, in millimetres, turned by 30 degrees. For each
drive: the plan as it is (no wall may be off); and with one inner wall moved by 12 cm, one left out and one added, each
drawn by lot among those of 2 m and more. Reported must be these and no others, the moved one within 2 cm, on both sides
where both were seen; furniture that is taken for walls is counted in the plan as it is ("more"), and not again. Then the drive is localized in the plan, without a start. Exit code 1 when a goal is missed.
"""
import argparse
import json
import math
import os
import random
import sys
import tempfile
import tomllib

import ezdxf
import numpy as np
import plans

TURN_RAD = math.radians(30)
MOVED_M = 0.12
TURN = np.array([[math.cos(TURN_RAD), -math.sin(TURN_RAD)], [math.sin(TURN_RAD), math.cos(TURN_RAD)]])


def direction(a, b):
    return (b - a) / np.linalg.norm(b - a)


def rectangle(a, b, thickness):
    way = direction(a, b) * thickness / 2
    side = np.array([-way[1], way[0]])
    return [a - way + side, b + way + side, b + way - side, a - way - side]


def draw(segments, path):
    drawing = ezdxf.new("R2010")
    drawing.header["$INSUNITS"] = 4
    for layer in ("A-WALL", "A-DOOR"):
        drawing.layers.add(layer)
    space = drawing.modelspace()
    for segment in segments:
        space.add_lwpolyline([tuple(1000 * TURN @ p) for p in rectangle(*segment)], close=True, dxfattribs={"layer": "A-WALL"})
    for middle, width in plans.doors_of(segments):
        space.add_circle(tuple(1000 * TURN @ middle), 1000 * width, dxfattribs={"layer": "A-DOOR"})
    drawing.saveas(path)


def changed(segments, lot):
    """The plan's segments, and the moved one as it stands and as drawn, the one left out, the one added."""
    points = np.array([p for a, b, _ in segments for p in (a, b)])
    low, high = points.min(0), points.max(0)
    inner = [i for i, (a, b, _) in enumerate(segments)
             if np.linalg.norm(b - a) >= 2 and (((a + b) / 2 - low).min() > 0.3 and (high - (a + b) / 2).min() > 0.3)]
    moved, left_out, like = lot.sample(inner, 3)

    def shifted(segment, by):
        a, b, thickness = segment
        way = direction(a, b)
        return a + by * np.array([-way[1], way[0]]), b + by * np.array([-way[1], way[0]]), thickness

    added = shifted(segments[like], 1.0 if lot.random() < 0.5 else -1.0)
    plan = [shifted(s, MOVED_M) if i == moved else s for i, s in enumerate(segments) if i != left_out]
    return plan + [added], segments[moved], shifted(segments[moved], MOVED_M), segments[left_out], added


def belongs(entry, segment):
    """Whether a reported wall lies on a segment's rectangle (its end faces included)."""
    middle = TURN.T @ (np.array(entry["from_m"]) + entry["to_m"]) / 2
    a, b, thickness = segment
    way, off = direction(a, b), middle - a
    along, across = off @ way, abs(way[0] * off[1] - way[1] * off[0])
    return -thickness < along < np.linalg.norm(b - a) + thickness and across < thickness / 2 + 0.06


def compare(programs, out, plan):
    plans.run([f"{programs}/marco-plan", out, "--against", plan])
    with open(f"{out}/deviations.json", encoding="utf-8") as file:
        return json.load(file)


def localized(programs, log, plan, work):
    plans.run([f"{programs}/marco-plan", f"{work}/plan_map", "--import", plan])
    plans.run([f"{programs}/marco-map", log, "--localize", f"{work}/plan_map", "--out", f"{work}/localized"])
    path, truth = plans.read_tum(f"{work}/localized/trajectory.tum"), plans.read_tum(f"{work}/localized/truth.tum")
    true = np.array([np.interp(path[:, 0], truth[:, 0], truth[:, k]) for k in (1, 2)])
    return np.hypot(*(path[:, 1:3].T - TURN @ true))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--worlds", default="office,flat")
    parser.add_argument("--keep")
    options = parser.parse_args()
    missed = False
    with tempfile.TemporaryDirectory() as temporary:
        work = options.keep or temporary
        os.makedirs(work, exist_ok=True)
        for name in options.worlds.split(","):
            with open(f"{plans.ROOT}/config/worlds/{name}.toml", "rb") as file:
                segments = plans.segments_of(tomllib.load(file))
            for seed in range(1, options.seeds + 1):
                log, out = f"{work}/{name}.{seed}.lcm", f"{work}/{name}.{seed}"
                if not os.path.exists(log):
                    plans.run([f"{options.programs}/marco-simulate", "--world", f"{plans.ROOT}/config/worlds/{name}.toml", "--tour",
                               f"{plans.ROOT}/config/tours/{name}.toml", "--seed", str(seed), "--out", log])
                if not os.path.exists(out + "/map.marco"):
                    plans.run([f"{options.programs}/marco-map", log, "--out", out])
                draw(segments, f"{work}/same.dxf")
                same = compare(options.programs, out, f"{work}/same.dxf")
                measured = [w for w in same["walls"] if w["state"] == "measured"]
                ratios = [w["off_m"] / w["sigma_m"] for w in measured]
                false = sum(w["is_off"] for w in measured) + sum(w["gone_m"] >= 0.5 for w in same["walls"])
                base = [w for w in same["not_drawn"] if not w["furniture"]]
                plan, stands, moved, left_out, added = changed(segments, random.Random(seed))
                draw(plan, f"{work}/changed.dxf")
                found = compare(options.programs, out, f"{work}/changed.dxf")
                off = [w for w in found["walls"] if w["state"] == "measured" and w["is_off"]]
                gone = [w for w in found["walls"] if w["gone_m"] >= 0.5]
                more = [w for w in found["not_drawn"] if not w["furniture"] and all(np.linalg.norm(np.subtract(w["from_m"], b["from_m"])) > 0.1 for b in base)]
                hits = [w for w in off if belongs(w, moved)]
                sides = sum(belongs(w, stands) and np.linalg.norm(np.subtract(w["from_m"], w["to_m"])) > 1 for w in measured)
                worst = max((abs(abs(w["off_m"]) - MOVED_M) for w in hits), default=9)
                strays = (len(off) - len(hits) + sum(not belongs(w, added) for w in gone) +
                          sum(not belongs(w, left_out) for w in more))
                others = max((abs(w["off_m"]) for w in found["walls"] if w["state"] == "measured" and not belongs(w, moved)), default=9)
                errors = localized(options.programs, log, f"{work}/same.dxf", work)
                good = (false == 0 and len(hits) >= sides > 0 and worst <= 0.02 and strays == 0 and others <= 0.02 and
                        any(belongs(w, added) for w in gone) and any(belongs(w, left_out) for w in more))
                missed |= not good
                print(f"{name:8} seed {seed}: as built {len(measured)} sides, {1000 * np.sqrt(np.mean(np.square([w['off_m'] for w in measured]))):.1f} mm rms, "
                      f"error/sigma {np.sqrt(np.mean(np.square(ratios))):.2f}, false {false}, more {len(base)}; changed: moved sides {len(hits)}/{sides}, off by "
                      f"{1000 * worst:.0f} mm, others {1000 * others:.0f} mm, gone {sum(belongs(w, added) for w in gone)}, new "
                      f"{sum(belongs(w, left_out) for w in more)}, strays {strays}; localized: median {1000 * np.median(errors):.0f} mm, "
                      f"within 10 cm {100 * np.mean(errors < 0.1):.1f} %, max {errors.max():.2f} m{'' if good else '   missed'}", flush=True)
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
