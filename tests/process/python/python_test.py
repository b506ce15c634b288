#!/usr/bin/env python3
"""The Python module: recordings, maps, matching and evaluation against what the programs say of the same recording, a
robot against the simulator, the lesson.

Usage: python_test.py BIN_FOLDER MODULE_FOLDER      (in the project's folder)
"""
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
import unittest

BIN, MODULE = (os.path.abspath(path) for path in sys.argv[1:3])
sys.path.insert(0, MODULE)
import numpy as np  # noqa: E402

import marco  # noqa: E402

LOG = "logs/sample.lcm"
START = (2.0, 3.0)
LASER_AHEAD_M = 0.15  # in the sample


def load_tum(path):
    rows = np.loadtxt(path)
    return np.column_stack([rows[:, :3], 2 * np.arctan2(rows[:, 6], rows[:, 7])])


class Recordings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        subprocess.run([f"{BIN}/marco-map", LOG, "--out", cls.folder.name], check=True, capture_output=True)
        with open(f"{cls.folder.name}/report.json", encoding="utf-8") as file:
            cls.report = json.load(file)
        cls.recording = marco.read(LOG)
        cls.map = marco.map(LOG)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_a_recording_is_read_as_arrays(self):
        given = self.report["inputs"][0]["read"]
        self.assertEqual(len(self.recording.scans), given["scans"])
        self.assertEqual(len(self.recording.odometry), given["odometry"])
        self.assertEqual(self.recording.format, self.report["inputs"][0]["format"])
        scan = self.recording.scans[3]
        self.assertEqual(scan.ranges.shape, scan.bearings.shape)
        returned = np.isfinite(scan.ranges)
        points = scan.points()
        self.assertEqual(points.shape, (returned.sum(), 2))
        np.testing.assert_allclose(np.hypot(*points.T), scan.ranges[returned], atol=1e-6)
        np.testing.assert_allclose(np.arctan2(points[:, 1], points[:, 0]), scan.bearings[returned], atol=1e-6)
        self.assertTrue(np.all(np.diff([scan.time for scan in self.recording.scans]) > 0))

    def test_a_map_is_the_one_that_marco_map_writes(self):
        np.testing.assert_allclose(self.map.trajectory, load_tum(f"{self.folder.name}/trajectory.tum"), atol=1e-5)
        self.assertEqual(self.map.verdict, self.report["verdict"])
        self.assertEqual(self.map.loops, len(self.report["loops"]))
        with tempfile.TemporaryDirectory() as saved:
            self.map.save(saved)
            for name in ("map.pgm", "map.yaml"):
                with open(f"{saved}/{name}", "rb") as mine, open(f"{self.folder.name}/{name}", "rb") as theirs:
                    self.assertEqual(mine.read(), theirs.read())
        known = self.map.grid[self.map.grid != 255]
        self.assertGreater((known > 60).sum(), 100)
        self.assertEqual(known.max() <= 100, True)

    def test_settings_are_taken_from_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(f"{folder}/coarse.toml", "w", encoding="utf-8") as file:
                file.write("[slam.grid]\nresolution_m = 0.1\n")
            coarse = marco.map([LOG], config=f"{folder}/coarse.toml")
        self.assertEqual((coarse.resolution, self.map.resolution), (0.1, 0.05))
        self.assertIn("[slam.grid]", marco.settings())

    def test_two_scans_match_as_the_map_has_them(self):
        first, second = self.recording.scans[0], self.recording.scans[20]
        (x0, y0, a0), (x1, y1, a1) = (
            self.map.trajectory[np.argmin(abs(self.map.trajectory[:, 0] - scan.time)), 1:] for scan in (first, second))
        # As seen from the laser, which sits ahead of the robot's origin.
        dx, dy = (b + LASER_AHEAD_M * f(a1) - a - LASER_AHEAD_M * f(a0)
                  for a, b, f in ((x0, x1, math.cos), (y0, y1, math.sin)))
        self.assertGreater(math.hypot(dx, dy), 0.2)
        match = marco.match(first.points(), second.points())
        self.assertTrue(match.converged)
        self.assertGreater(match.overlap, 0.5)
        expected = (math.cos(a0) * dx + math.sin(a0) * dy, math.cos(a0) * dy - math.sin(a0) * dx,
                    math.remainder(a1 - a0, 2 * math.pi))
        np.testing.assert_allclose(match.pose, expected, atol=0.015)
        wrong = marco.match(first.points(), np.random.default_rng(1).uniform(-4, 4, (200, 2)))
        self.assertLess(wrong.overlap, 0.7 * match.overlap)

    def test_an_error_is_an_exception_with_the_programs_words(self):
        for call in (marco.read, marco.map):
            with self.assertRaisesRegex(ValueError, "there is no such file"):
                call("/nonexistent/log")

    def test_a_trajectory_is_evaluated_as_by_marco_evaluate(self):
        odometry = self.map.odometry
        with tempfile.TemporaryDirectory() as folder:
            path = f"{folder}/log.relations"
            with open(path, "w", encoding="utf-8") as file:
                file.write(f"{odometry[5, 0]:.6f} {odometry[-5, 0]:.6f} 0 0 0 0 0 0\n")
            said = subprocess.run([f"{BIN}/marco-evaluate", f"{self.folder.name}/trajectory.tum", path], check=True,
                                  capture_output=True, text=True).stdout
            found = marco.evaluate(self.map.trajectory, path)
        self.assertEqual(found["n"], 1)
        self.assertEqual(f"{found['mean_m']:.4f}", re.search(r"translation_m mean=(\S+)", said)[1])

    def test_the_lesson(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, os.path.abspath("examples/lesson.py"), os.path.abspath(LOG)], cwd=folder,
                                  env=dict(os.environ, PYTHONPATH=MODULE), capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"{len(self.recording.scans)} scans", done.stdout)
        self.assertRegex(done.stdout, "lesson.png is drawn|install matplotlib")


