#!/usr/bin/python3
"""Robots that are set up otherwise than their messages say: what marco-map finds, and what it costs the map.

usage: set_ups.py FOLDER_OF_PROGRAMS [--rows turned_30,...] [--seeds 1] [--keep FOLDER]

Each row is a drive through a furnished flat (drawn_worlds.py) with one thing wrong that SENSOR_INFO, ODOMETRY and IMU
do not tell, or tell wrongly. Said: the set-up line names it. Off: found less true, beside its goal (yaw 0.3 deg, place
10 mm, time 5 ms, scale 0.5 %) and in standard deviations. Map: rms of the path after the best fit, over that of the
same drive set up right; the goal is 1.2. Needs numpy and lcm-gen. Exit code 1 when a row misses a goal.
"""
import argparse
import importlib
import json
import math
import os
import struct
import subprocess
import sys
import tempfile

import numpy as np

from drawn_worlds import house
from worlds import World

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TYPES = ("lcmtypes/marco/odometry_t.lcm", "lcmtypes/marco/imu_t.lcm", "lcmtypes/marco/sensor_info_t.lcm",
         "lcm_tools/lcmtypes/bot_core/planar_lidar_t.lcm")
SCANS_PER_S, BEAMS, TRACK_M = 10.0, 241, 0.4

# Of the robot in its laser's view: first beam, last, range. All three are a quarter of the view.
POSTS = ((40, 52, 0.15), (180, 188, 0.2), (100, 138, 0.3))

# What is wrong, and the parameters that say so: the true value of each.
ROWS = {
    "right": ({}, {}),
    "turned_30": ({"yaw_deg": 30.0}, {"laser.yaw_deg": 30.0}),
    "turned_-90": ({"yaw_deg": -90.0}, {"laser.yaw_deg": -90.0}),
    "turned_137": ({"yaw_deg": 137.0}, {"laser.yaw_deg": 137.0}),
    "backwards": ({"yaw_deg": 180.0}, {"laser.yaw_deg": 180.0}),
    "upside_down": ({"upside_down": True, "gyro": True}, {"laser.upside_down": 1.0}),
    "off_30_cm": ({"x_m": 0.3}, {"laser.x_m": 0.3, "laser.y_m": 0.0}),
    "off_aside": ({"x_m": -0.1, "y_m": 0.3}, {"laser.x_m": -0.1, "laser.y_m": 0.3}),
    "wheels_0.5": ({"left": 0.5, "right": 0.5}, {"odometry.left_scale": 2.0, "odometry.right_scale": 2.0}),
    "wheels_1.5": ({"left": 1.5, "right": 1.5}, {"odometry.left_scale": 1 / 1.5, "odometry.right_scale": 1 / 1.5}),
    "unequal": ({"left": 1.1}, {"odometry.left_scale": 1 / 1.1, "odometry.right_scale": 1.0}),
    "forward_sign": ({"forward": -1.0}, {"odometry.forward_sign": -1.0}),
    "turn_sign": ({"turn": -1.0, "gyro": True}, {"odometry.turn_sign": -1.0}),
    "late_0.3": ({"late_s": 0.3}, {"odometry.late_s": 0.3}),
    "early_0.3": ({"late_s": -0.3}, {"odometry.late_s": -0.3}),
    "gyro_sign": ({"gyro": True, "gyro_scale": -1.0}, {"gyro.scale": -1.0}),
    "gyro_scale": ({"gyro": True, "gyro_scale": 1.2}, {"gyro.scale": 1 / 1.2}),
    "gyro_bias": ({"gyro": True, "gyro_bias": 0.03}, {"gyro.bias_rad_per_s": 0.03}),
    "gyro_late": ({"gyro": True, "gyro_late_s": 0.3}, {"gyro.late_s": 0.3}),
    "step_0.95": ({"step": 0.95}, {"beams.bearing_scale": 1 / 0.95}),
    "step_0.98": ({"step": 0.98}, {"beams.bearing_scale": 1 / 0.98}),
    "step_1.01": ({"step": 1.01}, {"beams.bearing_scale": 1 / 1.01}),
    "step_1.02": ({"step": 1.02}, {"beams.bearing_scale": 1 / 1.02}),
    "step_without": ({"step": 0.95, "silent": True}, {"beams.bearing_scale": 1 / 0.95}),
    "range_5_cm": ({"range_offset_m": 0.05}, {"beams.range_offset_m": -0.05}),
    "millimetres": ({"way": 1000.0}, {}),
    "degrees": ({"heading": math.degrees(1.0)}, {}),
    "both_units": ({"way": 1000.0, "heading": math.degrees(1.0)}, {}),
    "stamps_ms": ({"stamps": 1e-3}, {}),
    "stamps_none": ({"stamps": 0.0}, {}),
    "pitched_5": ({"pitch_deg": 5.0}, {}),
    "pitched_3": ({"pitch_deg": 3.0}, {}),
    "pitched_without": ({"pitch_deg": 5.0, "silent": True}, {}),
    "rolled_5": ({"pitch_deg": 5.0, "down_deg": 60.0}, {}),
    "posts": ({"posts": POSTS[:2]}, {}),
    "more_posts": ({"posts": POSTS}, {}),
    "no_odometry": ({"silent": True}, {}),
    "posts_without": ({"posts": POSTS[:2], "silent": True}, {}),
    "more_without": ({"posts": POSTS, "silent": True}, {}),
}
GOALS = {"laser.yaw_deg": 0.3, "laser.x_m": 0.01, "laser.y_m": 0.01, "odometry.late_s": 0.005, "gyro.late_s": 0.005,
         "odometry.left_scale": 0.005, "odometry.right_scale": 0.005, "odometry.track_scale": 0.005, "gyro.scale": 0.005,
         "gyro.bias_rad_per_s": 0.002, "beams.bearing_scale": 0.005, "beams.range_offset_m": 0.01}


