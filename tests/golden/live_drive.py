#!/usr/bin/env python3
"""A simulated robot drives a tour of the lab in real time, and what its processes say is recorded. In a network of its own
(isolated.sh).

usage: live_drive.py FOLDER_OF_PROGRAMS ROBOT OUT     ROBOT: a name in ROBOTS; OUT/live.lcm is the recording
"""
import json
import os
import shutil
import signal
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PATIENCE_S = 60.0
WAYS = "".join(f"[[steps]]\nto_m = [{to}]\n" for to in ("5.0, 2.4", "5.6, 4.4", "3.0, 4.6", "2.0, 3.0"))
SWEEP = '[[steps]]\nkind = "sweep"\nrows = 60\n'
# Drivers with their ports, channels without which nothing drives, and the tour's steps.
ROBOTS = {
    "michoacan": ({"base": ("marco-base", "base"), "pantilt": ("marco-pantilt", "pantilt"), "sick": ("marco-sick", "laser")},
                  ("ODOMETRY", "PANTILT_STATE", "LIDAR", "SLAM_POSE"), SWEEP + WAYS),
    "create": ({"create": ("marco-create", "base"), "ldlidar": ("marco-ldlidar", "laser")},
               ("ODOMETRY", "LIDAR", "SLAM_POSE"), WAYS),
}


class NotDriven(Exception):
    """Why."""


class Drive:
    def __init__(self, programs, out):
        self.programs, self.out, self.started = programs, out, []
        os.makedirs(out, exist_ok=True)

    def start(self, program, *arguments):
        path = shutil.which(program, path=f"{self.programs}:{os.environ['PATH']}")
        with open(f"{self.out}/{os.path.basename(program)}.log", "w", encoding="utf-8") as log:
            self.started.append(subprocess.Popen([path, *arguments], stdout=log, stderr=subprocess.STDOUT, cwd=ROOT))

    def end(self):
        """The last one started first: the recorder, which began first, hears everybody's last word."""
        while self.started:
            process = self.started.pop()
            process.send_signal(signal.SIGINT)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def channels(self):
        said = subprocess.run([f"{self.programs}/marco-spy", "--once", "--json", "--duration", "1"], capture_output=True,
                              text=True, check=False).stdout
        return {channel["channel"] for channel in json.loads(said)["channels"]} if said else set()


def await_true(what, condition):
    until = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > until:
            raise NotDriven(f"{what} never came")
        time.sleep(0.2)


def drive(run, robot):
    drivers, wanted, steps = ROBOTS[robot]
    tour, folder = f"{run.out}/tour.toml", f"{ROOT}/config/robots/{robot}"
    with open(tour, "w", encoding="utf-8") as file:
        file.write("start_m = [2.0, 3.0]\n" + steps)
    run.start("lcm-logger", "--force", f"{run.out}/live.lcm")
    run.start("marco-slam", "--config", f"{ROOT}/config/slam_live.toml")
    run.start("marco-sim", "--config", f"{folder}.toml", "--world", f"{ROOT}/config/worlds/lab.toml", "--tour", tour,
              "--seed", "1", "--ports", f"{run.out}/ports")
    for config, (program, port) in drivers.items():
        await_true(f"the port {port}", lambda port=port: os.path.exists(f"{run.out}/ports/{port}"))
        run.start(program, "--config", f"{folder}/{config}.toml", "--device", f"{run.out}/ports/{port}")
    await_true(f"one of {', '.join(wanted)}", lambda: set(wanted) <= run.channels())
    tour = subprocess.run([f"{run.programs}/marco-tour", tour, "--pose", "slam"], check=False, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if tour.returncode != 0:
        raise NotDriven(f"the tour ended early: {tour.stdout.strip()}")


def main():
    if len(sys.argv) != 4 or sys.argv[2] not in ROBOTS:
        sys.exit(__doc__)
    if not shutil.which("lcm-logger"):
        print("SKIPPED: lcm-logger is not installed")
        return 77
    run = Drive(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[3]))
    try:
        drive(run, sys.argv[2])
    except NotDriven as why:
        print(why, file=sys.stderr)
        return 1
    finally:
        run.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