class LiveRobot(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        with open(f"{self.folder.name}/tour.toml", "w", encoding="utf-8") as file:
            file.write(f"start_m = [{START[0]}, {START[1]}]\n")
        ports = f"{self.folder.name}/ports"
        robot = "config/robots/michoacan"
        os.mkdir(ports)
        self.programs = []
        self.start("marco-sim", "--config", f"{robot}.toml", "--world", "config/worlds/lab.toml", "--tour",
                   f"{self.folder.name}/tour.toml", "--ports", ports)
        self.wait_for(f"{ports}/laser")
        self.start("marco-base", "--config", f"{robot}/base.toml", "--device", f"{ports}/base")
        self.start("marco-sick", "--config", f"{robot}/sick.toml", "--device", f"{ports}/laser")
        self.start("marco-slam")

    def tearDown(self):
        for program in self.programs:
            program.terminate()
        for program in self.programs:
            program.wait(20)
        self.folder.cleanup()

    def start(self, name, *arguments):
        with open(f"{self.folder.name}/{name}.log", "w", encoding="utf-8") as log:
            self.programs.append(subprocess.Popen([f"{BIN}/{name}", *arguments], stdout=log, stderr=log))

    def wait_for(self, path):
        end = time.monotonic() + 20
        while not os.path.exists(path):
            self.assertLess(time.monotonic(), end, path)
            time.sleep(0.05)

    def test_it_is_seen_driven_and_stops_by_itself(self):
        robot = marco.Robot()
        scan = robot.scan(timeout=60.0)
        self.assertEqual(len(scan), 361)
        self.assertGreater(np.isfinite(scan.ranges).sum(), 300)
        _, x0, y0, heading = robot.odometry(timeout=30.0)
        robot.pose(timeout=30.0)
        robot.drive(0.2, seconds=2.0)
        robot.odometry()
        _, x1, y1, _ = robot.odometry()
        ahead = math.cos(heading) * (x1 - x0) + math.sin(heading) * (y1 - y0)
        self.assertGreater(ahead, 0.2)
        _, x, y, _ = robot.pose()
        self.assertGreater(math.hypot(x, y), 0.0)
        # One order holds for half a second.
        robot.drive(0.2)
        time.sleep(2.0)
        robot.odometry()
        _, x2, y2, _ = robot.odometry()
        time.sleep(0.5)
        robot.odometry()
        _, x3, y3, _ = robot.odometry()
        self.assertGreater(math.hypot(x2 - x1, y2 - y1), 0.03)
        self.assertLess(math.hypot(x2 - x1, y2 - y1), 0.3)
        self.assertLess(math.hypot(x3 - x2, y3 - y2), 0.005)

    def test_silence_is_a_timeout_and_nonsense_is_refused(self):
        robot = marco.Robot("memq://")
        with self.assertRaisesRegex(TimeoutError, "SLAM_POSE"):
            robot.pose(timeout=0.1)
        with self.assertRaises(ValueError):
            robot.drive(math.nan)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