LASER_M, CEILING_M = 0.2, 2.5


def tilted_ranges(world, x, y, heading, bearings, pitch_rad, down_rad):
    """Of a laser that looks down by pitch_rad under the bearing down_rad, 0.2 m above the floor."""
    b = bearings - down_rad
    across, along, down = np.sin(b), np.cos(b) * math.cos(pitch_rad), np.cos(b) * math.sin(pitch_rad)
    level = world.ranges(x, y, heading + down_rad + np.arctan2(across, along), 12.0) / np.hypot(across, along)
    with np.errstate(divide="ignore"):
        return np.minimum(level, np.where(down > 0, LASER_M / down, (LASER_M - CEILING_M) / down))


class Log:
    """An LCM event log."""

    def __init__(self, path):
        self.file, self.number = open(path, "wb"), 0

    def write(self, utime, channel, message):
        data, name = message.encode(), channel.encode()
        self.file.write(struct.pack(">IqqII", 0xEDA1DA01, self.number, utime, len(name), len(data)) + name + data)
        self.number += 1


def smooth_drive(tour, speed=0.45, turn_rate=math.radians(70)):
    """Poses each 20 ms: straight on, turns on the spot and, where a corner is flat, arcs; speeds ramp up and down."""
    dt = 0.02
    poses = []
    x, y = tour[0]
    h = math.atan2(tour[1][1] - y, tour[1][0] - x)

    def ramp(length, fastest, most_acceleration):
        """Steps that add up to a length."""
        v, done = 0.0, 0.0
        while done < length - 1e-9:
            v = min(v + most_acceleration * dt, fastest, math.sqrt(2 * most_acceleration * max(length - done, 1e-4)))
            step = min(v * dt, length - done)
            done += step
            yield step

    for (ax, ay), (bx, by) in zip(tour, tour[1:]):
        if math.hypot(bx - ax, by - ay) < 1e-6:
            continue
        wanted = math.atan2(by - y, bx - x)
        off = (wanted - h + math.pi) % (2 * math.pi) - math.pi
        flat = abs(off) < math.radians(50)
        if not flat:
            for step in ramp(abs(off), turn_rate, math.radians(150)):
                h += math.copysign(step, off)
                poses.append((x, y, h))
        length = math.hypot(bx - x, by - y)
        driven = 0.0
        for step in ramp(length, speed, 0.6):
            wanted = math.atan2(by - y, bx - x)
            off = (wanted - h + math.pi) % (2 * math.pi) - math.pi
            if length - driven > 0.25:
                # A weave, too: arcs both ways, as people drive.
                h += max(-0.02, min(0.02, 2.0 * off * dt + 0.012 * math.sin(3.0 * driven)))
            x, y = x + step * math.cos(h), y + step * math.sin(h)
            driven += step
            poses.append((x, y, h))
    return [(1000.0 + i * dt, *pose) for i, pose in enumerate(poses)]


def types(folder):
    subprocess.run(["lcm-gen", "-p", "--ppath", folder, *(os.path.join(ROOT, name) for name in TYPES)], check=True)
    sys.path.insert(0, folder)
    return {name: importlib.import_module(name) for name in ("marco", "bot_core")}


