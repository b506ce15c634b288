"""How many scans a second live SLAM takes: the drive of a robot with a laser of 375 scans a second is played faster and
faster into marco-slam, until messages are given up (the oldest, counted on PROCESS_STATUS). The laser is fast, not the
robot: what is lost for a third of a second is seconds of its drive, not a lap. Prints a line for each speed: scans
offered a second, given up, poses, and how far the map is from that of the slowest run. Run by `./marco soak --load` in a
network of its own."""
import argparse
import bisect
import math
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from lcm_wire import Ear, events_of  # noqa: E402
from live_stack import HOME, WAY, legs  # noqa: E402

PORT = 7667
ROUNDS = 3  # so that it is overtaxed for long, not for as much as its queues hold
FAST_LASER = "[laser]\nscans_per_s = 375.0\nscan_duration_s = 0.002667\n"
TAIL = 8  # scans of one odometry period: the last ones wait for a next that never comes
LOST = "arrived too fast: the oldest of "


def play(arguments, folder, log, speed):
    """@returns seconds it took, what SLAM said last of its drops, poses, and the log of its map."""
    ear = Ear(PORT)
    recorded = f"{folder}/map_{speed:g}.lcm"
    recorder = subprocess.Popen(["lcm-logger", "-q", "-c", "GRID_MAP|SLAM_POSE", recorded])
    with open(folder + "/slam.log", "a") as said:
        slam = subprocess.Popen([arguments.bin + "/marco-slam"], stderr=said)
    time.sleep(3.0)
    start = time.time()
    subprocess.run(["lcm-logplayer", f"--speed={speed:g}", log], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    took = time.time() - start
    poses = -1
    while poses != ear.counts.get("SLAM_POSE", 0):  # until it has caught up
        poses = ear.counts.get("SLAM_POSE", 0)
        time.sleep(2.5)
    drops = dict(ear.drops.get("marco-slam", {}))
    slam.send_signal(signal.SIGINT)
    slam.wait(60)
    time.sleep(0.5)
    recorder.send_signal(signal.SIGINT)
    recorder.wait(10)
    ear.ended = True
    return took, drops, poses, recorded


def poses_of(path, channel):
    return [struct.unpack(">qddd", data[8:40]) for name, data in events_of(path) if name == channel]


def worst_error_m(truth, recorded):
    """Of the poses that were sent, against the truth at their time; the first scan's robot is SLAM's origin."""
    worst, times = 0.0, [pose[0] for pose in truth]
    x0, y0, heading = truth[0][1:]
    c, s = math.cos(heading), math.sin(heading)
    for utime, x, y, _ in poses_of(recorded, "SLAM_POSE"):
        at = min(bisect.bisect_left(times, utime), len(times) - 1)
        worst = max(worst, math.hypot(x0 + c * x - s * y - truth[at][1], y0 + s * x + c * y - truth[at][2]))
    return worst


def main():
    parser = argparse.ArgumentParser(prog="marco soak --load")
    parser.add_argument("root")
    parser.add_argument("--load", action="store_true", help="this")
    parser.add_argument("--bin")
    parser.add_argument("--speeds", type=float, nargs="+", default=[1, 2, 4, 6, 8, 12, 16])
    arguments = parser.parse_args()
    arguments.bin = arguments.bin or arguments.root + "/build/release/bin"
    os.environ["LCM_DEFAULT_URL"] = "udpm://239.255.76.67:%d?ttl=0&recv_buf_size=2097152" % PORT
    folder = tempfile.mkdtemp(prefix="marco_load_")
    log = folder + "/drive.lcm"
    with open(folder + "/tour.toml", "w") as tour:
        tour.write("start_m = [2.0, 3.0]\n" + ROUNDS * legs(WAY + HOME, 1.0))
    with open(folder + "/laser.toml", "w") as laser:
        laser.write(FAST_LASER)
    subprocess.run([arguments.bin + "/marco-simulate", "--config", folder + "/laser.toml", "--world",
                    arguments.root + "/config/worlds/lab.toml", "--tour", folder + "/tour.toml", "--seed", "1",
                    "--out", log], check=True, stdout=subprocess.DEVNULL)
    channels = [channel for channel, _ in events_of(log)]
    scans = channels.count("LIDAR")
    truth = poses_of(log, "TRUE_POSE")
    print(f"{scans} scans, {len(channels)} messages; each line is one drive")
    print(f"{'speed':>6} {'scans/s':>8} {'seconds':>8} {'poses':>6} {'given up':>9} {'worst m':>8}  map against the first line's")
    reference, good, taken = None, True, 0.0
    for speed in arguments.speeds:
        took, drops, poses, recorded = play(arguments, folder, log, speed)
        lost = {cause[len(LOST):]: count for cause, count in drops.items() if cause.startswith(LOST)}
        reference = reference or recorded
        answer = subprocess.run([arguments.bin + "/map_difference", reference, recorded], capture_output=True, text=True)
        near = re.search(r"alone p95 ([0-9.]+)", answer.stdout)
        rate = scans / took
        print(f"{speed:6g} {rate:8.0f} {took:8.1f} {poses:6d} {sum(lost.values()):9d} {worst_error_m(truth, recorded):8.3f}  "
              f"{answer.stdout.strip()}  {lost or ''}", flush=True)
        # Every scan has a pose, or was counted as given up.
        kept = poses + lost.get("LIDAR", 0) >= scans - TAIL
        good = good and kept and near is not None and float(near.group(1)) <= 0.0501
        if not lost and poses >= scans - TAIL:
            taken = max(taken, rate)
    print(f"takes {taken:.0f} scans a second without giving up any; "
          f"{'the map stays and every scan is accounted for' if good else 'NOT all is well'}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
