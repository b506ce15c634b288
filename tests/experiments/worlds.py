#!/usr/bin/python3
"""Large worlds with exact truth, as CARMEN logs: what loop closure has to hold out against.

usage: worlds.py OUT [--worlds campus,hall,...] [--seeds 1,2,3]

Writes OUT/WORLD.SEED.log (ROBOTLASER1) and OUT/WORLD.SEED.tum (the true poses by the same stamps), for damages.py
--log WORLD=OUT/WORLD.SEED.log:OUT/WORLD.SEED.tum. Needs numpy. The same seed gives the same bytes.

  campus    2 km through bare corridors of four buildings, a scan a metre, 8 m of range: few walls across, many revisits
  hall      a hall of 60 x 40 m with columns, driven through three times
  grid      equal corridors that cross each other, 5 x 4: every crossing looks like the others but for a few doors
  wings     two equal wings at the ends of a long corridor, each driven through twice
  flat      eight furnished rooms and a corridor
"""
import argparse
import math
import os

import numpy as np


class World:
    def __init__(self, seed):
        self.random = np.random.default_rng(seed)
        self.walls = []  # x0 y0 x1 y1
        self.columns = []  # x y radius

    def chain(self, *corners):
        self.walls += [(*a, *b) for a, b in zip(corners, corners[1:])]

    def box(self, x0, y0, x1, y1):
        self.chain((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))

    def corridors(self, rectangles):
        """The outline of overlapping rectangles: all their edges, less what lies inside another one."""
        for i, (x0, y0, x1, y1) in enumerate(rectangles):
            for a, b in (((x0, y0), (x1, y0)), ((x1, y0), (x1, y1)), ((x1, y1), (x0, y1)), ((x0, y1), (x0, y0))):
                cuts = {0.0, 1.0}
                along = 0 if a[1] == b[1] else 1
                span = b[along] - a[along]
                inside = []
                for j, (u0, v0, u1, v1) in enumerate(rectangles):
                    if j == i:
                        continue
                    low, high, across_low, across_high = (u0, u1, v0, v1) if along == 0 else (v0, v1, u0, u1)
                    if across_low < a[1 - along] < across_high:
                        part = sorted(((low - a[along]) / span, (high - a[along]) / span))
                        inside.append(part)
                        cuts.update(c for c in part if 0 < c < 1)
                cuts = sorted(cuts)
                for s, e in zip(cuts, cuts[1:]):
                    middle = (s + e) / 2
                    if any(p[0] < middle < p[1] for p in inside):
                        continue
                    self.walls.append(tuple(a[k] + c * (b[k] - a[k]) for c in (s, e) for k in (0, 1)))

    def doors(self, every_m, depth_m=0.12, width_m=0.9):
        """Some walls get frames of doors, where chance puts them."""
        for x0, y0, x1, y1 in list(self.walls):
            length = math.hypot(x1 - x0, y1 - y0)
            for _ in range(self.random.poisson(length / every_m)):
                at = self.random.uniform(1, max(1.01, length - 2))
                ux, uy = (x1 - x0) / length, (y1 - y0) / length
                for side in (-1, 1):
                    ax, ay = x0 + at * ux, y0 + at * uy
                    bx, by = ax + width_m * ux, ay + width_m * uy
                    nx, ny = -uy * side * depth_m, ux * side * depth_m
                    self.chain((ax, ay), (ax + nx, ay + ny), (bx + nx, by + ny), (bx, by))

    def ranges(self, x, y, bearings, max_m):
        dx, dy = np.cos(bearings), np.sin(bearings)
        best = np.full(len(bearings), np.inf)
        w = self._near(x, y, max_m)
        if len(w):
            ex, ey = (w[:, 2] - w[:, 0])[:, None], (w[:, 3] - w[:, 1])[:, None]
            sx, sy = (w[:, 0] - x)[:, None], (w[:, 1] - y)[:, None]
            det = dx * ey - dy * ex
            with np.errstate(divide='ignore', invalid='ignore'):
                r, s = (sx * ey - sy * ex) / det, (sx * dy - sy * dx) / det
            r = np.where((np.abs(det) > 1e-12) & (s >= 0) & (s <= 1) & (r > 1e-6), r, np.inf)
            best = r.min(axis=0)
        for cx, cy, radius in self.columns:
            ox, oy = cx - x, cy - y
            if math.hypot(ox, oy) > max_m + radius:
                continue
            t = ox * dx + oy * dy
            d2 = ox * ox + oy * oy - t * t
            hit = (d2 < radius * radius) & (t > 0)
            best = np.where(hit, np.minimum(best, t - np.sqrt(np.maximum(0, radius * radius - d2))), best)
        return best

    def _near(self, x, y, max_m):
        if not hasattr(self, 'array'):
            self.array = np.array(self.walls)
            self.low = np.minimum(self.array[:, :2], self.array[:, 2:])
            self.high = np.maximum(self.array[:, :2], self.array[:, 2:])
        p = np.array([x, y])
        return self.array[np.all((self.low < p + max_m) & (self.high > p - max_m), axis=1)]