def write_info(lcm, log, utime):
    info = lcm["marco"].sensor_info_t()
    info.utime, info.channel, info.mount = utime, "LIDAR", 0
    info.parent_from_sensor_m, info.parent_from_sensor_quat = [0.0, 0.0, LASER_M], [1.0, 0.0, 0.0, 0.0]
    info.range_min_m, info.range_max_m, info.range_sigma_m = 0.05, 12.0, 0.01
    log.write(utime, "SENSOR_INFO", info)


def write(lcm, path, set_up, seed):
    world = World([seed, 78])
    tour = house(world, furniture=5)
    poses = smooth_drive(tour)
    r = np.random.default_rng([seed, 79])
    log = Log(path)
    x_m, y_m, yaw = set_up.get("x_m", 0.0), set_up.get("y_m", 0.0), math.radians(set_up.get("yaw_deg", 0.0))
    flip = -1.0 if set_up.get("upside_down") else 1.0
    bearings = np.linspace(-2 * math.pi / 3, 2 * math.pi / 3, BEAMS)
    events, odom, gyro = [], [0.0, 0.0, 0.0], set_up.get("gyro", False)
    before = poses[0]
    for i, pose in enumerate(poses):
        t, x, y, h = pose
        d = math.cos(before[3]) * (x - before[1]) + math.sin(before[3]) * (y - before[2])
        turn = (h - before[3] + math.pi) % (2 * math.pi) - math.pi
        before = pose
        # What the wheels count, with 1 % of noise of each step.
        left, right = ((d + s * turn * TRACK_M / 2) * set_up.get(side, 1.0) * (1 + r.normal(0, 0.02))
                       for s, side in ((-1, "left"), (1, "right")))
        way, angle = set_up.get("forward", 1.0) * (left + right) / 2, set_up.get("turn", 1.0) * (right - left) / TRACK_M
        odom[0] += way * math.cos(odom[2] + angle / 2)
        odom[1] += way * math.sin(odom[2] + angle / 2)
        odom[2] += angle
        message = lcm["marco"].odometry_t()
        message.utime = round(1e6 * (t + set_up.get("late_s", 0.0)))
        way_unit, turn_unit = set_up.get("way", 1.0), set_up.get("heading", 1.0)
        message.x_m, message.y_m, message.theta_rad = way_unit * odom[0], way_unit * odom[1], turn_unit * odom[2]
        if not set_up.get("silent"):
            events.append((message.utime, "ODOMETRY", message))
        if gyro:
            message = lcm["marco"].imu_t()
            message.utime = round(1e6 * (t + set_up.get("gyro_late_s", 0.0)))
            rate = set_up.get("gyro_scale", 1.0) * turn / 0.02 + set_up.get("gyro_bias", 0.0) + r.normal(0, 0.01)
            message.angular_velocity_rad_per_s = [0.0, 0.0, rate]
            message.acceleration_m_per_s2 = [float("nan")] * 3
            events.append((message.utime, "IMU", message))
        if i % round(50 / SCANS_PER_S) == 0:
            lx, ly = x + x_m * math.cos(h) - y_m * math.sin(h), y + x_m * math.sin(h) + y_m * math.cos(h)
            ranges = world.ranges(lx, ly, h + yaw + flip * bearings, 12.0)
            if "pitch_deg" in set_up:
                ranges = tilted_ranges(world, lx, ly, h, bearings, math.radians(set_up["pitch_deg"]),
                                       math.radians(set_up.get("down_deg", 0.0)))
            ranges = np.where(ranges < 12.0, ranges + r.normal(0, 0.01, BEAMS), 12.0)
            ranges = np.where(ranges < 12.0, ranges + set_up.get("range_offset_m", 0.0), ranges)
            for first, last, post_m in set_up.get("posts", ()):
                ranges[first:last + 1] = post_m + r.normal(0, 0.005, last + 1 - first)
            message = lcm["bot_core"].planar_lidar_t()
            message.utime, message.nranges, message.ranges = round(1e6 * t), BEAMS, [float(v) for v in ranges]
            message.rad0, message.radstep = (set_up.get("step", 1.0) * float(b) for b in (bearings[0], bearings[1] - bearings[0]))
            events.append((message.utime, "LIDAR", message))
    events += [(round(1e6 * t) - 1000, "INFO", None) for t in np.arange(poses[0][0], poses[-1][0])]
    events.sort(key=lambda event: event[0])
    for utime, channel, message in events:
        if message is not None:
            message.utime = round(set_up.get("stamps", 1.0) * message.utime)
        if message is None:
            write_info(lcm, log, utime)
        else:
            log.write(utime, channel, message)
    log.file.close()
    with open(path + ".tum", "w", encoding="utf-8") as file:
        for t, x, y, h in poses[::round(50 / SCANS_PER_S)]:
            file.write(f"{t:.6f} {x:.6f} {y:.6f} 0 0 0 {math.sin(h / 2):.9f} {math.cos(h / 2):.9f}\n")


