"""Drawings that ezdxf writes, read by `marco plan --import`: the walls on the imported map's picture are where ezdxf itself
explodes the drawing to, within two cells, and none is missing by more than three (where rays graze a column, cells beside it are free).

usage: drawn_plan_peer.py MARCO_PLAN
"""
import math
import subprocess
import sys
import tempfile

import ezdxf
import numpy as np
from ezdxf import disassemble

CELL_M = 0.05


def draw(release):
    """A room of 8 x 5 m in millimetres with a bay window, columns and partitions as blocks: nested, turned, mirrored, in rows."""
    drawing = ezdxf.new(release)
    drawing.header["$INSUNITS"] = 4
    for layer in ("A-WALL", "A-COLS", "A-DOOR", "A-ANNO"):
        drawing.layers.add(layer)
    drawing.layers.add("OLD-WALLS").off()
    column = drawing.blocks.new("COLUMN", base_point=(100, 100))
    column.add_circle((100, 100), 200, dxfattribs={"layer": "0"})
    pair = drawing.blocks.new("PAIR")
    pair.add_blockref("COLUMN", (0, 0), dxfattribs={"layer": "0"})
    pair.add_blockref("COLUMN", (1200, 300), dxfattribs={"layer": "0", "xscale": 1.25, "yscale": 1.25})
    partition = drawing.blocks.new("PARTITION")
    partition.add_line((0, 0), (900, 0), dxfattribs={"layer": "A-WALL"})
    partition.add_arc((900, 250), 250, 270, 0, dxfattribs={"layer": "A-WALL"})
    space = drawing.modelspace()
    outline = [(0, 0, 0), (8000, 0, 0), (8000, 1500, 0.5), (8000, 3500, 0), (8000, 5000, 0), (0, 5000, 0)]
    if release == "R12":
        space.add_polyline2d([p[:2] for p in outline], dxfattribs={"layer": "A-WALL"}, close=True)
    else:
        space.add_lwpolyline(outline, format="xyb", close=True, dxfattribs={"layer": "A-WALL"})
        space.add_ellipse((1500, 3800), (500, 0), 0.5, dxfattribs={"layer": "A-COLS"})
    space.add_blockref("PAIR", (3000, 1200), dxfattribs={"layer": "A-COLS", "rotation": 30})
    space.add_blockref("PAIR", (5200, 3900), dxfattribs={"layer": "A-COLS", "xscale": -1})
    rows = space.add_blockref("PARTITION", (600, 900), dxfattribs={"layer": "A-WALL", "rotation": 90})
    rows.dxf.row_count, rows.dxf.row_spacing = 2, -1000
    space.add_circle((-7000, 2500), 300, dxfattribs={"layer": "A-COLS", "extrusion": (0, 0, -1)})
    space.add_line((500, 500), (7500, 4500), dxfattribs={"layer": "OLD-WALLS"})
    space.add_line((500, 4500), (7500, 500), dxfattribs={"layer": "A-DOOR"})
    space.add_text("80 m2", dxfattribs={"layer": "A-ANNO", "height": 200})
    return drawing


def spots(drawing):
    """Points every centimetre on what ezdxf makes of the wall layers [m]; it leaves what blocks hold on layer 0 there."""
    found = []
    for primitive in disassemble.to_primitives(disassemble.recursive_decompose(drawing.modelspace())):
        if primitive.entity.dxf.layer not in ("A-WALL", "A-COLS", "0") or primitive.path is None:
            continue
        points = np.array([(p.x, p.y) for p in primitive.path.flattening(1.0)]) / 1000
        for a, b in zip(points, points[1:]):
            count = max(1, math.ceil(np.linalg.norm(b - a) / 0.01))
            found += [a + (b - a) * i / count for i in range(count)]
    return np.array(found)


def occupied(folder):
    with open(f"{folder}/map.yaml", encoding="utf-8") as file:
        yaml = dict(line.strip().split(": ", 1) for line in file if ": " in line)
    with open(f"{folder}/{yaml['image']}", "rb") as file:
        data = file.read()
    _, width, height, _ = data.split(None, 4)[:4] if b"#" not in data[:60] else (None, *[
        int(v) for line in data[:200].split(b"\n")[1:] if not line.startswith(b"#") for v in line.split() if v.isdigit()][:3])
    width, height = int(width), int(height)
    cells = np.frombuffer(data[-width * height:], np.uint8).reshape(height, width)
    rows, columns = np.nonzero(cells < 90)
    x, y = [float(v) for v in yaml["origin"].strip("[]").split(",")[:2]]
    size = float(yaml["resolution"])
    return np.column_stack([x + (columns + 0.5) * size, y + (height - rows - 0.5) * size])


def farthest(points, others):
    return max(np.hypot(*(others - point).T).min() for point in points)


def main():
    with tempfile.TemporaryDirectory() as work:
        for release in ("R12", "R2000", "R2018"):
            drawing = draw(release)
            drawing.saveas(f"{work}/{release}.dxf")
            command = [sys.argv[1], f"{work}/{release}", "--import", f"{work}/{release}.dxf"]
            if release == "R12":  # has no units
                refused = subprocess.run(command, text=True, capture_output=True, check=False)
                assert refused.returncode == 1 and "--unit" in refused.stderr, refused
                command += ["--unit", "mm"]
            said = subprocess.run(command, check=True, text=True, capture_output=True).stdout
            assert "A-WALL" in said and "ignored: A-DOOR" in said and "1 x on a hidden layer" in said, said
            walls, cells = spots(drawing), occupied(f"{work}/{release}")
            assert len(walls) > 2000 and len(cells) > 300, (len(walls), len(cells))
            extra, missing = farthest(cells, walls), farthest(walls, cells)
            assert extra < 2 * CELL_M, f"{release}: a cell is {extra:.3f} m from what ezdxf draws"
            assert missing < 3 * CELL_M, f"{release}: what ezdxf draws is {missing:.3f} m from any cell"
            print(f"{release}: {len(walls)} spots, {len(cells)} cells, at most {100 * max(extra, missing):.1f} cm apart")


main()
