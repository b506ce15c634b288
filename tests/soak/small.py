"""What a small computer has to do: a base, an RPLIDAR at 10 Hz, SLAM, a recorder and one page client in a control group
with a quarter of one core and 512 MB, while the robot drives round an office outside of it. Nothing may be dropped. With
less CPU time (--share 0.25 0.06 0.03) the page's messages have to be given up before scans and poses. Run as root by
`./marco soak --small`, in a network of its own. The share is compared with a Raspberry Pi 4 by 7-zip's own benchmark, where 7zz is installed."""
import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "process", "web"))
from lcm_wire import events_of  # noqa: E402
from live_stack import LiveStack, legs  # noqa: E402
from page_client import Client, Refused  # noqa: E402

# One thread of `7z b` on a Raspberry Pi 4 B at 1.8 GHz under a 64-bit system: sbc-bench's results (ix.io/3OBF).
PI_4_MIPS = 1769.0
PAGE_PORT = 8765
START = (1.2, 7.0, 0.0)
ROUND = ((4, 7), (4, 3.3), (4, 7), (11.5, 7), (11.5, 3.3), (11.5, 7), (20.5, 7), (20.5, 3.3), (20.5, 7), (28, 7),
         (30.9, 7), (30.9, 13), (25.5, 13), (25.5, 16.7), (25.5, 13), (18.5, 13), (1.2, 13), (1.2, 7))
ROBOT = """base = "text"
wheel_diameter_m = 0.065
track_m = 0.16
[body]
front_m = 0.12
back_m = 0.12
half_width_m = 0.10
height_m = 0.20
[[lasers]]
port = "laser"
device = "rplidar_a2"
position_m = [0.0, 0.0, 0.18]
"""
COMMAND = 'cmd "%s" { exec = "%s"; deputy = "localhost"; auto_respawn = "true"; stop_signal = %d; }\n'
COMMANDS = {
    "base": "marco-textbase --config $ROOT/config/robots/homemade/textbase.toml --device $RUN/ports/base",
    "laser": "marco-rplidar --config $ROOT/config/robots/homemade/rplidar.toml --device $RUN/ports/laser",
    "slam": "marco-slam --config $ROOT/config/slam_live.toml --checkpoint $RUN/slam.checkpoint",
    "page": "marco-page --listen 127.0.0.1:%d" % PAGE_PORT,
    "logger": "marco-recorder $RUN/rec"}
SCRIPT = """script "go" {
  start cmd "page";
  start cmd "slam" wait "running";
  start cmd "logger" wait "running";
  start cmd "base" wait publishing "ODOMETRY" timeout ms 60000 then abort;
  start cmd "laser" wait publishing "LIDAR" timeout ms 60000 then abort;
}
script "halt" { stop everything wait "stopped" timeout ms 60000 then continue; }
"""


class ControlGroup:
    """CPU time and memory of what is started in it; either version of Linux' control groups."""

    def __init__(self, share, memory_mb):
        self.unified = os.path.exists("/sys/fs/cgroup/cgroup.controllers")
        name = "marco_small_%d" % os.getpid()
        roots = {"": "/sys/fs/cgroup"} if self.unified else {
            "cpu": "/sys/fs/cgroup/cpu", "cpuacct": "/sys/fs/cgroup/cpuacct", "memory": "/sys/fs/cgroup/memory"}
        self.folders = {kind: f"{root}/{name}" for kind, root in roots.items()}
        for folder in set(map(os.path.realpath, self.folders.values())):
            os.makedirs(folder)
        period_us = 100000
        if self.unified:
            self.write("", "cpu.max", f"{int(share * period_us)} {period_us}")
            self.write("", "cpu.weight", 10000)  # what else runs here leaves it its share
            self.write("", "memory.max", memory_mb << 20)
        else:
            self.write("cpu", "cpu.cfs_period_us", period_us)
            self.write("cpu", "cpu.cfs_quota_us", int(share * period_us))
            self.write("cpu", "cpu.shares", 262144)
            self.write("memory", "memory.limit_in_bytes", memory_mb << 20)

    def write(self, kind, name, value):
        with open(f"{self.folders[kind]}/{name}", "w") as file:
            file.write(str(value))

    def read(self, kind, name):
        with open(f"{self.folders['' if self.unified else kind]}/{name}") as file:
            return file.read()

    def enter(self):
        for folder in self.folders.values():
            with open(folder + "/cgroup.procs", "w") as file:
                file.write(str(os.getpid()))

    def cpu_s(self):
        if self.unified:
            return int(re.search(r"usage_usec (\d+)", self.read("", "cpu.stat")).group(1)) * 1e-6
        return int(self.read("cpuacct", "cpuacct.usage")) * 1e-9

    def throttled(self):
        """Part of the periods in which it had used up its share."""
        stat = dict(line.split()[:2] for line in self.read("cpu", "cpu.stat").splitlines())
        return int(stat["nr_throttled"]) / max(1, int(stat["nr_periods"]))

    def peak_mb(self):
        name = "memory.peak" if self.unified else "memory.max_usage_in_bytes"
        return int(self.read("memory", name)) / 2**20

    def anonymous_mb(self):
        """Without the files that the kernel keeps for as long as nobody needs the memory."""
        stat = dict(line.split() for line in self.read("memory", "memory.stat").splitlines())
        return int(stat["anon" if self.unified else "rss"]) / 2**20

    def remove(self):
        for folder in set(map(os.path.realpath, self.folders.values())):
            os.rmdir(folder)


