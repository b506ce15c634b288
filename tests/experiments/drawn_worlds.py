#!/usr/bin/python3
"""Buildings, drives and damages drawn by a seed, with exact truth, as CARMEN logs: many cheap maps for doctor.py --drawn.

usage: drawn_worlds.py OUT --worlds 1-40 [--kinds house,ring,...] [--copies 5]

Each world has a kind by its number, and a drive of 50 to 150 m with a scan each 0.15 to 0.3 m. Of each it writes copy 0
without damage and `copies` others with one to three damages of drawn strength: OUT/KIND.WORLD.COPY.log, .tum (true poses
by the same stamps), .odometry.tum and .json (what was done). Needs numpy. The same numbers give the same bytes.
"""
import argparse
import json
import math
import os

import numpy as np

from worlds import World, drive

KINDS = ("house", "ring", "l_office", "flat", "hall")
OTHER_KINDS = ("warehouse", "cross", "octagon", "twins", "open_plan")


def far_from(tour, x0, y0, x1, y1, least_m):
    """Whether the way keeps clear of a box."""
    for (ax, ay), (bx, by) in zip(tour, tour[1:]):
        for k in np.linspace(0, 1, max(2, int(math.hypot(bx - ax, by - ay) / 0.2))):
            x, y = ax + k * (bx - ax), ay + k * (by - ay)
            if x0 - least_m < x < x1 + least_m and y0 - least_m < y < y1 + least_m:
                return False
    return True


def furnish(world, room, tour, count):
    """Boxes and legs of tables off the way."""
    r = world.random
    x0, y0, x1, y1 = room
    for _ in range(count):
        w, d = r.uniform(0.25, 1.4), r.uniform(0.25, 0.8)
        if r.random() < 0.5:
            w, d = d, w
        if x1 - x0 < w + 0.2 or y1 - y0 < d + 0.2:
            continue
        x, y = r.uniform(x0 + 0.05, x1 - w - 0.05), r.uniform(y0 + 0.05, y1 - d - 0.05)
        if not far_from(tour, x, y, x + w, y + d, 0.4):
            continue
        if r.random() < 0.25:
            world.columns += [(cx, cy, 0.03) for cx in (x, x + w) for cy in (y, y + d)]
        else:
            world.box(x, y, x + w, y + d)


