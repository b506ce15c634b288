"""The live stack of the fault runs: simulator, drivers, SLAM, the 3D mapper and a logger under procman, in a folder and
on ports of its own; what is heard of it and found in its files."""
import math
import os
import re
import shutil
import signal
import subprocess
import time

from lcm_wire import GROUP, Ear, Relay

PORT, FAR_PORT = 7667, 7668
START = (2.0, 3.0, 0.0)
# It ends level, as SLAM needs it. Left out when a tour is begun again after the base was lost.
SWEEP = """[[steps]]
kind = "sweep"
tilt_from_deg = -4
tilt_to_deg = 4
rows = 10
"""
# Round the lab's tables; the last three lead home, to begin again.
WAY = ((5.6, 2.2), (9.6, 2.6), (12.4, 4.0), (10.6, 6.6), (5.4, 6.6))
HOME = ((3.0, 6.0), (2.6, 4.6), START[:2])


def legs(points, wait_s=6.0):
    return "".join(f"[[steps]]\nto_m = [{x}, {y}]\n" for x, y in points) \
        + f'[[steps]]\nkind = "wait"\nseconds = {wait_s}\n'


def rest_of_way(at, backwards):
    """The points of WAY that are left for who stands at `at`, between two of them or on the way home; the one before
    first when the way on is barred."""
    ring = WAY + HOME

    def distance(i):
        (x1, y1), (x2, y2) = ring[i - 1], ring[i]
        dx, dy = x2 - x1, y2 - y1
        along = max(0.0, min(1.0, ((at[0] - x1) * dx + (at[1] - y1) * dy) / (dx * dx + dy * dy)))
        return math.hypot(at[0] - x1 - along * dx, at[1] - y1 - along * dy)

    nearest = min(range(len(ring)), key=distance)
    first = ring[nearest - 1:nearest] if backwards and nearest else ring[-1:] if backwards else ()
    # On the last leg as well: a whole round, so that it is driven.
    return first + (ring[nearest:] + WAY if nearest >= len(WAY) else ring[nearest:len(WAY)])


SCRIPT = """
cmd "simulator" { exec = "marco-sim --config $ROOT/config/robots/michoacan.toml --world $ROOT/config/worlds/lab.toml --tour $RUN/tour.toml --ports $RUN/ports"; deputy = "localhost"; auto_respawn = "true"; environment = "LD_PRELOAD="; }
cmd "base" { exec = "marco-base --config $ROOT/config/robots/michoacan/base.toml --device $RUN/ports/base"; deputy = "localhost"; auto_respawn = "true"; }
cmd "pantilt" { exec = "marco-pantilt --config $ROOT/config/robots/michoacan/pantilt.toml --device $RUN/ports/pantilt"; deputy = "localhost"; auto_respawn = "true"; }
cmd "laser" { exec = "marco-sick --config $ROOT/config/robots/michoacan/sick.toml --device $RUN/ports/laser"; deputy = "localhost"; auto_respawn = "true"; }
cmd "slam" { exec = "marco-slam --config $RUN/slam.toml --checkpoint $RUN/slam.checkpoint"; deputy = "localhost"; auto_respawn = "true"; environment = "LCM_DEFAULT_URL=FAR_URL"; }
cmd "mapping3d" { exec = "marco-mapping3d --out $RUN/model.ply"; deputy = "localhost"; auto_respawn = "true"; environment = "LCM_DEFAULT_URL=FAR_URL"; }
cmd "logger" { exec = "marco-recorder $RUN/rec"; deputy = "localhost"; auto_respawn = "true"; stop_signal = 2; environment = "LCM_DEFAULT_URL=FAR_URL"; }
script "go" {
  start cmd "logger" wait "running";
  start cmd "slam" wait "running";
  start cmd "mapping3d" wait "running";
  start cmd "simulator" wait publishing "TRUE_POSE" timeout ms 20000 then abort;
  start cmd "base" wait publishing "ODOMETRY" timeout ms 30000 then abort;
  start cmd "pantilt" wait publishing "PANTILT_STATE" timeout ms 60000 then abort;
  start cmd "laser" wait publishing "LIDAR" timeout ms 60000 then abort;
}
script "halt" { stop everything wait "stopped" timeout ms 20000 then continue; }
"""
PROCESSES = {"simulator": "marco-sim", "base": "marco-base", "pantilt": "marco-pantilt", "laser": "marco-sick",
             "slam": "marco-slam", "mapping3d": "marco-mapping3d", "logger": "lcm-logger"}


