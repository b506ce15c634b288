#!/usr/bin/env python3
"""Generated buildings and a tour through each, for experiments and as config/worlds/twin_wings.toml.

usage: buildings.py twin_wings|two_km FOLDER

twin_wings: two wings, the one a copy of the other, of small offices that are all alike: what a room looks like says
neither which room it is nor which wing. two_km: blocks of furnished rooms between corridors, 2 km of driving, each
corridor seen several times. Writes FOLDER/worlds/NAME.toml and FOLDER/tours/NAME.toml.
"""
import math
import os
import random
import sys


class Building:
    """Walls, furniture, and the steps of a tour."""

    def __init__(self, name, comment, width_m, depth_m):
        self.name, self.comment = name, comment
        self.size_m = (width_m, depth_m)
        self.parts, self.steps = [], []

    def wall(self, *corners_m):
        self.parts.append(("walls", {"corners_m": [c for corner in corners_m for c in corner]}))

    def wall_with_doors(self, start, end, doors, door_m=1.0):
        """Along x or y; doors are distances from the start of their middles."""
        length = math.dist(start, end)
        way = ((end[0] - start[0]) / length, (end[1] - start[1]) / length)
        at = 0.0
        for door in sorted(doors) + [length + door_m]:
            until = min(door - 0.5 * door_m, length)
            if until > at:
                self.wall(*[(start[0] + way[0] * d, start[1] + way[1] * d) for d in (at, until)])
            at = door + 0.5 * door_m

    def box(self, x, y, size_m, yaw_deg=0.0):
        self.parts.append(("boxes", {"at_m": [x, y], "size_m": list(size_m), "yaw_deg": yaw_deg}))

    def table(self, x, y, yaw_deg=0.0):
        self.parts.append(("tables", {"at_m": [x, y], "size_m": [1.4, 0.8], "yaw_deg": yaw_deg}))

    def column(self, x, y):
        self.parts.append(("columns", {"at_m": [x, y], "radius_m": 0.18}))

    def go(self, *places):
        self.steps += places

    def length_m(self):
        return sum(math.dist(a, b) for a, b in zip(self.steps, self.steps[1:]))

    def write(self, folder):
        def text(value):
            return "[" + ", ".join(f"{v:g}" for v in value) + "]" if isinstance(value, list) else f"{value:g}"

        for kind in ("worlds", "tours"):
            os.makedirs(os.path.join(folder, kind), exist_ok=True)
        with open(os.path.join(folder, "worlds", self.name + ".toml"), "w", encoding="utf-8") as file:
            file.write(f"# {self.comment}\n# Made by tests/experiments/buildings.py.\n")
            file.write(f"floor_m = [0, 0, {self.size_m[0]:g}, {self.size_m[1]:g}]\nceiling_m = 2.6\n\n")
            for kind, part in self.parts:
                file.write(f"[[{kind}]]\n" + "".join(f"{key} = {text(value)}\n" for key, value in part.items()))
        (x, y), (next_x, next_y) = self.steps[:2]
        with open(os.path.join(folder, "tours", self.name + ".toml"), "w", encoding="utf-8") as file:
            file.write(f"# {self.length_m():.0f} m through {self.name}. Made by tests/experiments/buildings.py.\n")
            file.write(f"start_m = [{x:g}, {y:g}]\n")
            file.write(f"start_heading_deg = {math.degrees(math.atan2(next_y - y, next_x - x)):g}\n\n")
            for x, y in self.steps[1:]:
                file.write(f"[[steps]]\nto_m = [{x:g}, {y:g}]\n")


def twin_wings():
    """Each wing: a corridor along x with seven offices on either side; a hall at the west end joins them."""
    rooms, pitch, deep, corridor, hall = 7, 3.4, 4.0, 2.0, 2.4
    wing_depth = 2 * deep + corridor
    east, north = hall + rooms * pitch, 2 * wing_depth
    b = Building("twin_wings", "Two equal wings of equal offices on a hall.", east, north)
    b.wall((0, 0), (east, 0), (east, north), (0, north), (0, 0))
    b.wall((hall, wing_depth), (east, wing_depth))
    for wing in (0, 1):
        south = wing * wing_depth
        low, high = south + deep, south + deep + corridor
        doors = [(room + 0.5) * pitch for room in range(rooms)]
        b.wall_with_doors((hall, low), (east, low), doors)
        b.wall_with_doors((hall, high), (east, high), doors)
        for room in range(rooms):
            x = hall + room * pitch
            b.wall((x, south), (x, low))
            b.wall((x, high), (x, south + wing_depth))
            for side, back in ((1, south), (-1, south + wing_depth)):
                b.box(x + 0.4, back + side * 1.4, (0.4, 1.2, 1.9))
                b.table(x + 2.5, back + side * 0.7)
    middle = [wing * wing_depth + deep + 0.5 * corridor for wing in (0, 1)]
    west_x, east_x = 0.5 * hall, east - 1.0

    def wing_round(y, step):
        b.go((west_x, y))
        for room in range(0, rooms, step):
            x = hall + (room + 0.5) * pitch
            b.go((x, y), (x, y - 2.9), (x, y), (x, y + 2.9), (x, y))
        b.go((east_x, y), (west_x, y))

    b.go((west_x, 1.0))
    for step in (1, 2):
        for y in middle:
            wing_round(y, step)
    b.go((west_x, 1.0))
    return b