def house(world, furniture=4):
    """Rooms by dividing a rectangle, each division with a door; all rooms are visited, twice."""
    r = world.random
    width, depth = r.uniform(8, 16), r.uniform(7, 12)
    rooms, doors = [(0.0, 0.0, width, depth)], []
    least = r.uniform(2.6, 3.4)
    walls = [((0, 0), (width, 0)), ((width, 0), (width, depth)), ((width, depth), (0, depth)), ((0, depth), (0, 0))]
    while True:
        big = [room for room in rooms if max(room[2] - room[0], room[3] - room[1]) > 2 * least]
        if not big or len(rooms) >= 9:
            break
        x0, y0, x1, y1 = room = big[r.integers(len(big))]
        rooms.remove(room)
        if x1 - x0 > y1 - y0:
            cut = r.uniform(x0 + least, x1 - least)
            rooms += [(x0, y0, cut, y1), (cut, y0, x1, y1)]
            walls.append(((cut, y0), (cut, y1)))
        else:
            cut = r.uniform(y0 + least, y1 - least)
            rooms += [(x0, y0, x1, cut), (x0, cut, x1, y1)]
            walls.append(((x0, cut), (x1, cut)))
    # A door where two rooms share 1.4 m of a wall; each pair gets one by chance, or to hold all together.
    links = {}
    order = [(i, j) for i in range(len(rooms)) for j in range(i)]
    r.shuffle(order)
    group = list(range(len(rooms)))
    for i, j in order:
        a, b = rooms[i], rooms[j]
        place = None
        for k in (0, 1):
            low, high = max(a[1 - k], b[1 - k]), min(a[3 - k], b[3 - k])
            for at in (a[k], a[k + 2]):
                if high - low > 1.4 and (abs(at - b[k]) < 1e-9 or abs(at - b[k + 2]) < 1e-9):
                    along = r.uniform(low + 0.7, high - 0.7)
                    place = (at, along) if k == 0 else (along, at)
                    across = k
        if place and (group[i] != group[j] or r.random() < 0.3):
            links[(i, j)] = place
            doors.append((place, across))
            old, new = group[i], group[j]
            group = [new if g == old else g for g in group]
    half = r.uniform(0.4, 0.5)
    for (ax, ay), (bx, by) in walls:
        k = 1 if ax == bx else 0
        holes = sorted(d[k] for d, across in doors if across == 1 - k and abs(d[1 - k] - (ax, ay)[1 - k]) < 1e-9)
        ends = sorted(((ax, ay)[k], (bx, by)[k]))
        at = ends[0]
        for hole in [h for h in holes if ends[0] <= h <= ends[1]] + [ends[1] + half]:
            until = min(hole - half, ends[1])
            if until > at:
                fixed = (ax, ay)[1 - k]
                world.walls.append((at, fixed, until, fixed) if k == 0 else (fixed, at, fixed, until))
            at = hole + half
    neighbours = {i: [] for i in range(len(rooms))}
    for (i, j), place in links.items():
        neighbours[i].append((j, place))
        neighbours[j].append((i, place))
    middle = [(0.5 * (a + c), 0.5 * (b + d)) for a, b, c, d in rooms]
    tour = [middle[0]]

    def inside(door, room):
        """A place one step into the room, before the door."""
        x0, y0, x1, y1 = rooms[room]
        x, y = door
        if abs(x - x0) < 1e-9:
            return x + 0.6, y
        if abs(x - x1) < 1e-9:
            return x - 0.6, y
        return (x, y + 0.6) if abs(y - y0) < 1e-9 else (x, y - 0.6)

    def visit(room, seen):
        seen.add(room)
        for other, door in r.permutation(np.array(neighbours[room], dtype=object)) if neighbours[room] else []:
            if other in seen:
                continue
            way = [inside(door, room), inside(door, other), middle[other]]
            tour.extend(way)
            visit(other, seen)
            tour.extend([inside(door, other), inside(door, room), middle[room]])

    visit(0, set())
    visit(0, set())
    for room in rooms:
        furnish(world, room, tour, furniture)
    return tour


def flat(world):
    return house(world, furniture=14)


def ring(world):
    r = world.random
    a, b, w = r.uniform(16, 45), r.uniform(12, 30), r.uniform(1.6, 2.6)
    world.corridors([(0, 0, a, w), (0, b - w, a, b), (0, 0, w, b), (a - w, 0, a, b)])
    world.doors(r.uniform(5, 20))
    m = w / 2
    corners = [(m, m), (a - m, m), (a - m, b - m), (m, b - m)]
    return corners + corners + [corners[0], corners[1]] if a + b < 40 else corners + [corners[0], corners[1], corners[2]]


def rooms_along(world, start, along, count, depth, tour, sides=(-1, 1), width=3.5):
    """Rooms on both sides of a corridor of 2 m from `start`; the tour goes into some. Returns rectangles."""
    r = world.random
    rectangles = []
    for i in range(count):
        for side in sides:
            centre = (i + 0.5) * (width + 0.3)
            half, jamb = width / 2, 0.45
            if side > 0:
                room, door = (centre - half, 2.3, centre + half, 2.3 + depth), (centre - jamb, 1.9, centre + jamb, 2.4)
            else:
                room, door = (centre - half, -0.3 - depth, centre + half, -0.3), (centre - jamb, -0.4, centre + jamb, 0.1)

            def placed(q):
                if along == "x":
                    return start[0] + q[0], start[1] + q[1], start[0] + q[2], start[1] + q[3]
                return start[0] + q[1], start[1] + q[0], start[0] + q[3], start[1] + q[2]
            rectangles += [placed(room), placed(door)]
            if r.random() < 0.45:
                def at(u, v):
                    return (start[0] + u, start[1] + v) if along == "x" else (start[0] + v, start[1] + u)
                inside = 2.3 + depth / 2 if side > 0 else -0.3 - depth / 2
                tour += [at(centre, 1.0), at(centre, inside), at(centre, 1.0)]
    return rectangles