class LiveStack:
    """The live stack of one case; everything it starts carries MARCO_RUN, by which it is found again."""

    def __init__(self, root, bin_folder, folder, relay=False, clock_s=None):
        self.root, self.bin, self.folder, self.children, self.driven = root, bin_folder, folder, [], None
        self.note, self.begun = "", 0
        os.makedirs(folder + "/rec")
        self.far_port = FAR_PORT if relay else PORT
        url = "udpm://%s:%d?ttl=0&recv_buf_size=2097152"
        self.env = dict(os.environ, MARCO_RUN=folder, PATH=bin_folder + ":" + os.environ["PATH"],
                        LCM_DEFAULT_URL=url % (GROUP, PORT), XDG_RUNTIME_DIR=folder + "/run",
                        XDG_STATE_HOME=folder + "/state")
        self.clock = folder + "/clock"
        if clock_s is not None:
            self.set_clock(clock_s)
            self.env.update(FAKETIME_TIMESTAMP_FILE=self.clock, FAKETIME_NO_CACHE="1", DONT_FAKE_MONOTONIC="1",
                            LD_PRELOAD="libfaketime.so.1", LD_LIBRARY_PATH="/usr/lib/x86_64-linux-gnu/faketime")
        self.write_tour("tour", SWEEP + legs(WAY))
        with open(folder + "/slam.toml", "w") as file:
            file.write("checkpoint_every_s = 2.0\n")
        text = SCRIPT.replace("$ROOT", root).replace("$RUN", folder).replace("FAR_URL", url % (GROUP, self.far_port))
        with open(folder + "/live.procman", "w") as file:
            file.write(text)
        self.ear = Ear(self.far_port)
        self.relay = Relay(PORT, FAR_PORT) if relay else None

    def spawn(self, name, *arguments, env=None):
        with open(f"{self.folder}/{name}.log", "a") as log:
            child = subprocess.Popen(arguments, stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=env or self.env)
        self.children.append(child)
        return child

    def sheriff(self, script):
        return self.spawn("sheriff", self.bin + "/marco-procman-sheriff", "-n", self.folder + "/live.procman", script,
                          "--on-script-complete", "exit").wait(120)

    def set_clock(self, seconds):
        with open(self.clock + ".new", "w") as file:
            file.write("%+d" % seconds)
        os.rename(self.clock + ".new", self.clock)

    def start(self):
        self.deputy()
        time.sleep(1.0)
        return self.sheriff("go") == 0

    def deputy(self):
        self.spawn("deputy", self.bin + "/marco-procman-deputy", "-i", "localhost", "--script",
                   self.folder + "/live.procman")

    def tour(self, name="tour"):
        # No device knows the host's clock, nor does who drives.
        env = {name: value for name, value in self.env.items() if name != "LD_PRELOAD"}
        return self.spawn("tour", self.bin + "/marco-tour", f"{self.folder}/{name}.toml", "--pose", "true", env=env)

    def write_tour(self, name, steps):
        with open(f"{self.folder}/{name}.toml", "w") as file:
            file.write("start_m = [2.0, 3.0]\n" + steps)

    def go_on(self):
        """What is left of the way from where the robot stands; back first, every second time that it is begun anew."""
        at = self.ear.poses.get("TRUE_POSE", (0,) + START)[1:3]
        self.begun += 1
        # Almost at the end: the whole round.
        left = rest_of_way(at, self.begun % 2 == 0)
        if math.dist(at, WAY[-1]) < 0.3:
            left = HOME + WAY
        self.write_tour("again", legs(left))
        return self.tour("again")

    def keep_driving(self):
        """Round and round: a tour that ended, well or not, is driven again."""
        if self.driven.poll() is not None:
            self.driven = self.go_on()

    def full(self):
        usage = shutil.disk_usage(self.folder + "/rec")
        return usage.free < usage.total / 10

    def drive(self, seconds):
        """A whole tour; begun again when it was given up because the base or its pose was lost."""
        end, tour, code = time.time() + seconds, self.driven, None
        while time.time() < end:
            code = tour.poll()
            if code == 0:
                break
            if code is not None:
                time.sleep(3.0)
                self.driven = tour = self.go_on()
            time.sleep(0.2)
        if tour.poll() is None:
            tour.terminate()
        self.driven = None
        return code

    def pids(self, program):
        found = []
        for entry in os.listdir("/proc"):
            if not entry.isdigit():
                continue
            try:
                with open(f"/proc/{entry}/environ", "rb") as file:
                    mine = ("MARCO_RUN=" + self.folder).encode() in file.read().split(b"\0")
                with open(f"/proc/{entry}/cmdline", "rb") as file:
                    line = file.read().split(b"\0")[0].decode()
                with open(f"/proc/{entry}/stat") as file:
                    alive = file.read().rsplit(")", 1)[1].split()[0] != "Z"
            except OSError:
                continue
            if mine and alive and os.path.basename(line) == program:
                found.append(int(entry))
        return found

    def signal(self, program, number):
        for pid in self.pids(program):
            os.kill(pid, number)

    def starts(self, command):
        return len(re.findall(r"start '%s'" % command, self.told()))

    def told(self):
        """What the deputy and the sheriff said."""
        text = ""
        for name in ("deputy", "sheriff"):
            with open(f"{self.folder}/{name}.log", errors="replace") as log:
                text += log.read()
        return text

    def outputs(self):
        """What the processes said, as procman kept it."""
        text = ""
        for folder, _, names in os.walk(self.folder + "/state"):
            for name in names:
                with open(os.path.join(folder, name), errors="replace") as log:
                    text += log.read()
        return text

    def second_said(self):
        """What a SLAM started beside ours said."""
        path = self.folder + "/second.log"
        if not os.path.exists(path):
            return ""
        with open(path, errors="replace") as log:
            return log.read()

    def recordings(self):
        files = [os.path.join(folder, name) for folder, _, names in os.walk(self.folder + "/rec")
                 for name in names if name.startswith("live.lcm.")]
        return sorted(files, key=os.path.getmtime)

    def slam_error_m(self, start=START):
        """How far SLAM is off, whose origin is where the robot started."""
        if "TRUE_POSE" not in self.ear.poses or "SLAM_POSE" not in self.ear.poses:
            return math.nan
        _, x, y, _ = self.ear.poses["SLAM_POSE"]
        _, true_x, true_y, _ = self.ear.poses["TRUE_POSE"]
        c, s = math.cos(start[2]), math.sin(start[2])
        return math.hypot(start[0] + c * x - s * y - true_x, start[1] + s * x + c * y - true_y)

    def stop(self):
        self.sheriff("halt")
        self.ear.ended = True
        if self.relay:
            self.relay.ended = True
        for child in self.children:
            if child.poll() is None:
                child.terminate()
        time.sleep(1.0)
        for child in self.children:
            if child.poll() is None:
                child.kill()
        for program in list(PROCESSES.values()) + ["marco-procman-keeper"]:
            self.signal(program, signal.SIGKILL)