def campus(world):
    a = [(0, 0, 120, 2.4), (0, 0, 2.4, 60), (0, 57.6, 120, 60), (117.6, 0, 120, 60),
         (60, 0, 62.4, 60), (117.6, 28, 220, 30.4), (217.6, 0, 220, 60), (217.6, 0, 300, 2.4), (297.6, 0, 300, 60),
         (217.6, 57.6, 300, 60)]
    world.corridors(a)
    world.doors(25)
    m = 1.2
    tour = [(m, m), (118.8, m), (118.8, 58.8), (m, 58.8), (m, m), (61.2, m), (61.2, 58.8), (118.8, 58.8), (118.8, 29.2),
            (218.8, 29.2), (218.8, m), (298.8, m), (298.8, 58.8), (218.8, 58.8), (218.8, 29.2), (118.8, 29.2),
            (118.8, m), (61.2, m), (61.2, 58.8), (m, 58.8), (m, m), (118.8, m), (118.8, 29.2), (218.8, 29.2),
            (218.8, 58.8), (298.8, 58.8), (298.8, m), (218.8, m), (218.8, 29.2), (118.8, 29.2), (118.8, 58.8), (m, 58.8), (m, m)]
    return tour, dict(step_m=1.0, max_m=8.0, field_deg=180, beams=181, noise_m=0.015)


def hall(world):
    world.box(0, 0, 60, 40)
    for x in range(8, 60, 9):
        for y in range(8, 40, 8):
            world.columns.append((x + world.random.normal(0, 0.05), y + world.random.normal(0, 0.05), 0.3))
    for _ in range(6):
        x, y = world.random.uniform(3, 55), world.random.choice([0.0, 38.8])
        world.box(x, y, x + world.random.uniform(0.8, 3), y + 1.2)
    tour = [(4, 4), (56, 4), (56, 36), (4, 36), (4, 4), (4, 20), (56, 20), (56, 36), (30, 36), (30, 4), (56, 4), (56, 20), (4, 20), (4, 4), (30, 4), (30, 36), (4, 36)]
    return tour, dict(step_m=0.25, max_m=12.0, field_deg=270, beams=271, noise_m=0.02)


def grid(world):
    rectangles = [(0, 12 * i, 74, 12 * i + 2) for i in range(4)] + [(18 * i, 0, 18 * i + 2, 38) for i in range(5)]
    world.corridors(rectangles)
    world.doors(20)
    c = lambda i, j: (18 * i + 1, 12 * j + 1)
    tour = [c(0, 0)]
    at = (0, 0)
    last = None
    for _ in range(55):
        steps = [(dx, dy) for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))
                 if 0 <= at[0] + dx <= 4 and 0 <= at[1] + dy <= 3 and (-dx, -dy) != last]
        last = steps[world.random.integers(len(steps))]
        at = (at[0] + last[0], at[1] + last[1])
        tour.append(c(*at))
    return tour, dict(step_m=0.2, max_m=10.0, field_deg=180, beams=181, noise_m=0.015)


def wings(world):
    def wing(x0, sign):
        rectangles = [(x0, 0, x0 + 2.2, 30)]
        for k in range(4):
            y = 3 + 7 * k
            rectangles.append((x0 + 2.6, y, x0 + 8.6, y + 5) if sign > 0 else (x0 - 6.4, y, x0 - 0.4, y + 5))
            rectangles.append((x0 + 2.0, y + 2, x0 + 2.8, y + 3) if sign > 0 else (x0 - 0.6, y + 2, x0 + 0.2, y + 3))
        return rectangles
    world.corridors([(0, 0, 62.2, 2.2)] + wing(0, 1) + wing(60, 1))
    tour = [(1.1, 1.1)]
    for x in (1.1, 61.1, 1.1, 61.1, 1.1):
        tour.append((x, 1.1))
        for k in range(4):
            y = 3 + 7 * k + 2.5
            tour += [(x, y), (x + 4, y), (x, y)]
        tour += [(x, 28), (x, 1.1)]
    return tour, dict(step_m=0.2, max_m=15.0, field_deg=180, beams=181, noise_m=0.015)


