"""The recordings of the golden set: name, how it is mapped, and its figures."""
import contextlib
import dataclasses
import glob
import os
import re
import shutil
import sys
import tempfile

import map_figures
from map_figures import NotMapped, run

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FILES = (".log", ".clf", ".lcm", ".lcmlog", ".bag", ".mcap", ".db3")
SEED = 1
MAPPED = (0, 3)  # exit codes of a map: 3, a wrong one

# Others than a plain map of one recording, by the arguments of `marco map`, paths below the data.
VARIANTS = {
    "intel/intel.log --lines": ["intel/intel.log", "--lines"],
    "intel/intel.log --hold-out 5": ["intel/intel.log", "--hold-out", "5"],
    "mbot/mbot_convex.lcmlog --no-calibration": ["mbot/mbot_convex.lcmlog", "--no-calibration"],
    "rosbags/guardian_3.bag --calibrate": ["rosbags/guardian_3.bag", "--calibrate"],
}
MODELS = {
    "scans/room": ["scans/room_scan1.pcd", "scans/room_scan2.pcd"],
    "scans/capture": ["scans/capture1.pcd", "scans/capture2.pcd", "scans/capture3.pcd"],
    "scans/utm": ["scans/utm_a.ptx", "scans/utm_b.ptx"],
}
LIVE = ("live/michoacan", "live/create")


@dataclasses.dataclass
class Place:
    programs: str
    data: str | None  # MARCO_TEST_DATA
    out: str = ""     # a folder of the entry's own


def recordings(data):
    """Files that may be recordings, and folders that are one, relative to `data`."""
    for folder, folders, names in sorted(os.walk(data)):
        if "metadata.yaml" in names or any(name.endswith(".3d") or name == "scan_polar.csv" for name in names):
            folders.clear()
            yield os.path.relpath(folder, data)
            continue
        yield from (os.path.relpath(os.path.join(folder, name), data) for name in sorted(names) if name.endswith(FILES))


def mapped(place, arguments, world=None):
    of_world = ["--world", world] if world else []
    run([f"{place.programs}/marco-map", *arguments, "--out", place.out, *of_world], MAPPED)
    return map_figures.of_map(place.out)


def of_recording(place, name):
    figures = mapped(place, [f"{place.data}/{name}"])
    relations = f"{place.data}/{os.path.splitext(name)[0]}.relations"
    if os.path.exists(relations):
        figures["relations"] = map_figures.of_relations(place.programs, place.out, relations)
    return figures


def of_variant(place, name):
    arguments = [f"{place.data}/{word}" if os.path.exists(f"{place.data}/{word}") else word for word in VARIANTS[name]]
    return mapped(place, arguments)


def of_model(place, name):
    run([f"{place.programs}/marco-model", *(f"{place.data}/{scan}" for scan in MODELS[name]), "--out", place.out])
    return map_figures.of_model(place.out)


def simulate(place, log, world, tour, seed, *options):
    run([f"{place.programs}/marco-simulate", "--world", world, "--tour", tour, "--seed", seed, "--out", log, *options])
    return map_figures.digest(log)


def of_world(place, world, tour, judged_by, seed=SEED):
    log = place.out + ".lcm"
    simulated = simulate(place, log, world, tour, seed)
    figures = mapped(place, [log], judged_by)
    run([f"{place.programs}/marco-plan", place.out])
    return {**figures, "recording": simulated, "plan": map_figures.digest(f"{place.out}/plan.json")}


def world_file(name):
    return f"{ROOT}/config/worlds/{name}.toml"


def of_tour(place, name):
    """A tour of ours, simulated/WORLD."""
    world = os.path.basename(name)
    return of_world(place, world_file(world), f"{ROOT}/config/tours/{world}.toml", world_file(world))


def of_given_tour(place, name):
    """A tour of the data's, tours/WORLD_*.toml."""
    world = world_file(os.path.basename(name).split("_")[0])
    return of_world(place, world, f"{place.data}/{name}", world)


