#!/usr/bin/env python3
"""A goal that a browser gave, with the home-made base on the simulator: whatever dies, the robot stands within a second.
usage: page_goal_test.py BIN ROOT"""
import math
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import page_bus
from page_client import Client
from page_process import BIN, ROOT, Page, eventually

KIND_STOP, KIND_VELOCITY, KIND_GO_TO = 0, 3, 4


class Goals(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bus = page_bus.Bus()
        cls.folder = tempfile.TemporaryDirectory()
        ports = os.path.join(cls.folder.name, "ports")
        world = os.path.join(cls.folder.name, "hall.toml")
        with open(world, "w") as out:
            out.write("floor_m = [0, 0, 60, 20]\n[[walls]]\ncorners_m = [0, 0, 60, 0, 60, 20, 0, 20, 0, 0]\n")
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        robots = os.path.join(ROOT, "config/robots")
        cls.robot = [
            subprocess.Popen([os.path.join(BIN, "marco-sim"), "--config", robots + "/homemade.toml", "--world", world,
                              "--start", "5", "10", "0", "--ports", ports], **quiet),
            subprocess.Popen([os.path.join(BIN, "marco-textbase"), "--config", robots + "/homemade/textbase.toml",
                              "--device", ports + "/base"], **quiet)]

    @classmethod
    def tearDownClass(cls):
        for process in cls.robot:
            process.terminate()
            process.wait()
        cls.folder.cleanup()

    def setUp(self):
        self.page = Page()
        self.addCleanup(self.page.process.kill)
        self.assertTrue(eventually(lambda: {"TRUE_POSE", "ODOMETRY", "BASE_STATUS"} <= set(self.bus.last), 20))
        self.client = Client(8765)
        self.client.subscribe("page/goal")
        self.client.advertise(1, "/goal_pose")
        self.assertTrue(self.client.wait(lambda: "ODOMETRY" in self.client.channels, 5))
        self.rest()

    def poses(self, since):
        return [(at, struct.unpack(">3d", payload[16:40])) for at, name, payload in list(self.bus.heard)
                if name == "TRUE_POSE" and at >= since]

    def way(self, since):
        """In metres, a turn of the robot's edge among them."""
        poses = [pose for _, pose in self.poses(since)]
        return sum(math.hypot(b[0] - a[0], b[1] - a[1]) + 0.2 * abs(math.remainder(b[2] - a[2], math.tau))
                   for a, b in zip(poses, poses[1:]))

    def rest(self):
        self.assertTrue(eventually(lambda: self.way(time.time() - 1.0) < 0.001 and self.poses(time.time() - 1.0), 10))
        del self.bus.heard[:]

    def go(self, x=55.0, alive=True):
        """Drives towards a point of the odometry's frame, and says `alive` for a while. On a host that stands still for half a
        second the goal ends, as it should: then once more."""
        for _ in range(3):
            self.client.publish(1, {"header": {"frame_id": "odom"}, "pose": {"position": {"x": x, "y": 0.2}}})
            begun, moved = time.time(), False
            while time.time() < begun + 5.0 and not (moved and time.time() > begun + 1.8):
                if alive:
                    self.client.text({"op": "alive"})
                self.client.wait(lambda: False, 0.1)
                moved = self.way(time.time() - 0.2) > 0.01  # it slips now and then
            if moved and self.client.of("page/goal")[-1]["active"]:
                return
        self.fail(self.client.of("page/goal"))

    def stands_within(self, seconds, begun):
        """From `begun` on, and stays."""
        time.sleep(max(0.0, begun + seconds + 0.7 - time.time()))
        self.assertLess(self.way(begun + seconds), 0.005)

    def orders(self, since=0.0):
        return [page_bus.base_command(payload)["kind"] for at, name, payload in self.bus.heard
                if name == "BASE_COMMAND" and at >= since]

    def test_is_driven_by_orders_that_lapse_and_reached(self):
        status = self.bus.last["ODOMETRY"]
        x, y = struct.unpack(">2d", status[16:32])
        self.client.publish(1, {"header": {"frame_id": "odom"}, "pose": {"position": {"x": x + 0.4, "y": y}}})

        def is_over():
            self.client.text({"op": "alive"})
            return len(self.client.of("page/goal")) > 1 and not self.client.of("page/goal")[-1]["active"]
        self.assertTrue(self.client.wait(is_over, 15))
        self.assertEqual(self.client.of("page/goal")[-1]["text"], "there")
        self.assertTrue(eventually(lambda: set(self.orders()) == {KIND_VELOCITY, KIND_STOP}, 1), self.orders())
        self.rest()
        x2, y2 = struct.unpack(">2d", self.bus.wait("ODOMETRY")[16:32])
        self.assertLess(math.hypot(x2 - x - 0.4, y2 - y), 0.06)

    def test_ends_with_its_browser(self):
        for ends, alive in ((self.client.close, True), (lambda: None, True), (lambda: None, False)):
            self.go(alive=alive)  # of the last one only pongs came, as of Foxglove's app
            begun = time.time()
            ends()  # or is silent from here on, and answers no ping
            self.stands_within(1.0, begun)
            self.assertEqual(self.orders(begun)[-1], KIND_STOP)
            self.assertNotIn(KIND_GO_TO, self.orders())
            self.assertEqual(self.orders(begun + 1.3), [])
            self.client.close()
            self.client = Client(8765)
            self.client.subscribe("page/goal")
            self.client.advertise(1, "/goal_pose")
            self.rest()

    def test_ends_with_its_page(self):
        self.go()
        self.page.process.send_signal(signal.SIGSTOP)
        begun = time.time()
        self.stands_within(1.0, begun)
        self.page.process.send_signal(signal.SIGCONT)
        woken = time.time()
        for _ in range(10):
            self.client.text({"op": "alive"})
            self.client.wait(lambda: False, 0.1)
        self.assertLess(self.way(woken), 0.005)
        self.assertNotIn(KIND_VELOCITY, self.orders(woken))
        self.assertFalse(self.client.of("page/goal")[-1]["active"])
        self.go()
        self.page.process.kill()
        self.stands_within(1.0, time.time())

    def test_ends_with_a_stop_and_with_a_hand(self):
        self.go()
        begun = time.time()
        self.assertTrue(self.client.call("stop", {"engaged": True})["ok"])
        self.stands_within(1.0, begun)
        self.assertTrue(self.client.call("stop", {"engaged": False})["ok"])
        self.client.wait(lambda: False, 0.5)
        self.assertLess(self.way(begun + 1.0), 0.005)  # it is not taken up again
        self.go()
        other = Client(8765)
        other.advertise(1, "/cmd_vel")
        other.publish(1, {"linear": {"x": 0.0}, "angular": {"z": 0.2}})
        self.assertTrue(self.client.wait(lambda: not self.client.of("page/goal")[-1]["active"], 2))
        self.assertIn("driving manually", self.client.of("page/goal")[-1]["text"])
        other.close()


if __name__ == "__main__":
    if not os.path.exists(os.path.join(BIN, "marco-sim")):
        print("SKIPPED: built without the simulator")
        sys.exit(0)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], warnings="ignore")