def flat(world):
    rectangles = [(0, 6, 34, 8)]
    rooms = []
    for i in range(4):
        for y0, y1, door in ((0.3, 5.6, (5.4, 6.2)), (8.4, 13.7, (7.8, 8.6))):
            x0 = 8.5 * i + 0.3
            rectangles += [(x0, y0, x0 + 7.9, y1), (x0 + 3.5, door[0], x0 + 4.5, door[1])]
            rooms.append((x0, y0, x0 + 7.9, y1))
    world.corridors(rectangles)
    r = world.random
    for x0, y0, x1, y1 in rooms:
        for _ in range(6):
            w, d = r.uniform(0.4, 1.6), r.uniform(0.3, 0.8)
            x, y = r.uniform(x0, x1 - w), (y0 + 0.02 if r.random() < 0.5 else y1 - d - 0.02)
            if abs(x + w / 2 - (x0 + 4)) > 1.6:
                world.box(x, y, x + w, y + d)
    tour = [(0.8, 7)]
    for i in [0, 1, 2, 3, 3, 2, 1, 0]:
        x = 8.5 * i + 0.3 + 4
        middle = [(x, 7), (x, 3), (x - 2.5, 3), (x + 2.5, 3), (x, 3), (x, 7), (x, 11), (x + 2.5, 11), (x - 2.5, 11), (x, 11), (x, 7)]
        tour += middle
    return tour + [(0.8, 7)], dict(step_m=0.1, max_m=12.0, field_deg=240, beams=241, noise_m=0.015)


def drive(tour, step_m, turn_step=math.radians(12)):
    """Poses step_m apart, turning on the spot at corners."""
    poses = []
    heading = math.atan2(tour[1][1] - tour[0][1], tour[1][0] - tour[0][0])
    for (x0, y0), (x1, y1) in zip(tour, tour[1:]):
        length = math.hypot(x1 - x0, y1 - y0)
        if length < 1e-9:
            continue
        wanted = math.atan2(y1 - y0, x1 - x0)
        off = (wanted - heading + math.pi) % (2 * math.pi) - math.pi
        turns = max(0, math.ceil(abs(off) / turn_step))
        poses += [(x0, y0, heading + off * k / turns) for k in range(1, turns + 1)]
        heading = wanted
        steps = max(1, round(length / step_m))
        poses += [(x0 + (x1 - x0) * k / steps, y0 + (y1 - y0) * k / steps, heading) for k in range(1, steps + 1)]
    return poses


def write(name, seed, out):
    world = World(seed)
    tour, spec = globals()[name](world)
    r = world.random
    poses = drive(tour, spec['step_m'])
    bearings = np.radians(np.linspace(-spec['field_deg'] / 2, spec['field_deg'] / 2, spec['beams']))
    step = math.radians(spec['field_deg']) / (spec['beams'] - 1)
    # Odometry: one bias of the way and of the turn, and noise of each step.
    scale, veer = 1 + r.normal(0, 0.01), math.radians(r.normal(0, 0.15))
    ox, oy, oh = poses[0]
    before = poses[0]
    speed = 0.5
    stamp = 1000.0
    with open(os.path.join(out, f'{name}.{seed}.log'), 'w') as log, open(os.path.join(out, f'{name}.{seed}.tum'), 'w') as truth:
        log.write('# CARMEN Logfile\n')
        for x, y, h in poses:
            x += r.normal(0, 0.0)
            d = math.hypot(x - before[0], y - before[1])
            turn = (h - before[2] + math.pi) % (2 * math.pi) - math.pi
            stamp += max(d / speed, abs(turn) / math.radians(60), 0.05)
            measured = d * scale + r.normal(0, 0.02 * d + 1e-4)
            turned = turn * 1.01 + veer * d + r.normal(0, math.radians(0.15) * math.sqrt(d) + 0.01 * abs(turn) + 1e-4)
            oh += turned / 2
            ox, oy = ox + measured * math.cos(oh), oy + measured * math.sin(oh)
            oh += turned / 2
            before = (x, y, h)
            ranges = world.ranges(x, y, bearings + h, spec['max_m'])
            ranges = np.where(ranges < spec['max_m'], np.maximum(0.02, ranges + r.normal(0, spec['noise_m'], len(ranges))), spec['max_m'])
            values = ' '.join(f'{v:.3f}' for v in ranges)
            pose = f'{ox:.6f} {oy:.6f} {oh:.6f}'
            log.write(f'ROBOTLASER1 0 {bearings[0]:.7f} {math.radians(spec["field_deg"]):.7f} {step:.7f} {spec["max_m"]:.3f} 0.01 0 '
                      f'{len(values.split())} {values} 0 {pose} {pose} 0 0 0 0 0 {stamp:.6f} sim {stamp:.6f}\n')
            truth.write(f'{stamp:.6f} {x:.6f} {y:.6f} 0 0 0 {math.sin(h / 2):.9f} {math.cos(h / 2):.9f}\n')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('out')
    parser.add_argument('--worlds', default='campus,hall,grid,wings,flat')
    parser.add_argument('--seeds', default='1,2,3')
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    for name in options.worlds.split(','):
        for seed in options.seeds.split(','):
            write(name, int(seed), options.out)


if __name__ == '__main__':
    main()
