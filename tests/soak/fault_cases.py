"""The faults of `./marco soak --faults`: what is done to a LiveStack, and what must be said of it."""
import hashlib
import os
import random
import signal
import struct
import subprocess
import sys
import time
from dataclasses import dataclass, field
from typing import Callable

from lcm_wire import GROUP, datagrams, events_of, flood, sender
from live_stack import PORT, PROCESSES


@dataclass
class Case:
    act: Callable | None
    told: str | None = None  # regex: among what procman, PROCESS_STATUS and the logs said
    options: dict = field(default_factory=dict)  # of LiveStack


def kill(program):
    return lambda stack: stack.signal(program, signal.SIGKILL)


def pause(program, seconds=5):
    def act(stack):
        stack.signal(program, signal.SIGSTOP)
        time.sleep(seconds)
        stack.signal(program, signal.SIGCONT)
    return act


def kill_deputy(stack):
    """Its keepers keep the processes; a new deputy takes them over."""
    before = {command: stack.pids(program) for command, program in PROCESSES.items()}
    stack.signal("marco-procman-deputy", signal.SIGKILL)
    time.sleep(3)
    stack.deputy()
    time.sleep(2)
    same = before == {command: stack.pids(program) for command, program in PROCESSES.items()}
    stack.note = "all processes lived on" if same else "PROCESSES WERE LOST"


def fault(device, kind, seconds):
    def act(stack):
        send_fault(stack, device, kind, seconds)
        time.sleep(seconds)
    return act


def send_fault(stack, device, kind, seconds):
    """sim_fault_t; its fingerprint is asked of the program that knows it."""
    def text(value):
        return struct.pack(">i", len(value) + 1) + value.encode() + b"\0"

    data = stack.fault_hash + struct.pack(">q", int(time.time() * 1e6)) + text(device) + text(kind) \
        + struct.pack(">dd", 0.0, seconds)
    sender().sendto(datagrams("SIM_FAULT", data, 1)[0], (GROUP, PORT))


def brown_outs(stack):
    """The battery sags under a motor: devices lose their power for a moment, alone or together."""
    choice = random.Random(1)
    for _ in range(8):
        for device in choice.sample(("laser", "base", "pantilt"), choice.choice((1, 2, 3))):
            send_fault(stack, device, "off", choice.uniform(0.1, 1.5))
        time.sleep(choice.uniform(2, 8))


def busy_cpu(stack):
    """Three programs for each core that do nothing but count."""
    count = "import time\nend = time.time() + 20\nwhile time.time() < end: pass"
    busy = [subprocess.Popen([sys.executable, "-c", count]) for _ in range(3 * os.cpu_count())]
    for program in busy:
        program.wait()


def losing(loss, reordered, seconds=10):
    def act(stack):
        stack.relay.loss, stack.relay.reordered = loss, reordered
        time.sleep(seconds)
        stack.relay.loss = stack.relay.reordered = 0.0
    return act


def clock(seconds):
    def act(stack):
        stack.set_clock(seconds)
        time.sleep(6)
        stack.set_clock(0)
    return act


def wrong_type(stack):
    """pose2_t's bytes, as TRUE_POSE carries them, on the sensors' channels; and bytes of no type at all."""
    out = sender()
    for i in range(400):
        for channel in ("LIDAR", "ODOMETRY", "PANTILT_STATE", "SENSOR_INFO"):
            data = os.urandom(8) + struct.pack(">qddd", int(time.time() * 1e6), 1.0, 2.0, 3.0)
            if i % 2:
                data = os.urandom(60 + i)
            out.sendto(datagrams(channel, data, i)[0], (GROUP, stack.far_port))
        time.sleep(0.02)


def restamped(data, utime, has_beam_times):
    """A scan as if measured at another time; lidar_raw_t has its beams' times after ranges and bearings."""
    before, = struct.unpack(">q", data[8:16])
    whole = data[:8] + struct.pack(">q", utime) + data[16:]
    if not has_beam_times:
        return whole
    count, = struct.unpack(">i", data[16:20])
    at, form = 20 + 8 * count, f">{count}q"
    times = struct.pack(form, *(t - before + utime for t in struct.unpack(form, data[at:at + 8 * count])))
    return whole[:at] + times + whole[at + 8 * count:]


def other_robot(*channels):
    """Scans that a robot elsewhere measured (the undisturbed run's, of its whole way), stamped as of now: 10 s long."""
    def act(stack):
        scans = {"LIDAR": [], "LIDAR_RAW": []}
        for name, data in events_of(stack.reference):
            if name in scans:
                scans[name].append(data)
        out = sender()
        for i in range(250):
            now = int(time.time() * 1e6)
            for channel in channels:
                raw = "RAW" in channel
                measured = scans["LIDAR_RAW" if raw else "LIDAR"]
                data = restamped(measured[(i * 97) % len(measured)], now, raw)
                out.sendto(datagrams(channel, data, i)[0], (GROUP, stack.far_port))
            time.sleep(0.04)
    return act


def second_slam(stack):
    env = dict(stack.env, LCM_DEFAULT_URL=stack.env["LCM_DEFAULT_URL"].replace(str(PORT), str(stack.far_port)))
    second = stack.spawn("second", stack.bin + "/marco-slam", env=env)
    time.sleep(5)
    stack.note = "the second one left" if second.poll() else "THE SECOND ONE WORKS, TOO"


