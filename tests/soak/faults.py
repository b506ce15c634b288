"""Faults while mapping live: a simulated robot, its drivers, SLAM, the 3D mapper and a logger under procman; each fault
in turn while a tour is driven. Prints a table: is every process alive or restarted, how far is the map from that of the
undisturbed run, where does SLAM say the robot is, what was said. Run by `./marco soak --faults [NAME...]` in a network
namespace of its own."""
import argparse
import math
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from lcm_wire import GROUP, Ear, Relay, datagrams, flood, sender  # noqa: E402

PORT, FAR_PORT = 7667, 7668
START = (2.0, 3.0, 0.0)
TOUR = """start_m = [2.0, 3.0]
[[steps]]
kind = "sweep"  # it ends level, as SLAM needs it
tilt_from_deg = -4
tilt_to_deg = 4
rows = 10
[[steps]]
to_m = [5.6, 2.2]
[[steps]]
to_m = [9.6, 2.6]
[[steps]]
to_m = [12.4, 4.0]
[[steps]]
to_m = [10.6, 6.6]
[[steps]]
to_m = [5.4, 6.6]
[[steps]]
kind = "wait"
seconds = 6.0
"""
SCRIPT = """
cmd "simulator" { exec = "marco-sim --config $ROOT/config/robots/michoacan.toml --world $ROOT/config/worlds/lab.toml --tour $RUN/tour.toml --ports $RUN/ports"; deputy = "localhost"; auto_respawn = "true"; }
cmd "base" { exec = "marco-base --config $ROOT/config/robots/michoacan/base.toml --device $RUN/ports/base"; deputy = "localhost"; auto_respawn = "true"; }
cmd "pantilt" { exec = "marco-pantilt --config $ROOT/config/robots/michoacan/pantilt.toml --device $RUN/ports/pantilt"; deputy = "localhost"; auto_respawn = "true"; }
cmd "laser" { exec = "marco-sick --config $ROOT/config/robots/michoacan/sick.toml --device $RUN/ports/laser"; deputy = "localhost"; auto_respawn = "true"; }
cmd "slam" { exec = "SLAM_EXEC"; deputy = "localhost"; auto_respawn = "true"; environment = "LCM_DEFAULT_URL=FAR_URL"; }
cmd "mapping3d" { exec = "marco-mapping3d --out $RUN/model.ply"; deputy = "localhost"; auto_respawn = "true"; environment = "LCM_DEFAULT_URL=FAR_URL"; }
cmd "logger" { exec = "lcm-logger --increment --auto-split-hours=10 $RUN/rec/live.lcm"; deputy = "localhost"; auto_respawn = "true"; stop_signal = 2; environment = "LCM_DEFAULT_URL=FAR_URL"; }
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


class Stack:
    """The live stack of one case; everything it starts carries MARCO_RUN, by which it is found again."""

    def __init__(self, root, bin_folder, folder, relay=False, clock=False):
        self.root, self.bin, self.folder, self.children = root, bin_folder, folder, []
        os.makedirs(folder + "/rec")
        self.far_port = FAR_PORT if relay else PORT
        url = "udpm://%s:%d?ttl=0&recv_buf_size=2097152"
        self.env = dict(os.environ, MARCO_RUN=folder, PATH=bin_folder + ":" + os.environ["PATH"],
                        LCM_DEFAULT_URL=url % (GROUP, PORT), XDG_RUNTIME_DIR=folder + "/run",
                        XDG_STATE_HOME=folder + "/state")
        self.clock = folder + "/clock"
        if clock:
            self.set_clock(0)
            self.env.update(FAKETIME_TIMESTAMP_FILE=self.clock, FAKETIME_NO_CACHE="1", DONT_FAKE_MONOTONIC="1",
                            LD_PRELOAD="libfaketime.so.1", LD_LIBRARY_PATH="/usr/lib/x86_64-linux-gnu/faketime")
        with open(folder + "/tour.toml", "w") as file:
            file.write(TOUR)
        text = SCRIPT.replace("$ROOT", root).replace("$RUN", folder).replace("FAR_URL", url % (GROUP, self.far_port))
        with open(folder + "/live.procman", "w") as file:
            file.write(text.replace("SLAM_EXEC", slam_exec(bin_folder, folder)))
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
        self.spawn("deputy", self.bin + "/marco-procman-deputy", "-i", "localhost", "--script",
                   self.folder + "/live.procman")
        time.sleep(1.0)
        return self.sheriff("go") == 0

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
        with open(self.folder + "/deputy.log") as log:
            return len(re.findall(r"start '%s'" % command, log.read()))

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


def slam_exec(bin_folder, folder):
    """marco-slam, with a checkpoint where it knows one."""
    known = subprocess.run([bin_folder + "/marco-slam", "--print-config"], capture_output=True, text=True).stdout
    if "checkpoint_path" not in known:
        return "marco-slam"
    with open(folder + "/slam.toml", "w") as file:
        file.write(f'checkpoint_path = "{folder}/slam.checkpoint"\n')
        if "checkpoint_every_s" in known:
            file.write("checkpoint_every_s = 2.0\n")
    return f"marco-slam --config {folder}/slam.toml"


def wrong_type(stack):
    """pose2_t's bytes, as TRUE_POSE carries them, on LIDAR and ODOMETRY; and bytes of no type at all."""
    out = sender()
    for i in range(400):
        for channel in ("LIDAR", "ODOMETRY", "PANTILT_STATE", "SENSOR_INFO"):
            data = os.urandom(8) + struct.pack(">qddd", int(time.time() * 1e6), 1.0, 2.0, 3.0)
            if i % 2:
                data = os.urandom(60 + i)
            out.sendto(datagrams(channel, data, i)[0], (GROUP, stack.far_port))
        time.sleep(0.02)