def path_of(name):
    poses = {}
    with open(name, encoding="utf-8") as file:
        for line in file:
            v = [float(value) for value in line.split()] if line[0] != "#" else []
            if v:
                poses[round(v[0], 3)] = (complex(v[1], v[2]), 2 * math.atan2(v[6], v[7]))
    return poses


def rms_of(out, truth, set_up):
    """Of the laser's places, which the path means, as it says where the laser sits at no place else."""
    ours, true = path_of(f"{out}/trajectory.tum"), path_of(truth)
    offset = complex(set_up.get("x_m", 0.0), set_up.get("y_m", 0.0))
    pairs = [(ours[t][0], true[t][0] + offset * complex(math.cos(true[t][1]), math.sin(true[t][1]))) for t in ours if t in true]
    a0, b0 = sum(a for a, _ in pairs) / len(pairs), sum(b for _, b in pairs) / len(pairs)
    cross = sum((a - a0).conjugate() * (b - b0) for a, b in pairs)
    turn = cross / abs(cross)
    return math.sqrt(sum(abs(turn * (a - a0) - (b - b0)) ** 2 for a, b in pairs) / len(pairs))


def off_by(name, entry, true):
    off = entry.get("found", entry["assumed"]) - true
    if name.endswith("_deg"):
        off = (off + 180) % 360 - 180
    return off


def judge(options, lcm, folder, row, seed, right_m):
    set_up, wanted = ROWS[row]
    log = os.path.join(folder, f"{row}.{seed}.lcm")
    if not os.path.exists(log):
        write(lcm, log + ".part", set_up, seed)
        os.rename(log + ".part", log)
        os.rename(log + ".part.tum", log + ".tum")
    out = log[:-4]
    done = subprocess.run([f"{options.programs}/marco-map", log, "--out", out], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        print(f"{row:12} {seed}: no map\n{done.stdout}{done.stderr}")
        return None
    with open(f"{out}/report.json", encoding="utf-8") as file:
        report = json.load(file)
    rms = rms_of(out, log + ".tum", set_up)
    found = {p["name"]: p for p in report.get("calibration", {}).get("parameters", [])}
    ratio = rms / right_m if right_m else 1.0
    misses, texts = [], []
    if len(report.get("own_body", [])) != len(set_up.get("posts", ())):
        misses.append(f"own body {report.get('own_body')}")
    for name, true in wanted.items():
        entry = found.get(name)
        if entry is None:
            misses.append(f"{name} unknown")
            continue
        off, sigma = off_by(name, entry, true), entry.get("sigma", 0.0)
        texts.append(f"{name} {entry.get('found', math.nan):.4f} off {off:+.4f}" + (f" ({off / sigma:+.1f} sd)" if sigma else ""))
        goal = GOALS.get(name, 1e-9)
        if abs(off) > goal * (max(1.0, abs(true)) if name.endswith("scale") else 1.0):
            misses.append(f"{name}: {off:+.4f}")
        if sigma and abs(off) > 2 * sigma:
            misses.append(f"{name}: {off / sigma:+.1f} sd")
        if entry["state"] != "off" and abs(entry["assumed"] - true) > goal:
            misses.append(f"{name} {entry['state']}")
    # What is right must not be said to be wrong.
    for name, entry in found.items():
        if name not in wanted and entry["state"] == "off":
            true = entry["assumed"]
            texts.append(f"[{name} {entry['found']:.4f}]")
            if abs(off_by(name, entry, true)) > GOALS.get(name, 1e-9):
                misses.append(f"{name} {entry['found']:.4f} (sd {entry.get('sigma', 0):.4f})")
    if ratio > 1.2:
        misses.append(f"map {ratio:.2f}")
    print(f"{row:12} {seed}  {1000 * rms:7.1f} mm  x{ratio:5.2f}  {report['verdict']:8} {report.get('calibration', {}).get('use', '-'):10} "
          f"{', '.join(texts)}{'  MISSED: ' + '; '.join(misses) if misses else ''}", flush=True)
    return rms, not misses


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--rows", default=",".join(ROWS))
    parser.add_argument("--seeds", default="1")
    parser.add_argument("--keep")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        lcm = types(temporary)
        missed = 0
        for seed in (int(s) for s in options.seeds.split(",")):
            right = judge(options, lcm, folder, "right", seed, None)
            for row in options.rows.split(","):
                if row != "right":
                    result = judge(options, lcm, folder, row, seed, right[0] if right else None)
                    missed += 0 if result and result[1] else 1
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