class SmallStack(LiveStack):
    """What the small computer runs; the simulator and whoever drives are elsewhere."""

    def __init__(self, root, bin_folder, folder, group):
        self.group = group
        super().__init__(root, bin_folder, folder)
        with open(folder + "/robot.toml", "w") as robot:
            robot.write(ROBOT)
        text = "".join(COMMAND % (name, line, 2) for name, line in COMMANDS.items()) + SCRIPT
        with open(folder + "/live.procman", "w") as script:
            script.write(text.replace("$ROOT", root).replace("$RUN", folder))
        with open(folder + "/round.toml", "w") as tour:
            tour.write(f"start_m = [{START[0]}, {START[1]}]\n" + legs(ROUND, 1.0))

    def deputy(self):
        with open(f"{self.folder}/deputy.log", "a") as log:
            self.children.append(subprocess.Popen(
                [self.bin + "/marco-procman-deputy", "-i", "localhost", "--script", self.folder + "/live.procman"],
                stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=self.env, preexec_fn=self.group.enter))

    def simulator(self):
        self.spawn("simulator", self.bin + "/marco-sim", "--config", self.folder + "/robot.toml", "--world",
                   self.root + "/config/worlds/office.toml", "--tour", self.folder + "/round.toml", "--ports",
                   self.folder + "/ports")
        for _ in range(100):
            if os.path.exists(self.folder + "/ports/laser"):
                return
            time.sleep(0.1)
        raise RuntimeError("no simulated devices after 10 s")

    def go_on(self):
        return self.spawn("tour", self.bin + "/marco-tour", self.folder + "/round.toml", "--pose", "true")


class Viewer(threading.Thread):
    """One client of the page, that takes all there is."""

    def __init__(self):
        super().__init__(daemon=True)
        self.messages, self.lost, self.ended = 0, 0, False
        self.start()

    def run(self):
        while not self.ended:
            try:
                client = Client(PAGE_PORT)
                while not self.ended and client.step(0.5):
                    new = set(client.channels) - set(client.topic_of.values())
                    if new:
                        client.subscribe(*new)
                    self.messages += len(client.messages)
                    client.messages.clear()
            except (OSError, Refused, IndexError):
                pass
            if not self.ended:
                self.lost += 1
                time.sleep(1.0)


def mips():
    """7-zip's rating of one thread here; 0 without 7-zip."""
    if shutil.which("7zz") is None:
        return 0.0
    answer = subprocess.run(["7zz", "b", "-mmt1"], capture_output=True, text=True)
    found = re.search(r"^Tot:.*?(\d+)\s*$", answer.stdout, re.MULTILINE)
    return float(found.group(1)) if found else 0.0