def pause(program, seconds):
    def act(stack):
        stack.signal(program, signal.SIGSTOP)
        time.sleep(seconds)
        stack.signal(program, signal.SIGCONT)
    return act


def fault(device, kind, seconds):
    """sim_fault_t; its fingerprint is asked of the program that knows it."""
    def act(stack):
        def text(value):
            return struct.pack(">i", len(value) + 1) + value.encode() + b"\0"
        data = stack.fault_hash + struct.pack(">q", int(time.time() * 1e6)) + text(device) + text(kind) \
            + struct.pack(">dd", 0.0, seconds)
        sender().sendto(datagrams("SIM_FAULT", data, 1)[0], (GROUP, PORT))
    return act


def losing(loss, reordered):
    def act(stack):
        stack.relay.loss, stack.relay.reordered = loss, reordered
        time.sleep(10)
        stack.relay.loss = stack.relay.reordered = 0.0
    return act


def clock(seconds):
    def act(stack):
        stack.set_clock(seconds)
        time.sleep(6)
        stack.set_clock(0)
    return act


def full_disk(stack):
    """The logger's folder has 1 MB from the start; by now it is full."""
    usage = shutil.disk_usage(stack.folder + "/rec")
    stack.note = f"disk {100 * usage.used // usage.total} % full"


def second_slam(stack):
    env = dict(stack.env, LCM_DEFAULT_URL=stack.env["LCM_DEFAULT_URL"].replace(str(PORT), str(stack.far_port)))
    stack.spawn("second", stack.bin + "/marco-slam", env=env)


CASES = {"undisturbed": (None, {})}
for _name, _program in PROCESSES.items():
    if _name != "simulator":  # that would be the world's end, not a process's
        CASES["kill -9 " + _name] = (lambda stack, p=_program: stack.signal(p, signal.SIGKILL), {})
CASES.update({
    "stop 5 s slam": (pause("marco-slam", 5), {}),
    "stop 5 s laser": (pause("marco-sick", 5), {}),
    "stop 5 s base": (pause("marco-base", 5), {}),
    "stop 5 s logger": (pause("lcm-logger", 5), {}),
    "loss 10 %": (losing(0.1, 0.05), {"relay": True}),
    "loss 50 %": (losing(0.5, 0.05), {"relay": True}),
    "laser unplugged": (fault("laser", "unplugged", 5.0), {}),
    "laser garbage": (fault("laser", "garbage", 5.0), {}),
    "laser off": (fault("laser", "off", 5.0), {}),
    "base off": (fault("base", "off", 3.0), {}),
    "wrong type": (wrong_type, {}),
    "flood 1 MB": (lambda stack: flood(stack.far_port, "LIDAR", os.urandom(1 << 20), 20, 8), {}),
    "two SLAMs": (second_slam, {}),
    "disk full": (full_disk, {"disk_mb": 1}),
    "clock +1 h": (clock(3600), {"clock": True}),
    "clock -1 h": (clock(-3600), {"clock": True}),
})


def slam_error_m(ear):
    if "TRUE_POSE" not in ear.poses or "SLAM_POSE" not in ear.poses:
        return math.nan
    _, x, y, _ = ear.poses["SLAM_POSE"]
    _, true_x, true_y, _ = ear.poses["TRUE_POSE"]
    c, s = math.cos(START[2]), math.sin(START[2])
    return math.hypot(START[0] + c * x - s * y - true_x, START[1] + s * x + c * y - true_y)


def recordings(folder):
    files = [os.path.join(folder, "rec", name) for name in os.listdir(folder + "/rec")]
    return sorted(files, key=os.path.getmtime)


