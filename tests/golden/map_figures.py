"""What a folder of results says in figures that must not move: digests where files are the same byte for byte on every run,
numbers and words where they tell more."""
import hashlib
import json
import os
import re
import subprocess

DIGEST_LETTERS = 16
PARAMETER_DIGITS = 5


class NotMapped(Exception):
    """The program refused the recording; what it said last."""


def run(words, codes=(0,), **options):
    """@returns stdout. @throws NotMapped with the last line of stderr, where the program ends with another code."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **options)
    if done.returncode not in codes:
        raise NotMapped((done.stderr.strip() or f"{words[0]}: exit code {done.returncode}").splitlines()[-1])
    return done.stdout


def digest(path):
    if not os.path.exists(path):
        return None
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:DIGEST_LETTERS]


def rounded(value):
    return float(f"{value:.6g}") if isinstance(value, float) else value


def grid(out):
    if not os.path.exists(f"{out}/map.pgm"):
        return None
    with open(f"{out}/map.pgm", "rb") as file:
        width, height = re.match(rb"P5\s+(?:#.*\s+)*(\d+)\s+(\d+)", file.read(200)).groups()
    with open(f"{out}/map.yaml", encoding="utf-8") as file:
        resolution = re.search(r"^resolution: *(\S+)", file.read(), re.M)[1]
    return f"{int(width)} x {int(height)} cells of {resolution} m"


def vertices(ply):
    if not os.path.exists(ply):
        return None
    with open(ply, "rb") as file:
        return int(re.search(rb"element vertex (\d+)", file.read(1000))[1])


def reasons(report):
    return [f"{reason['cause']} from {reason['from_s']:.1f} to {reason['to_s']:.1f} s" if "from_s" in reason else reason["cause"]
            for reason in report.get("doctor", {}).get("reasons", [])]


def set_up(report):
    """Mount, wheels, clocks, beams, own body: what the drive said of them, and what is in force."""
    calibration = report.get("calibration", {})
    found = {parameter["name"]: f"{parameter['state']} {parameter.get('found', parameter['assumed']):.{PARAMETER_DIGITS}g}"
             for parameter in calibration.get("parameters", []) if parameter["state"] != "not_observed"}
    return {"use": calibration.get("use"), "remarks": calibration.get("remarks", []), "parameters": found,
            "path_of": report.get("path_of"), "own_body": report.get("own_body", []), "floor": report.get("floor", []),
            "notes": [note for one in report.get("inputs", []) for note in one["notes"]]}


def loops(report):
    found = report.get("loops", [])
    return f"{len(found)}, {sum(loop['in_force'] for loop in found)} in force"


def places(report):
    """Of sessions: the places at which they were found in the map."""
    found = report.get("place_in_saved_map", {}).get("found", [])
    return [f"{place['x_m']:.3f} {place['y_m']:.3f} m, {place['theta_rad']:.4f} rad" for place in found]


def model(out, report):
    surface = {name: value for name, value in report.get("surface", {}).items() if isinstance(value, (int, float))}
    scenes = report.get("scenes", {})
    registration = scenes.get("registration", {})
    return {**surface, "sweeps": scenes.get("count"), "vertices": vertices(f"{out}/model.ply"), "ply": digest(f"{out}/model.ply"),
            "registration": registration.get("status"), "joined": registration.get("joined"),
            "residual_m": registration.get("residual_after", {}).get("median_m")}


def without_nothing(value):
    """Nested dictionaries without what is None or empty, numbers with six digits."""
    if isinstance(value, dict):
        kept = {key: without_nothing(inner) for key, inner in value.items()}
        return {key: inner for key, inner in kept.items() if inner not in (None, {}, [])}
    if isinstance(value, list):
        return [without_nothing(inner) for inner in value]
    return rounded(value)


def read_report(out):
    with open(f"{out}/report.json", encoding="utf-8") as file:
        return json.load(file)


def of_model(out):
    """Figures of a folder that `marco model` wrote."""
    report = read_report(out)
    figures = {"poses": digest(f"{out}/poses.txt"), "ply": digest(f"{out}/model.ply"), "model": report["model"],
               "registration": report["registration"], "reason_of_doubt": report.get("reason_of_doubt"),
               "left_out": len(report["left_out"]), "cpu_s": round(report["cpu_s"], 1)}
    return without_nothing(figures)


def of_map(out):
    """Figures of a folder that `marco map` wrote."""
    report = read_report(out)
    scans = report["scans"]
    files = {"path": "trajectory.tum", "path_live": "trajectory_live.tum", "map": "map.pgm", "lines": "lines.json"}
    figures = {
        **{figure: digest(f"{out}/{name}") for figure, name in files.items()},
        "distance_m": report.get("distance_m"), "grid": grid(out), "walls": report.get("walls"),
        "verdict": report.get("verdict"), "reasons": reasons(report), "loops": loops(report), "places": places(report),
        "open_questions": len(report.get("doctor", {}).get("open_questions", [])) or None,
        "keyframes": scans["keyframes"],
        "scans": {key: value for key, value in scans.items() if key != "keyframes"},
        "set_up": set_up(report), "model": model(out, report), "errors": report.get("errors"),
        "cpu_s": round(report["cpu_s"], 1)}
    return without_nothing(figures)


def of_relations(programs, out, relations):
    """Errors of the path against hand-checked relative poses."""
    said = run([f"{programs}/marco-evaluate", f"{out}/trajectory.tum", relations])
    names = ("mean", "std", "p95", "max")
    spread = r" mean=(\S+) std=(\S+) p95=(\S+) max=(\S+)"
    count, *values = re.search(r"n=(\d+).*?translation_m" + spread + " rotation_deg" + spread, said).groups()
    return {"n": int(count), **{f"{name}_m": float(value) for name, value in zip(names, values[:4])},
            **{f"{name}_deg": float(value) for name, value in zip(names, values[4:])}}