def two_km():
    """Blocks of two by two rooms, back to back, between corridors 2 m wide."""
    chance = random.Random(7)
    columns, rows, room_w, room_d, corridor = 6, 4, 7.0, 5.5, 2.0
    block_w, block_d = 2 * room_w, 2 * room_d
    east, north = columns * (block_w + corridor) + corridor, rows * (block_d + corridor) + corridor
    b = Building("two_km", "Furnished rooms in blocks between corridors.", east, north)
    b.wall((0, 0), (east, 0), (east, north), (0, north), (0, 0))
    doors = {}
    for column in range(columns):
        for row in range(rows):
            x, y = corridor + column * (block_w + corridor), corridor + row * (block_d + corridor)
            b.wall((x, y), (x, y + block_d))
            b.wall((x + block_w, y), (x + block_w, y + block_d))
            b.wall((x + room_w, y), (x + room_w, y + block_d))
            b.wall((x, y + room_d), (x + block_w, y + room_d))
            for top in (False, True):
                wall_y = y + block_d if top else y
                at = [chance.uniform(1.2, room_w - 1.2) + side * room_w for side in (0, 1)]
                b.wall_with_doors((x, wall_y), (x + block_w, wall_y), at)
                for side in (0, 1):
                    doors[column, row, top, side] = (x + at[side], wall_y)
                    furnish(b, chance, x + side * room_w, y + (room_d if top else 0.0), room_w, room_d, x + at[side])
    line_x = [0.5 * corridor + c * (block_w + corridor) for c in range(columns + 1)]
    line_y = [0.5 * corridor + r * (block_d + corridor) for r in range(rows + 1)]
    at = [0, 0]
    b.go((line_x[0], line_y[0]))

    def drive_along_block(column, row_line, forward, visit):
        blocks = [(row_line, False), (row_line - 1, True)]
        visits = []
        for row, top in blocks:
            for side in (0, 1):
                door = doors.get((column, row, top, side))
                if door and visit and chance.random() < 0.5:
                    visits.append((door, 2.0 if not top else -2.0))
        for (x, y), inward in sorted(visits, key=lambda v: v[0][0], reverse=not forward):
            b.go((x, line_y[row_line]), (x, y + inward), (x, line_y[row_line]))

    seen = set()
    while b.length_m() < 2000.0:
        ways = [(dx, dy) for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))
                if 0 <= at[0] + dx <= columns and 0 <= at[1] + dy <= rows]

        def edge(way):
            there = (at[0] + way[0], at[1] + way[1])
            return (min(tuple(at), there), max(tuple(at), there))

        new = [way for way in ways if edge(way) not in seen]
        way = chance.choice(new or ways)
        first = edge(way) not in seen
        seen.add(edge(way))
        if way[0]:
            drive_along_block(min(at[0], at[0] + way[0]), at[1], way[0] > 0, first)
        at = [at[0] + way[0], at[1] + way[1]]
        b.go((line_x[at[0]], line_y[at[1]]))
    return b


def furnish(b, chance, x, y, width, depth, door_x):
    """Along the walls, away from the door's way in."""
    places = [(x + 0.4, y + chance.uniform(1.2, depth - 1.2), (0.4, chance.uniform(0.8, 2.0), 1.9)),
              (x + width - 0.4, y + chance.uniform(1.2, depth - 1.2), (0.4, chance.uniform(0.8, 2.0), 1.9))]
    for at_x, at_y, size in places:
        if abs(at_x - door_x) > 1.0 and chance.random() < 0.8:
            b.box(at_x, at_y, size)
    if chance.random() < 0.7:
        side = -1 if door_x - x > 0.5 * width else 1
        b.table(x + 0.5 * width + side * 1.9, y + 0.5 * depth + chance.uniform(-1.2, 1.2), chance.uniform(0, 90))
    if chance.random() < 0.3:
        b.column(x + 0.5 * width + (1.4 if door_x - x < 0.5 * width else -1.4), y + chance.uniform(1.0, depth - 1.0))


def main():
    makers = {"twin_wings": twin_wings, "two_km": two_km}
    if len(sys.argv) != 3 or sys.argv[1] not in makers:
        sys.exit(__doc__)
    building = makers[sys.argv[1]]()
    building.write(sys.argv[2])
    print(f"{building.name}: {building.size_m[0]:g} m x {building.size_m[1]:g} m, {building.length_m():.0f} m of path")


if __name__ == "__main__":
    main()