def measured(arguments, share, rating):
    """Runs the stack. @returns whether nothing was dropped, whether SLAM and the drivers kept all, and what the page's client got a
    second."""
    folder = tempfile.mkdtemp(prefix="marco_small_")
    group = ControlGroup(share, arguments.memory)
    try:
        stack = SmallStack(arguments.root, arguments.bin, folder, group)
        stack.simulator()
        started = stack.start()
        viewer = Viewer()
        stack.driven = stack.go_on()
        ear, begun, cpu_s = stack.ear, time.time(), group.cpu_s()
        before, worst_m, worst_mb = dict(ear.counts), 0.0, 0.0
        while started and time.time() < begun + arguments.seconds:
            stack.keep_driving()
            time.sleep(2.0)
            worst_mb = max(worst_mb, group.anonymous_mb())
            error_m = stack.slam_error_m(START)
            worst_m = max(worst_m, error_m if error_m == error_m else 0.0)
        took, cpu_s = time.time() - begun, group.cpu_s() - cpu_s
        heard = {channel: ear.counts.get(channel, 0) - before.get(channel, 0)
                 for channel in ("LIDAR", "ODOMETRY", "SLAM_POSE")}
        throttled, viewed = group.throttled(), viewer.messages
        viewer.ended = True
        drops = {process: {cause: count for cause, count in causes.items() if count} for process, causes in ear.drops.items()}
        drops = {process: causes for process, causes in drops.items() if causes}
        restarts = {name: stack.starts(name) for name in COMMANDS if stack.starts(name) > 1}
        if stack.driven.poll() is None:
            stack.driven.send_signal(signal.SIGINT)
        stack.stop()
        recorded = {}
        for path in stack.recordings():
            for channel, _ in events_of(path):
                recorded[channel] = recorded.get(channel, 0) + 1
        total = {channel: ear.counts.get(channel, 0) for channel in heard}
        missing = {channel: total[channel] - recorded.get(channel, 0) for channel in ("LIDAR", "ODOMETRY", "SLAM_POSE")
                   if total[channel] > recorded.get(channel, 0)}
        print(f"{100 * share:.0f} % of one core"
              + (f" ({100 * share * rating / PI_4_MIPS:.0f} % of a Raspberry Pi 4's by 7-zip)" if rating else "")
              + f", {took:.0f} s: CPU {100 * cpu_s / took:.1f} % of a core, share used up in {100 * throttled:.1f} % of the periods, "
              f"{worst_mb:.0f} MB ({group.peak_mb():.0f} with cached files); scans {heard['LIDAR'] / took:.2f} a second, "
              f"odometry {heard['ODOMETRY'] / took:.1f}, poses {heard['SLAM_POSE'] / took:.2f}, "
              f"page {viewed / took:.1f} messages; SLAM within {worst_m:.3f} m; dropped {drops or 'nothing'}; "
              f"not recorded {missing or 'nothing'}; page lost {viewer.lost} times; restarted {restarts or 'nothing'}", flush=True)
        kept = (started and heard["SLAM_POSE"] >= heard["LIDAR"] - 8 and heard["LIDAR"] >= 0.95 * 10.0 * took and not drops and
                not restarts)
        return kept and not missing and viewer.lost == 0 and worst_m < 0.1, kept, viewed / took
    finally:
        time.sleep(1.0)
        group.remove()
        if not arguments.keep:
            shutil.rmtree(folder, ignore_errors=True)
        else:
            print("kept:", folder)


def main():
    parser = argparse.ArgumentParser(prog="marco soak --small")
    parser.add_argument("root")
    parser.add_argument("--small", action="store_true", help="this")
    parser.add_argument("--bin")
    parser.add_argument("--share", type=float, nargs="+", default=[0.25], help="of one core; the first must drop nothing")
    parser.add_argument("--memory", type=int, default=512, help="MB")
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--no-rate", dest="rate", action="store_false", help="without 7-zip's benchmark")
    parser.add_argument("--keep", action="store_true", help="the folders of the runs")
    arguments = parser.parse_args()
    arguments.bin = arguments.bin or arguments.root + "/build/release/bin"
    if os.geteuid() != 0:
        sys.exit("marco soak --small: control groups need root")
    rating = mips() if arguments.rate else 0.0
    if rating:
        print(f"7-zip, one thread: {rating:.0f} MIPS, Raspberry Pi 4 {PI_4_MIPS:.0f}", flush=True)
    runs = [measured(arguments, share, rating) for share in arguments.share]
    good, _, page_per_s = runs[0]
    print("nothing dropped with the first share" if good else "NOT all is well")
    # What is watched is given up before what is measured and mapped.
    for share, (_, kept, per_s) in zip(arguments.share[1:], runs[1:]):
        if not kept and per_s > 0.9 * page_per_s:
            print(f"NOT all is well: {100 * share:.0f} % drop scans before the page's messages")
            good = False
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