def compare(bin_folder, reference, folder):
    """The map of the last recording that has one, against the reference's."""
    for path in reversed(recordings(folder)):
        answer = subprocess.run([bin_folder + "/map_difference", reference, path], capture_output=True, text=True)
        if answer.returncode == 0:
            return answer.stdout.strip()
    return "no map"


def run_case(name, arguments, reference):
    act, options = CASES[name]
    folder = tempfile.mkdtemp(prefix="marco_faults_")
    if "disk_mb" in options:
        os.makedirs(folder + "/disk")
    stack = Stack(arguments.root, arguments.bin, folder, options.get("relay", False), options.get("clock", False))
    stack.fault_hash, stack.note = arguments.fault_hash, ""
    if "disk_mb" in options:
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={options['disk_mb']}m", "tmpfs", folder + "/rec"], check=True)
    result = {"name": name, "folder": folder}
    try:
        if not stack.start():
            return dict(result, verdict="the stack did not start, see " + folder)
        before = {command: stack.starts(command) for command in PROCESSES}
        tour = stack.spawn("tour", arguments.bin + "/marco-tour", folder + "/tour.toml", "--pose", "true")
        time.sleep(15.0)
        if act:
            act(stack)
        tour_code = None
        try:
            tour_code = tour.wait(150)
        except subprocess.TimeoutExpired:
            pass
        time.sleep(6.0)
        result["error_m"] = slam_error_m(stack.ear)
        result["missing"] = [command for command, program in PROCESSES.items() if not stack.pids(program)]
        result["restarts"] = {command: stack.starts(command) - before[command] for command in PROCESSES
                              if stack.starts(command) != before[command]}
        result["said"] = {process: [state for state in states
                                    if re.search("no device|no answer|stuck|silent|looking|garbage|fault|search", state)][:2]
                          for process, states in stack.ear.states.items()}
        result["drops"] = {process: causes for process, causes in stack.ear.drops.items() if causes}
        result["note"], result["tour"] = stack.note, tour_code
    finally:
        stack.stop()
    whole = sum(os.path.getsize(path) for path in recordings(folder))
    events = 0
    for path in recordings(folder):
        answer = subprocess.run([arguments.bin + "/marco-log", "info", "--json", path], capture_output=True, text=True)
        found = re.search(r'"events": *([0-9]+)', answer.stdout)
        events += int(found.group(1)) if found else 0
    result["log"] = f"{events} events in {whole / 1e6:.1f} MB"
    if reference:
        result["map"] = compare(arguments.bin, reference, folder)
    if "disk_mb" in options:
        subprocess.run(["umount", "-l", folder + "/rec"], check=False)
    return result


def print_result(result):
    if "verdict" in result:
        print(f"{result['name']:18} {result['verdict']}")
        return False
    near = re.search(r"p95 ([0-9.]+)", result.get("map", ""))
    good = not result["missing"] and (not near or float(near.group(1)) <= 0.05) and result["error_m"] < 0.05 \
        and result.get("map") != "no map"
    print(f"{result['name']:18} {'good' if good else 'BAD ':4}  missing {','.join(result['missing']) or '-':10} "
          f"restarted {result['restarts'] or '-'}  SLAM off by {result['error_m']:.3f} m  map: {result.get('map', 'the reference')}  "
          f"log: {result['log']}  {result['note']}")
    said = {process: states for process, states in result["said"].items() if states}
    print(f"{'':18}       said: {said or '-'}; drops: {result['drops'] or '-'}", flush=True)
    return good


def main():
    parser = argparse.ArgumentParser(prog="marco soak --faults")
    parser.add_argument("root")
    parser.add_argument("--faults", action="store_true", help="this")
    parser.add_argument("--bin")
    parser.add_argument("names", nargs="*", help="; ".join(CASES))
    arguments = parser.parse_intermixed_args()
    arguments.bin = arguments.bin or arguments.root + "/build/release/bin"
    answer = subprocess.run([arguments.bin + "/map_difference", "--fault-fingerprint"], capture_output=True, text=True)
    arguments.fault_hash = struct.pack(">Q", int(answer.stdout, 16))
    for name in arguments.names:
        if name not in CASES:
            parser.error(f"there is no fault '{name}'; there are: {'; '.join(CASES)}")
    names = [name for name in (arguments.names or CASES) if name != "undisturbed"]
    first = run_case("undisturbed", arguments, None)
    good = print_result(first)
    reference = recordings(first["folder"])[-1]
    for name in names:
        result = run_case(name, arguments, reference)
        good = print_result(result) and good
        shutil.rmtree(result["folder"], ignore_errors=True)
    shutil.rmtree(first["folder"], ignore_errors=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