def l_office(world):
    r = world.random
    n, m, depth = int(r.integers(3, 7)), int(r.integers(2, 5)), r.uniform(3, 5)
    tour = [(0.8, 1.0)]
    length = (n * 3.8) + 2.6
    rectangles = [(0, 0, length, 2.0)] + rooms_along(world, (0, 0), "x", n, depth, tour)
    x = length - 2.0
    tour += [(x + 1.0, 1.0)]
    up = m * 3.8 + depth + 2.6
    rectangles.append((x, 0, x + 2.0, up))
    tour_up = []
    rectangles += rooms_along(world, (x, depth + 2.5), "y", m, depth, tour_up, sides=(1,))
    tour += tour_up + [(x + 1.0, up - 1.0), (x + 1.0, 1.0), (0.8, 1.0)]
    world.corridors(rectangles)
    for room in rectangles[1:]:
        if room[2] - room[0] > 2.5 and room[3] - room[1] > 2.5:
            furnish(world, room, tour, 3)
    return tour + [(x + 1.0, 1.0), (x + 1.0, up / 2)]


def hall(world):
    r = world.random
    a, b = r.uniform(14, 30), r.uniform(10, 20)
    world.box(0, 0, a, b)
    for x in np.arange(4, a - 2, r.uniform(4, 7)):
        for y in np.arange(3.5, b - 2, r.uniform(4, 6)):
            world.columns.append((x + r.normal(0, 0.1), y + r.normal(0, 0.1), r.uniform(0.12, 0.35)))
    tour = [(2, 2), (a - 2, 2), (a - 2, b - 2), (2, b - 2), (2, 2), (a - 2, b / 2), (a - 2, b - 2), (2, b - 2), (2, 2)]
    world.columns = [c for c in world.columns if far_from(tour, c[0], c[1], c[0], c[1], 0.8)]
    furnish(world, (0, 0, a, b), tour, int(r.integers(2, 10)))
    return tour


def warehouse(world):
    r = world.random
    rows, length = int(r.integers(3, 6)), r.uniform(10, 22)
    pitch = 3.2
    a, b = length + 5, rows * pitch + 2.2
    world.box(0, 0, a, b)
    for i in range(rows):
        y = 2.2 + i * pitch
        at = 2.5
        while at < length + 2.4:
            piece = min(r.uniform(1.5, 4.0), length + 2.5 - at)
            if r.random() < 0.9:
                world.box(at, y + r.uniform(0, 0.1), at + piece, y + 1.0)
            at += piece
    tour = [(1.2, 1.1)]
    for i in range(rows + 1):
        y = 1.1 + i * pitch
        ends = (1.2, a - 1.2) if i % 2 == 0 else (a - 1.2, 1.2)
        tour += [(ends[0], y), (ends[1], y)]
    return tour + [(1.2, tour[-1][1]), (1.2, 1.1), (a - 1.2, 1.1)]


def cross(world):
    r = world.random
    arms = [r.uniform(8, 22) for _ in range(4)]
    w = r.uniform(1.8, 2.6)
    h = w / 2
    ends = [(arms[0], 0), (0, arms[1]), (-arms[2], 0), (0, -arms[3])]
    rectangles = [(-arms[2] - h, -h, arms[0] + h, h), (-h, -arms[3] - h, h, arms[1] + h)]
    for x, y in ends:
        if r.random() < 0.7:
            rectangles.append((x - r.uniform(2, 4), y - r.uniform(2, 4), x + r.uniform(2, 4), y + r.uniform(2, 4)))
    world.corridors(rectangles)
    world.doors(r.uniform(5, 15))
    tour = [(0.0, 0.0)]
    for k in (0, 1, 2, 3, 0, 1):
        tour += [ends[k], (0.0, 0.0)]
    return tour