def full_disk(stack):
    """The logger's folder has 1 MB from the start and is full by now; then there is room again."""
    end = time.time() + 30
    while not stack.full() and time.time() < end:
        time.sleep(0.2)
    time.sleep(3)
    def digest(path):
        with open(path, "rb") as log:
            return hashlib.sha256(log.read()).digest()

    before = digest(stack.recordings()[0])
    subprocess.run(["mount", "-o", "remount,size=64m", stack.folder + "/rec"], check=True)
    time.sleep(5)
    same = before == digest(stack.recordings()[0])
    stack.note = "the first log is untouched" if same and len(stack.recordings()) > 1 else "THE LOGGER DID NOT GO ON"


def writable_again(stack):
    time.sleep(5)
    subprocess.run(["mount", "-o", "remount,rw", stack.folder + "/rec"], check=True)
    time.sleep(3)
    stack.note = "recording since" if stack.recordings() else "THE LOGGER DID NOT BEGIN"


def time_is_known(stack):
    """The computer has no clock of its own: it starts with its last shutdown's time, until a time server answers."""
    time.sleep(15)
    stack.set_clock(0)
    time.sleep(6)


CASES = {"undisturbed": Case(None)}
for _name, _program in PROCESSES.items():
    if _name != "simulator":  # that would be the world's end, not a process's
        CASES["kill -9 " + _name] = Case(kill(_program), "lcm-logger ended with Killed" if _name == "logger"
                                         else f"'{_name}' ended: killed by signal 9")
CASES.update({
    "kill -9 deputy": Case(kill_deputy),
    "stop 5 s slam": Case(pause("marco-slam")),
    "stop 5 s laser": Case(pause("marco-sick"), "marco-sick: dropped .*stalled"),
    "stop 5 s base": Case(pause("marco-base")),
    "stop 5 s pantilt": Case(pause("marco-pantilt")),
    "stop 5 s mapping3d": Case(pause("marco-mapping3d")),
    "stop 5 s logger": Case(pause("lcm-logger")),
    "loss 10 %": Case(losing(0.1, 0.05), options={"relay": True}),
    "loss 50 %": Case(losing(0.5, 0.05), options={"relay": True}),
    "reordered 30 %": Case(losing(0.0, 0.3), options={"relay": True}),
    "laser unplugged": Case(fault("laser", "unplugged", 5.0), "marco-sick: no device"),
    "laser garbage": Case(fault("laser", "garbage", 5.0), "marco-sick: .*garbage|bad_checksum"),
    "laser off": Case(fault("laser", "off", 5.0), "marco-sick: .*the scans stopped"),
    "base off": Case(fault("base", "off", 3.0), "marco-base: .*(does not answer|silent)"),
    "base unplugged": Case(fault("base", "unplugged", 3.0), "marco-base: no device"),
    "pantilt unplugged": Case(fault("pantilt", "unplugged", 3.0), "marco-pantilt: no device"),
    "wrong type": Case(wrong_type, "marco-slam: .*undecodable"),
    "other robot's channel": Case(other_robot("LIDAR_OTHER"), "no SENSOR_INFO for LIDAR_OTHER"),
    "other robot's scans": Case(other_robot("LIDAR", "LIDAR_RAW"),
                                "marco-slam: .*LIDAR: scans at .* is there a second sender"),
    "flood 1 MB": Case(lambda stack: flood(stack.far_port, "LIDAR", os.urandom(1 << 20), 20, 8),
                       "marco-slam: .*undecodable"),
    "two SLAMs": Case(second_slam, "another marco-slam is running"),
    "disk full": Case(full_disk, "waiting for room", {"disk_mb": 1}),
    "disk read-only": Case(writable_again, "waiting for a folder that can be written", {"disk_mb": 64, "read_only": True}),
    "brown-outs": Case(brown_outs, "marco-base: .*(does not answer|silent)"),
    "busy CPU": Case(busy_cpu),
    "no clock at the start": Case(time_is_known, "clock was set by 8", {"clock_s": -26 * 365 * 86400, "before_driving": True}),
    "clock +1 h": Case(clock(3600), "clock was set by 3[56]", {"clock_s": 0}),
    "clock -1 h": Case(clock(-3600), "clock was set by -3[56]", {"clock_s": 0}),
})


def combination(minutes, seed):
    """Faults in random order, some at once, with 5 to 15 s between; then half a minute of peace."""
    # Without those that begin before the stack does.
    names = [name for name, case in CASES.items() if case.act and "disk_mb" not in case.options and not case.options.get("clock_s")]

    def act(stack):
        choice, end, done = random.Random(seed), time.time() + 60 * minutes, []
        while time.time() < end:
            for name in choice.sample(names, choice.choice((1, 1, 2))):
                CASES[name].act(stack)
                done.append(name)
            time.sleep(choice.uniform(5, 15))
            stack.keep_driving()
        time.sleep(30)
        stack.note = f"{len(done)} faults: " + ", ".join(done)
    return Case(act, options={"relay": True, "clock_s": 0})
