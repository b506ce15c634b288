#!/usr/bin/env python3
"""map_posts on a drive among eight posts that is made here: files plain and packed, both kinds of drive.csv, bearings
from the right, and what it says of files that are wrong. usage: posts_test.py MAP_POSTS"""
import gzip
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop(1)
POSTS = [(2, 2), (-2, 2.5), (3, -1), (-1, -2.5), (0.5, 4), (4, 3), (-3.5, -0.5), (1, -3.5)]
WHEELBASE = 1.2


def drive(seconds=60, step=0.1):
    """A circle of 2 m radius at 0.5 m/s, the robot's own frame at the start."""
    rows, poses, x, y, heading = [], [], 0.0, 0.0, 0.0
    for i in range(int(seconds / step)):
        speed = 0.0 if i == 0 else 0.5
        turn = 0.0 if i == 0 else 0.25 + 0.1 * math.sin(0.05 * i)
        middle = heading + 0.5 * turn * step
        x, y, heading = x + speed * step * math.cos(middle), y + speed * step * math.sin(middle), heading + turn * step
        rows.append((100 + i * step, speed, turn))
        poses.append((100 + i * step, x, y, heading))
    return rows, poses


def write(path, head, rows, packed):
    text = head + "\n" + "".join(",".join(f"{value:.6f}" for value in row) + "\n" for row in rows)
    with (gzip.open(path + ".gz", "wt") if packed else open(path, "w", encoding="utf-8")) as file:
        file.write(text)


class Posts(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def at(self, name):
        return os.path.join(self.folder.name, name)

    def make(self, packed=False, steering=False, zero=0.0):
        noise = random.Random(3)
        rows, poses = drive()
        if steering:
            rows = [(t, v, math.atan(w / v * WHEELBASE) if v else 0.0) for t, v, w in rows]
        write(self.at("drive.csv"), "time_s,speed_mps," + ("steering_rad" if steering else "turn_rate_radps"),
              [(t, v + noise.gauss(0, 0.02), w + noise.gauss(0, 0.02)) for t, v, w in rows], packed)
        sightings = []
        for t, x, y, heading in poses:
            for px, py in POSTS:
                distance = math.hypot(px - x, py - y)
                if distance < 5:
                    sightings.append((t, distance + noise.gauss(0, 0.02),
                                      math.atan2(py - y, px - x) - heading - zero + noise.gauss(0, 0.01), 0.1))
        write(self.at("sightings.csv"), "time_s,range_m,bearing_rad,diameter_m", sightings, packed)
        write(self.at("scans.csv"), "time_s", [(t,) for t, *_ in poses], packed)
        write(self.at("truth.csv"), "time_s,x_m,y_m", [(t, x + 7, y - 3) for t, x, y, _ in poses], packed)

    def run_it(self, *words):
        return subprocess.run([PROGRAM, self.folder.name, "-o", self.at("out"), *words], capture_output=True, text=True,
                              timeout=50, check=False)

    def expect_map(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(self.at("out/landmarks.json"), encoding="utf-8") as file:
            landmarks = json.load(file)["landmarks"]
        self.assertEqual(len(landmarks), len(POSTS))
        for landmark in landmarks:
            x, y = landmark["position_m"]
            self.assertLess(min(math.hypot(x - px, y - py) for px, py in POSTS), 0.06)
            self.assertAlmostEqual(landmark["diameter_m"], 0.1)
            self.assertGreater(landmark["covariance_m2"][0][0], 0)
        with open(self.at("out/report.json"), encoding="utf-8") as file:
            report = json.load(file)
        self.assertLess(report["truth"]["rms_m"], 0.03)
        self.assertGreater(report["truth"]["dead_reckoning_rms_m"], report["truth"]["rms_m"])
        with open(self.at("out/path.tum"), encoding="utf-8") as file:
            self.assertEqual(len(file.readlines()), 600)
        with open(self.at("out/landmarks.svg"), encoding="utf-8") as file:
            self.assertEqual(file.read().count('class="landmark"'), len(POSTS))
        return report

    def test_plain(self):
        self.make()
        report = self.expect_map(self.run_it())
        self.assertEqual(report["bearings"]["zero_rad"], 0)

    def test_packed_steering_and_bearings_from_the_right(self):
        self.make(packed=True, steering=True, zero=-math.pi / 2)
        with open(self.at("car.toml"), "w", encoding="utf-8") as file:
            file.write(f"[car]\nwheelbase_m = {WHEELBASE}\n")
        report = self.expect_map(self.run_it("--config", self.at("car.toml")))
        self.assertAlmostEqual(report["bearings"]["zero_rad"], -math.pi / 2)

    def test_what_is_wrong_is_said(self):
        self.assertIn("drive.csv", self.run_it().stderr)
        self.make(steering=True)
        self.assertIn("car.wheelbase_m", self.run_it().stderr)
        self.make()
        for text, said in (("time_s,speed_mps\n1,2\n", "turn_rate_radps"),
                           ("time_s,speed_mps,turn_rate_radps\n1,2\n", "drive.csv:2"),
                           ("time_s,speed_mps,turn_rate_radps\n1,2,nan\n", "not a finite number")):
            with open(self.at("drive.csv"), "w", encoding="utf-8") as file:
                file.write(text)
            result = self.run_it()
            self.assertEqual(result.returncode, 1)
            self.assertIn(said, result.stderr)
        self.assertFalse(os.path.exists(self.at("out")))

    def test_a_packed_file_that_ends_early_is_refused(self):
        self.make(packed=True)
        with open(self.at("drive.csv.gz"), "r+b") as file:
            file.truncate(os.path.getsize(self.at("drive.csv.gz")) // 2)
        result = self.run_it()
        self.assertEqual(result.returncode, 1)
        self.assertIn("damaged", result.stderr)


if __name__ == "__main__":
    unittest.main()