def of_walkers(place, name):
    """The office with people in it, judged by the empty one."""
    return of_world(place, f"{place.data}/{name}", f"{ROOT}/config/tours/office.toml", world_file("office"), seed=3)


def of_sessions(place, _):
    """Two drives through one building: the second one is localized in the map of the first, and extends it."""
    logs = [f"{place.out}_{seed}.lcm" for seed in (1, 2)]
    for seed, log in enumerate(logs, 1):
        simulate(place, log, world_file("flat"), f"{ROOT}/config/tours/flat.toml", seed)
    return mapped(place, logs, world_file("flat"))


def of_sensors(place, name):
    """A drive of an RPLIDAR: beams one after the other, at bearings of their own."""
    log = place.out + ".lcm"
    preset = ["--preset", os.path.basename(name)]
    simulated = simulate(place, log, world_file("flat"), f"{ROOT}/config/tours/flat.toml", SEED, *preset)
    return {**mapped(place, [log], world_file("flat")), "recording": simulated}


def be_punctual():
    """Before all others, where we may: a driver that waits half a second for a core counts as hung, and the robot is stopped."""
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))


def of_live(place, name):
    robot = os.path.basename(name)
    alone = [f"{ROOT}/lcm_tools/tests/support/isolated.sh", sys.executable]
    said = run([*alone, f"{ROOT}/tests/golden/live_drive.py", place.programs, robot, place.out], (0, 77), preexec_fn=be_punctual)
    if "SKIPPED" in said:
        raise NotMapped(said.strip().splitlines()[-1])
    log = f"{place.out}/live.lcm"
    place = dataclasses.replace(place, out=f"{place.out}/map")
    figures = mapped(place, [log], world_file("lab"))
    errors = {name: value for name, value in figures["errors"].items() if not name.startswith("model")}
    live = run([f"{place.programs}/marco-evaluate", f"{place.out}/trajectory_live.tum", "--recorded", log])
    apart = re.search(r"rms=(\S+)", live)
    return {"verdict": figures["verdict"], "scans": figures["scans"]["posed"], "keyframes": figures["keyframes"],
            "distance_m": figures["distance_m"], "sweeps": figures.get("model", {}).get("sweeps", 0), "errors": errors,
            "live_from_batch_m": float(apart[1]), "cpu_s": figures["cpu_s"]}


def all_names(data):
    """Every name there may be, those of the data only where it is."""
    names = [f"simulated/{os.path.basename(tour)[:-5]}" for tour in sorted(glob.glob(f"{ROOT}/config/tours/*.toml"))
             if os.path.exists(world_file(os.path.basename(tour)[:-5]))]
    names += ["sessions/flat", "sensors/harsh", "sensors/rover_7hz", *LIVE]
    if data:
        names += [*recordings(data), *VARIANTS, *MODELS]
        tours = sorted(glob.glob(f"{data}/tours/*.toml") + glob.glob(f"{data}/users/*walkers*.toml"))
        names += [os.path.relpath(path, data) for path in tours]
    return names


KINDS = [  # first match
    (r"simulated/", of_tour), (r"sessions/", of_sessions), (r"sensors/", of_sensors), (r"live/", of_live),
    (r"tours/.*\.toml$", of_given_tour), (r".*walkers.*\.toml$", of_walkers)]
OF_US = ("simulated/", "sessions/", "sensors/", "live/")  # need no data


def kind_of(name):
    if name in VARIANTS:
        return of_variant
    if name in MODELS:
        return of_model
    return next((kind for pattern, kind in KINDS if re.match(pattern, name)), of_recording)


def figures_of(programs, data, name):
    """@throws NotMapped with why."""
    folder = tempfile.mkdtemp(prefix="golden_")
    try:
        return kind_of(name)(Place(programs, data, f"{folder}/out"), name)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
