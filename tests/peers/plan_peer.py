"""ezdxf on a plan that marco-plan wrote: nothing to mend, units, layers and blocks as documented, walls where plan.json has them,
dimensions that say what ezdxf measures, a room's name in any script.

usage: plan_peer.py MARCO_MAP MARCO_PLAN LOG
"""
import json
import subprocess
import sys
import tempfile

import ezdxf
from ezdxf import recover

LAYERS = {"WALLS", "WALLS_UNSEEN", "WINDOWS", "DOORS", "ROOMS", "DIMENSIONS", "COLUMNS", "FURNITURE"}
METRES = 6
NAME = "Łazienka Κουζίνα Кухня المطبخ 厨房"


def extent(points):
    xs, ys = [point[0] for point in points], [point[1] for point in points]
    return min(xs), min(ys), max(xs), max(ys)


def corners_of(geometry):
    """All corners of a GeoJSON geometry."""
    def flat(value):
        if isinstance(value[0], (int, float)):
            yield value
        else:
            for inner in value:
                yield from flat(inner)
    return flat(geometry["coordinates"])


def main():
    marco_map, marco_plan, log = sys.argv[1:]
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([marco_map, log, "--out", out], check=True, stdout=subprocess.DEVNULL)
        with open(f"{out}/names.txt", "w", encoding="utf-8") as file:
            file.write(NAME + "\n")
        subprocess.run([marco_plan, out, "--names", f"{out}/names.txt"], check=True, stdout=subprocess.DEVNULL)
        drawing = ezdxf.readfile(f"{out}/plan.dxf")
        recovered, auditor = recover.readfile(f"{out}/plan.dxf")
        with open(f"{out}/plan.json", encoding="utf-8") as file:
            plan = json.load(file)
    assert not auditor.errors and not auditor.fixes, [entry.message for entry in auditor.errors + auditor.fixes]
    assert drawing.units == METRES, drawing.units
    missing = LAYERS - {layer.dxf.name for layer in drawing.layers}
    assert not missing, missing
    assert {"DOOR", "OPENING"} <= {block.name for block in drawing.blocks}
    walls = [line for line in drawing.modelspace().query('LINE[layer=="WALLS" | layer=="WALLS_UNSEEN"]')]
    assert walls, "no walls"
    names = [text.dxf.text for text in recovered.modelspace().query('TEXT[layer=="ROOMS"]')]
    assert NAME in names, names
    dimensions = list(drawing.modelspace().query("DIMENSION"))
    rooms = [feature for feature in plan["features"] if feature["properties"].get("kind") == "room"]
    assert len(dimensions) >= 2 * len(rooms) + 2, len(dimensions)
    for dimension in dimensions:
        drawn_text = [text.dxf.text for text in dimension.get_geometry_block().query("TEXT")]
        assert len(drawn_text) == 1 and abs(float(drawn_text[0]) - dimension.get_measurement()) < 0.0051, drawn_text
    sizes = [dimension.get_measurement() for dimension in dimensions]
    for room in rooms:
        for size in room["properties"]["clear_size_m"]:
            assert min(abs(size - one) for one in sizes) < 0.001, size
    drawn = extent([point for line in walls for point in (line.dxf.start, line.dxf.end)])
    rooms = extent([corner for feature in plan["features"] if feature["properties"].get("kind") == "room"
                    for corner in corners_of(feature["geometry"])])
    print(f"{len(walls)} lines of walls; extent in plan.dxf {drawn}, of the rooms in plan.json {rooms}")
    assert all(abs(a - b) < 1.0 for a, b in zip(drawn, rooms))


if __name__ == "__main__":
    main()