def octagon(world):
    """A walk round a court with eight or so sides: no two walls at right angles."""
    r = world.random
    sides, outer, w = int(r.integers(5, 10)), r.uniform(8, 16), r.uniform(1.8, 2.8)
    angles = np.sort(r.uniform(-0.25, 0.25, sides) + np.arange(sides)) * 2 * math.pi / sides
    for radius in (outer, outer - w):
        corners = [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
        world.chain(*corners, corners[0])
    world.doors(r.uniform(4, 10))
    way = [((outer - w / 2) * math.cos(a), (outer - w / 2) * math.sin(a)) for a in angles]
    return way + way + way[:3]


def twins(world):
    r = world.random
    gap, depth = r.uniform(10, 20), r.uniform(4, 6)
    tour = [(1.0, 1.0)]
    rectangles = [(0, 0, gap + 13, 2.0)]
    for x in (0.5, gap + 6.5):
        rectangles += [(x, 2.3, x + 5, 2.3 + depth), (x + 2, 1.9, x + 3, 2.4)]
        tour += [(x + 2.5, 1.0), (x + 2.5, 2.3 + depth / 2), (x + 1.2, 2.3 + depth / 2), (x + 2.5, 2.3 + depth / 2), (x + 2.5, 1.0)]
    world.corridors(rectangles)
    tour += [(gap + 12, 1.0)]
    world.doors(12)
    return tour + tour[::-1] + tour[1:6]


def open_plan(world):
    """A large office with screens and desks."""
    r = world.random
    a, b = r.uniform(14, 24), r.uniform(9, 15)
    world.box(0, 0, a, b)
    tour = [(1, 1)]
    for i, y in enumerate(np.arange(1, b - 0.5, 3.0)):
        tour += [(1, y), (a - 1, y)] if i % 2 == 0 else [(a - 1, y), (1, y)]
    tour += [(1, tour[-1][1]), (1, 1), (a - 1, 1)]
    for _ in range(40):
        x, y = r.uniform(1.5, a - 3.5), r.uniform(1.5, b - 1.5)
        length = r.uniform(1.0, 2.2)
        if far_from(tour, x, y, x + length, y + 0.05, 0.4):
            world.box(x, y, x + length, y + 0.05)
    furnish(world, (0, 0, a, b), tour, 25)
    return tour


# What a damage does to (spec): strengths are drawn, some harmless, some fatal.
def draw_damage(name, r):
    def between(low, high):
        return float(math.exp(r.uniform(math.log(low), math.log(high))))
    return {
        "noise": lambda: between(0.02, 0.10),
        "thin": lambda: between(2, 20),          # keeps one scan in N
        "range": lambda: between(2.0, 6.0),
        "beams": lambda: int(r.integers(3, 14)),  # keeps every Nth beam
        "field": lambda: between(50, 120),
        "bursts": lambda: [int(r.integers(1, 5)), between(5, 40)],
        "scale": lambda: [between(0.7, 1.4), between(0.7, 1.4)],  # way, turn
        "veer": lambda: float(r.choice([-1, 1])) * between(1, 12),  # deg/m
        "slip": lambda: [int(r.integers(1, 6)), between(0.3, 3.0), between(10, 90)],  # times, m, deg
        "late": lambda: float(r.choice([-1, 1])) * between(0.1, 0.6),
        "turned": lambda: float(r.uniform(-180, 180)),
        "no_odometry": lambda: 1.0,
        "people": lambda: int(r.integers(2, 12)),
    }[name]()


NO_RETURN_M = 81.83
DAMAGES = ("noise", "thin", "range", "beams", "field", "bursts", "scale", "veer", "slip", "late", "turned", "no_odometry", "people")


class Drive:
    """The true drive through a world: poses with stamps, and ranges without any error."""

    def __init__(self, kind, seed):
        self.world = World([seed, 77])
        r = self.world.random
        self.tour = globals()[kind](self.world)
        self.max_m = float(r.choice([8.0, 12.0, 20.0]))
        field_deg = float(r.choice([180, 240, 270, 360]))
        self.beams = int(r.choice([181, 240, 361]))
        self.noise_m = float(r.choice([0.005, 0.01, 0.02]))
        self.field_deg = field_deg * (1 - 1 / self.beams) if field_deg == 360 else field_deg
        self.poses = drive(self.tour, float(r.uniform(0.15, 0.3)))
        self.speed = float(r.uniform(0.3, 0.8))
        self.bearings = np.radians(np.linspace(-self.field_deg / 2, self.field_deg / 2, self.beams))
        self.ranges = self.cast(0.0)
        self.stamps = [1000.0]
        for (x0, y0, h0), (x1, y1, h1) in zip(self.poses, self.poses[1:]):
            turn = abs((h1 - h0 + math.pi) % (2 * math.pi) - math.pi)
            self.stamps.append(self.stamps[-1] + max(math.hypot(x1 - x0, y1 - y0) / self.speed, turn / math.radians(60), 0.05))


    def cast(self, turned_rad):
        """All ranges, by a laser that looks so far to the left."""
        return [self.world.ranges(x, y, self.bearings + h + turned_rad, self.max_m) for x, y, h in self.poses]


def odometry_of(the, damages, r):
    """Poses by wheels, one for each true pose."""
    scale, veer = 1 + r.normal(0, 0.01), math.radians(r.normal(0, 0.15))
    turn_scale = 1 + r.normal(0, 0.01)
    if "scale" in damages:
        scale, turn_scale = damages["scale"]
    if "veer" in damages:
        veer = math.radians(damages["veer"])
    x, y, h = the.poses[0]
    result = [(x, y, h)]
    slips = {}
    if "slip" in damages:
        times, most_m, most_deg = damages["slip"]
        for at in r.integers(5, len(the.poses) - 5, times):
            slips[int(at)] = (r.uniform(-most_m, most_m), math.radians(r.uniform(-most_deg, most_deg)))
    for i, (a, b) in enumerate(zip(the.poses, the.poses[1:])):
        d = math.hypot(b[0] - a[0], b[1] - a[1])
        turn = (b[2] - a[2] + math.pi) % (2 * math.pi) - math.pi
        way = d * scale + r.normal(0, 0.02 * d + 1e-4)
        turned = turn * turn_scale + veer * d + r.normal(0, math.radians(0.15) * math.sqrt(d) + 0.01 * abs(turn) + 1e-4)
        if i in slips:
            way, turned = way + slips[i][0], turned + slips[i][1]
        if "no_odometry" in damages:
            way = turned = 0.0
        x, y = x + way * math.cos(h + turned / 2), y + way * math.sin(h + turned / 2)
        h += turned
        result.append((x, y, h))
    return result


def at_time(stamps, poses, t):
    i = min(max(int(np.searchsorted(stamps, t)), 1), len(stamps) - 1)
    k = min(max((t - stamps[i - 1]) / (stamps[i] - stamps[i - 1]), 0.0), 1.0)
    a, b = poses[i - 1], poses[i]
    return tuple(a[j] + k * (b[j] - a[j]) for j in range(3))  # headings are not wrapped


def leg_ranges(x, y, bearings, legs):
    best = np.full(len(bearings), np.inf)
    dx, dy = np.cos(bearings), np.sin(bearings)
    for cx, cy in legs:
        ox, oy = cx - x, cy - y
        t = ox * dx + oy * dy
        d2 = ox * ox + oy * oy - t * t
        hit = (d2 < 0.08 ** 2) & (t > 0.1)
        best = np.where(hit, np.minimum(best, t - np.sqrt(np.maximum(0, 0.08 ** 2 - d2))), best)
    return best


def people_legs(the, count, seed):
    """By time: each walks to and fro along a piece of the tour, about it to a side."""
    r = np.random.default_rng(seed)
    walks = []
    for _ in range(count):
        i = int(r.integers(0, len(the.poses) - 1))
        j = min(len(the.poses) - 1, i + int(r.integers(5, 40)))
        walks.append((the.poses[i][:2], the.poses[j][:2], r.uniform(0.5, 1.3), r.uniform(0, 60), r.uniform(-0.6, 0.6)))

    def legs(t):
        found = []
        for (ax, ay), (bx, by), speed, phase, aside in walks:
            length = max(0.5, math.hypot(bx - ax, by - ay))
            s = ((t + phase) * speed) % (2 * length)
            s = min(s, 2 * length - s) / length
            ux, uy = (bx - ax) / length, (by - ay) / length
            x, y = ax + s * (bx - ax) - uy * aside, ay + s * (by - ay) + ux * aside
            found += [(x - 0.12 * uy, y + 0.12 * ux), (x + 0.12 * uy + 0.2 * ux, y - 0.12 * ux + 0.2 * uy)]
        return found
    return legs


def write(the, damages, seed, name):
    r = np.random.default_rng(seed)
    odometry = odometry_of(the, damages, r)
    if "late" in damages:
        odometry = [at_time(the.stamps, odometry, t - damages["late"]) for t in the.stamps]
    max_m = min(the.max_m, damages.get("range", the.max_m))
    noise = max(the.noise_m, damages.get("noise", 0.0))
    every = damages.get("beams", 1)
    keep = np.arange(the.beams)
    if "field" in damages:
        keep = keep[np.abs(the.bearings) <= math.radians(damages["field"] / 2) + 1e-9]
    keep = keep[::every]
    bearings = the.bearings[keep]
    step = the.bearings[1] - the.bearings[0]
    lost = []
    if "bursts" in damages:
        count, length = damages["bursts"]
        for _ in range(count):
            begin = r.uniform(the.stamps[0], max(the.stamps[0], the.stamps[-1] - length))
            lost.append((begin, begin + length))
    legs = people_legs(the, damages["people"], seed) if "people" in damages else None
    turned = math.radians(damages.get("turned", 0.0))
    all_ranges = the.cast(turned) if turned else the.ranges
    with open(name + ".log", "w") as log, open(name + ".tum", "w") as truth, open(name + ".odometry.tum", "w") as raw:
        log.write("# CARMEN Logfile\n")
        for i, ((x, y, h), stamp, (ox, oy, oh)) in enumerate(zip(the.poses, the.stamps, odometry)):
            missing = any(a <= stamp < b for a, b in lost) or r.random() > 1.0 / damages.get("thin", 1.0)
            pose = f"{ox:.6f} {oy:.6f} {oh:.6f}"
            if missing and i > 0:
                log.write(f"ODOM {pose} 0 0 0 {stamp:.6f} sim {stamp:.6f}\n")
                continue
            ranges = all_ranges[i][keep]
            if legs:
                ranges = np.minimum(ranges, leg_ranges(x, y, bearings + h + turned, legs(stamp)))
            ranges = np.where(ranges < max_m, np.maximum(0.02, ranges + r.normal(0, noise, len(ranges))), NO_RETURN_M)
            ranges = np.where(r.random(len(ranges)) < 0.003, NO_RETURN_M, ranges)
            values = " ".join(f"{v:.3f}" for v in ranges)
            log.write(f"ROBOTLASER1 0 {bearings[0]:.7f} {bearings[-1] - bearings[0]:.7f} {step * every:.7f} {NO_RETURN_M:.3f} 0.01 0 "
                      f"{len(ranges)} {values} 0 {pose} {pose} 0 0 0 0 0 {stamp:.6f} sim {stamp:.6f}\n")
            for file, (a, b, c) in ((truth, (x, y, h)), (raw, (ox, oy, oh))):
                file.write(f"{stamp:.6f} {a:.6f} {b:.6f} 0 0 0 {math.sin(c / 2):.9f} {math.cos(c / 2):.9f}\n")
    with open(name + ".json", "w") as file:
        json.dump({"damages": damages, "seed": seed, "beams": len(keep), "max_m": max_m, "noise_m": noise,
                   "path_m": float(sum(math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(the.poses, the.poses[1:])))}, file)


def damages_of(copy, r):
    if copy == 0:
        return {}
    count = int(r.choice([1, 2, 3], p=[0.4, 0.4, 0.2]))
    names = list(r.choice(DAMAGES, count, replace=False))
    return {str(name): draw_damage(name, r) for name in names}


def numbers(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--worlds", default="1-40")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--copies", type=int, default=5)
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    kinds = options.kinds.split(",")
    for number in numbers(options.worlds):
        kind = kinds[number % len(kinds)]
        the = None
        for copy in range(options.copies + 1):
            name = os.path.join(options.out, f"{kind}.{number}.{copy}")
            if os.path.exists(name + ".json"):
                continue
            the = the or Drive(kind, number)
            seed = [number, copy]
            write(the, damages_of(copy, np.random.default_rng([*seed, 5])), seed, name)


if __name__ == "__main__":
    main()
