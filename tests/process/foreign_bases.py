#!/usr/bin/env python3
"""A judge of the bases' emulators that shares none of our code: written from the manuals' facts alone.

It starts marco-sim with each robot of the theses, opens the robot's pseudo-terminals as a host would, shakes
hands, drives, reads, and checks every frame, sum and number it gets. Waits are generous: only a device that
does not come at all makes it fail, never a slow machine.

Usage: foreign_bases.py MARCO_SIM CONFIG_FOLDER          exit 0 = all that was asked came true
"""
import functools
import operator
import os
import re
import select
import struct
import subprocess
import sys
import tempfile
import termios
import time
import tty

PATIENCE_S = 30.0
checks = 0


def check(what, value, wanted, tolerance=None):
    global checks
    good = value == wanted if tolerance is None else abs(value - wanted) <= tolerance
    if not good:
        sys.exit(f"FAILED: {what}: got {value!r}, wanted {wanted!r}" + (f" +- {tolerance}" if tolerance else ""))
    checks += 1


class Line:
    """A serial line, raw, 8N1."""

    def __init__(self, path, speed=termios.B9600):
        until = time.monotonic() + PATIENCE_S
        while not os.path.exists(path) and time.monotonic() < until:
            time.sleep(0.05)
        self.fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.fd)
        settings = termios.tcgetattr(self.fd)
        settings[4] = settings[5] = speed
        termios.tcsetattr(self.fd, termios.TCSANOW, settings)

    def write(self, data):
        os.write(self.fd, data)

    def read(self, wait_s):
        ready, _, _ = select.select([self.fd], [], [], wait_s)
        return os.read(self.fd, 4096) if ready else b""

    def close(self):
        os.close(self.fd)


# ---- Pioneer: FA FB n payload sum, sum big endian over pairs, the odd byte exclusive-ored --------------------


def pioneer_sum(payload):
    total = 0
    for i in range(0, len(payload) - 1, 2):
        total = (total + (payload[i] << 8 | payload[i + 1])) & 0xFFFF
    return total ^ payload[-1] if len(payload) % 2 else total


def pioneer_packet(payload):
    total = pioneer_sum(payload)
    return bytes([0xFA, 0xFB, len(payload) + 2]) + payload + bytes([total >> 8, total & 255])


def pioneer_command(number, value=None):
    if value is None:
        return pioneer_packet(bytes([number]))
    return pioneer_packet(bytes([number, 0x3B if value >= 0 else 0x1B]) + struct.pack("<H", abs(value)))


class Pioneer:
    def __init__(self, line):
        self.line = line
        self.buffer = b""
        self.sips = []
        self.others = []

    def say(self, number, value=None):
        self.line.write(pioneer_command(number, value))

    def listen(self, wait_s=0.1):
        """All packets that are whole by then; a wrong head or sum is a failure: this line loses nothing."""
        self.buffer += self.line.read(wait_s)
        found = []
        while len(self.buffer) >= 3:
            check("head", self.buffer[:2], b"\xfa\xfb")
            size = self.buffer[2] + 3
            if len(self.buffer) < size:
                break
            payload, total = self.buffer[3:size - 2], self.buffer[size - 2:size]
            check("sum", pioneer_sum(payload), total[0] << 8 | total[1])
            self.buffer = self.buffer[size:]
            found.append(payload)
            (self.sips if payload[0] in (0x32, 0x33) else self.others).append((time.monotonic(), payload))
        return found

    def wait(self, what, condition):
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            self.listen()
            result = condition()
            if result:
                return result
        sys.exit(f"FAILED: {what} never came")

    def sip(self):
        """The newest, taken apart."""
        payload = self.sips[-1][1]
        x, y, heading, left, right, battery = struct.unpack_from("<HHhhhB", payload, 1)
        flags, = struct.unpack_from("<H", payload, 16)
        count = payload[19]
        sonars = [struct.unpack_from("<BH", payload, 20 + 3 * i) for i in range(count)]
        check("length of a packet", len(payload), 20 + 3 * count + 5)
        return dict(moving=payload[0] == 0x33, x=x, y=y, heading=heading, left=left, right=right,
                    battery=battery, stall=payload[12] & 1, flags=flags, sonars=sonars)


def judge_pioneer(port, subtype=b"P2DX", mm=0.84, velocity_mm_per_s=1.0, range_mm=0.268, sonars=16):
    """Factors and number of sonars: of the robot's parameter file."""
    for numbers, frame in ((("sync", 0, None), "FA FB 03 00 00 00"), (("open", 1, 1), "FA FB 06 01 3B 01 00 02 3B"),
                           (("vel", 11, -200), "FA FB 06 0B 1B C8 00 D3 1B"), (("seta", 5, 300), "FA FB 06 05 3B 2C 01 31 3C")):
        check("this client's " + numbers[0], pioneer_command(numbers[1], numbers[2]), bytes.fromhex(frame))
    robot = Pioneer(Line(port))
    for sync in (0, 1, 2):
        robot.say(sync)
        robot.wait(f"the answer to SYNC{sync}", lambda: robot.others and robot.others[-1][1][0] == sync)
    check("name, kind, model", robot.others[-1][1][1:].split(b"\0"), [b"MARCO", b"Pioneer", subtype, b""])
    robot.say(1, 1)
    robot.wait("a first information packet", lambda: robot.sips)
    check("motors off at first", robot.sip()["flags"] & 1, 0)
    for number, value in ((28, 1), (4, 1), (5, 300), (6, 500), (7, None)):  # sonar, enable, acceleration, speed, origin
        robot.say(number, value)
    robot.wait("enabled motors", lambda: robot.sip()["flags"] & 1)
    heard = {}

    def all_sonars():
        heard.update(robot.sip()["sonars"])
        robot.say(0)
        return len(heard) == sonars
    robot.wait("all sonars", all_sonars)
    check("a sonar's number", max(heard), sonars - 1)
    check("a sonar's most, 5 m", max(heard.values()) <= round(5000 / range_mm), True)
    check("something is within 5 m", min(heard.values()) < round(5000 / range_mm), True)
    check("battery", robot.sip()["battery"], 126, 10)

    # The pace: a hundred milliseconds a packet, by the mean of twenty.
    first = len(robot.sips)
    robot.wait("twenty packets", lambda: robot.say(0) or len(robot.sips) >= first + 21)
    stamps = [stamp for stamp, _ in robot.sips[first:first + 21]]
    check("seconds a packet", (stamps[-1] - stamps[0]) / 20, 0.1, 0.05)

    robot.say(8, 500)  # half a metre
    robot.wait("motion", lambda: robot.sip()["moving"])
    robot.wait("the end of the move", lambda: robot.say(0) or not robot.sip()["moving"])
    check("x after MOVE 500 [mm]", robot.sip()["x"] * mm, 500, 3)
    check("y", (robot.sip()["y"] + 0x4000) % 0x8000 - 0x4000, 0, 3)
    robot.say(13, 90)
    robot.wait("a turn", lambda: robot.sip()["moving"])
    robot.wait("the end of the turn", lambda: robot.say(0) or not robot.sip()["moving"])
    check("heading after DHEAD 90 [4096 a turn]", robot.sip()["heading"], 1024, 6)
    robot.say(11, -200)  # backwards, until nobody says so any more
    backwards = round(-200 / velocity_mm_per_s)
    fast = robot.wait("200 mm/s backwards", lambda: robot.sip()["left"] == backwards and robot.sip())
    check("right wheel", fast["right"], backwards)
    silent = time.monotonic()
    robot.wait("the watchdog's stop", lambda: not robot.sip()["moving"])
    check("the watchdog waited", time.monotonic() - silent > 1.5, True)

    robot.say(18, 1)
    packet = robot.wait("CONFIG's answer", lambda: next((p for _, p in robot.others if p[0] == 0x20), None))
    kind, model, serial, rest = packet[1:].split(b"\0", 3)
    check("CONFIG", (kind, model), (b"Pioneer", subtype))
    top_turn, top_speed = struct.unpack_from("<HH", rest, 1)
    check("top speeds", (top_turn, top_speed), (500, 2200))
    robot.say(19, 1)
    ticks = robot.wait("ENCODER's answer", lambda: next((p for _, p in robot.others if p[0] == 0x90), None))
    left, right = struct.unpack("<ii", ticks[1:])
    check("a quarter turn parts the wheels", right - left > 1000, True)
    robot.say(4, 0)
    robot.wait("motors off", lambda: not robot.sip()["flags"] & 1)
    robot.say(2, None)
    time.sleep(0.3)
    robot.listen()
    quiet = len(robot.sips)
    time.sleep(0.5)
    robot.listen()
    check("silence after CLOSE", len(robot.sips), quiet)
    robot.line.close()


# ---- HCS12: lines of a letter and numbers; one command, then its answer --------------------------------------


class Board:
    def __init__(self, line):
        self.line = line
        self.buffer = b""
        self.slowest_s = 0.0

    def next_line(self, wait_s=PATIENCE_S):
        until = time.monotonic() + wait_s
        while b"\n" not in self.buffer:
            if time.monotonic() > until:
                return None
            self.buffer += self.line.read(0.05)
        line, self.buffer = self.buffer.split(b"\n", 1)
        return line.decode("latin-1")

    def ask(self, command):
        sent = time.monotonic()
        self.line.write(command.encode() + b"\n")
        answer = self.next_line()
        if answer is None:
            sys.exit(f"FAILED: no answer to {command!r}")
        self.slowest_s = max(self.slowest_s, time.monotonic() - sent)
        return answer

    def wait(self, what, condition):
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            result = condition()
            if result:
                return result
            time.sleep(0.1)  # a board that prints misses the ticks of its motors meanwhile
        sys.exit(f"FAILED: {what} never came")


def skip_greeting(board):
    while (line := board.next_line(0.5)) is not None:
        if line == "Listo":
            break


def judge_base(port):
    board = Board(Line(port))
    skip_greeting(board)
    check("ping", board.ask("*"), "*")

    def wheels():
        answer = board.ask("l")
        found = re.fullmatch(r"l(\d+)\.(\d\d) (\d+)\.(\d\d) ([01]) ([01]) ([01])", answer)
        check(f"form of {answer!r}", found is not None, True)
        n = [int(text) for text in found.groups()]
        return dict(left=n[0] * 100 + n[1], right=n[2] * 100 + n[3], left_on=n[4], right_on=n[5], sonar=n[6])
    check("at rest", (wheels()["left_on"], wheels()["right_on"]), (0, 0))
    check("ramp", board.ask("k5 30 50"), "k")
    check("forward ten turns", board.ask("a100"), "a")
    check("running", wheels()["left_on"], 1)
    # It does nothing else while it prints, and rolls on: near the end it must be let alone, so `w` and not `l`.
    check("the end of the move", board.ask("w20000 1 1 0"), "w")
    done = wheels()
    check("both are off", (done["left_on"], done["right_on"]), (0, 0))
    # The last tick's clicks, and those of the two characters of the answer.
    for side in ("left", "right"):
        check(f"{side} clicks of a100", done[side], 10000, 60)
    for command, letter in (("r50", "r"), ("i20", "i"), ("d20", "d")):
        check(command, board.ask(command), letter)
        check(f"the end of {command}", board.ask("w20000 1 1 0"), "w")
        check(f"clicks of {command}", wheels()["left"], int(command[1:]) * 100, 60)
    check("stop", board.ask("p"), "p")

    # Three numbers are not enough for the flags: it waits the whole time; with four it looks.
    board.ask("a10")
    started = time.monotonic()
    check("w with flags", board.ask("w20000 1 1 0"), "w")
    check("it did not wait out its 20 s", time.monotonic() - started < 15.0, True)
    started = time.monotonic()
    check("w with three numbers", board.ask("w1000 1 1"), "w")
    check("a second of 1.024 ms ticks", time.monotonic() - started > 1.0, True)

    volts = [int(text) for text in board.ask("t")[1:].split()]
    check("four batteries", len(volts), 4)
    for value, nominal in zip(volts, (12000, 24000, 12000, 24000)):
        check("a battery [mV]", value, nominal, 0.2 * nominal)
    check("order of the sonars", board.ask("S0 4 8 12"), "S")
    check("listening and rest", board.ask("s2 50 20"), "s")
    check("sonars on", board.ask("s1"), "s")
    check("sonars are on", wheels()["sonar"], 1)
    time.sleep(0.5)

    def echoes():
        words = board.ask("s")[1:].split()
        while len(words) < 4:  # the listing's firmware gives each value a line
            words += board.next_line().split()
        return [int(word) for word in words]
    # Ahead the hall may be longer than 12.2 m; the walls behind and to the right are near.
    readings = board.wait("echoes", lambda: next((r for r in [echoes()] if sum(v != 65535 for v in r) >= 2), None))
    for value in readings:
        if value != 65535:
            check("an echo within the hall [m]", 0.05 < value * 5.3333e-6 * 343 / 2 < 12.3, True)
    check("sonars off", board.ask("s0"), "s")
    board.line.write(b"Y1\n")  # no such command: not a byte comes back
    check("silence on an unknown letter", board.next_line(0.5), None)
    board.line.close()


def judge_pantilt(port):
    board = Board(Line(port))
    board.wait("homing", lambda: board.next_line() == "Listo")

    def axes():
        numbers = [int(word) for word in board.ask("l")[1:].split()]
        check("nine fields", len(numbers), 9)
        return dict(pan=numbers[0], tilt=numbers[2], low=numbers[6], moving=numbers[7] or numbers[8])
    check("home", (axes()["pan"], axes()["tilt"]), (0, 0))
    check("ping", board.ask("*"), "*")
    check("ramp of the pan", board.ask("k3 50 30"), "k")
    check("ramp of the tilt", board.ask("K3 50 30"), "K")
    check("pan", board.ask("g20"), "g")
    board.wait("pan at 20", lambda: not axes()["moving"])
    check("pan", axes()["pan"], 20)
    check("tilt", board.ask("e10"), "e")
    board.wait("tilt at 10", lambda: not axes()["moving"])
    check("tilt", axes()["tilt"], 10)
    board.ask("g10")
    board.ask("e0")
    # Asked right behind an order it may say that it does not move yet.
    board.wait("both at 10 and 0", lambda: (now := axes())["moving"] == 0 and (now["pan"], now["tilt"]) == (10, 0))
    board.ask("g5")
    check("w with flags", board.ask("w20000 1 0"), "w")
    check("arrived", axes()["pan"], 5)
    board.line.close()


# ---- The text protocol of docs/text_base.md, by that page alone -----------------------------------------------


def summed(text):
    total = 0
    for byte in text.encode():
        total ^= byte
    return f"{text}*{total:02X}"


class TextBoard(Board):
    """Lines with sums, once it was sent one."""

    def next_text(self, letter):
        """The next line of this letter; others are checked and passed over."""
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            line = self.next_line()
            if line is None:
                break
            text = line.rsplit("*", 1)[0]
            check(f"sum of {line!r}", summed(text), line)
            if text[0] == letter:
                return text
        sys.exit(f"FAILED: no line {letter}")

    def say(self, text):
        self.line.write((summed(text) + "\n").encode())

    def report(self):
        found = re.fullmatch(r"T (\d+) (-?\d+) (-?\d+) (\d+)", self.next_text("T"))
        check("form of a report", found is not None, True)
        return [int(number) for number in found.groups()]


def judge_text_base(port):
    for text, line in (("M 250 -250", "M 250 -250*60"), ("M 0 0", "M 0 0*4D")):
        check("this client's sum", summed(text), line)
    board = TextBoard(Line(port, termios.B115200))
    found = re.fullmatch(r"V 1 (\S+) (\S+) wd=(\d+)", board.next_line())
    check("greeting", found is not None and int(found[3]) == 500, True)
    board.say("V?")
    check("answer to V?", board.next_text("V"), found[0])
    for order in ("W 400", "R 10", "W 2000"):  # long: a busy computer may order late
        board.say(order)
        check(order, board.next_text("K"), "K " + order)
    for order, number in (("W 99", 3), ("W 2001", 3), ("R 4", 3), ("R 1001", 3), ("Q", 1), ("M 1", 1), ("M 1 2 3", 1)):
        board.say(order)
        check(order, int(board.next_text("E").split()[1]), number)
    board.line.write(b"M 250 -250*61\n")
    check("a wrong sum", int(board.next_text("E").split()[1]), 2)
    check("motors off at first", board.report()[3], 0)
    check("battery [mV]", int(board.next_text("B").split()[1]), 7400, 1000)

    still = board.report()
    while (first := board.report())[1] - still[1] < 100:
        board.say("M 1000 -600")
    while (now := board.report())[0] - first[0] < 1500:
        board.say("M 1000 -600")
    check("reports are 10 ms apart", board.report()[0] - board.report()[0], -10, 11)
    check("motors on", now[3], 1)
    seconds = (now[0] - first[0]) / 1000
    check("left ticks", now[1] - first[1], 1000 * seconds, 150)
    check("right ticks", now[2] - first[2], -600 * seconds, 100)
    board.say("W 400")
    check("the watchdog is told", int(board.next_text("E").split()[1]), 4)
    before = board.report()
    check("flag of the watchdog", before[3], 2)
    until = time.monotonic() + 1.0
    while time.monotonic() < until:
        after = board.report()
    check("the wheels stand", after[1] - before[1] < 300, True)
    last = board.report()
    check("and stay", board.report()[1:3], last[1:3])
    board.line.close()


# ---- iRobot's Open Interface: 13 n {id data} sum, big endian, all bytes sum to 0 ------------------------------


class Create:
    SIZES = {7: 1, 9: 1, 10: 1, 11: 1, 12: 1, 14: 1, 21: 1, 22: 2, 23: 2, 35: 1, 43: 2, 44: 2}

    def __init__(self, line):
        self.line = line
        self.buffer = b""

    def say(self, *numbers):
        self.line.write(bytes(numbers))

    def drive(self, left, right):
        self.line.write(struct.pack(">Bhh", 145, right, left))

    def frame(self):
        """The next one, as a dictionary of packets."""
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            size = self.buffer[1] + 3 if len(self.buffer) > 1 else 3
            if len(self.buffer) >= size:
                whole, self.buffer = self.buffer[:size], self.buffer[size:]
                check("head of a frame", whole[0], 19)
                check("sum of a frame", sum(whole) % 256, 0)
                packets, rest = {}, whole[2:-1]
                while rest:
                    length = self.SIZES[rest[0]]
                    packets[rest[0]] = int.from_bytes(rest[1:1 + length], "big")
                    check("a whole packet", len(rest) > length, True)
                    rest = rest[1 + length:]
                return packets
            self.buffer += self.line.read(0.1)
        sys.exit("FAILED: no frame")

    def answer(self, length):
        until = time.monotonic() + PATIENCE_S
        while len(self.buffer) < length and time.monotonic() < until:
            self.buffer += self.line.read(0.1)
        data, self.buffer = self.buffer[:length], self.buffer[length:]
        return data


def judge_create(port):
    check("the document's frame", sum(bytes.fromhex("1305 1D0219 0D00 A3")) % 256, 0)
    robot = Create(Line(port, termios.B115200))
    robot.say(142, 35)
    check("off, it answers nothing", robot.line.read(0.3), b"")
    robot.say(128, 142, 35)
    check("passive after START", robot.answer(1), b"\x01")
    robot.say(131, 142, 35)
    check("safe", robot.answer(1), b"\x02")
    robot.say(149, 3, 22, 43, 35)
    data = robot.answer(5)
    check("battery [mV]", int.from_bytes(data[:2], "big"), 15000, 2000)
    check("mode behind two others", data[4], 2)
    robot.say(148, 3, 43, 44, 7)
    first = robot.frame()
    check("packets of a frame", list(first), [43, 44, 7])
    begun, frames = time.monotonic(), 0
    while frames < 100:
        now, frames = robot.frame(), frames + 1
    check("seconds a frame", (time.monotonic() - begun) / 100, 0.015, 0.004)
    check("stands until it is told", (now[43], now[44]), (first[43], first[44]))

    tick = 3.14159265 * 72 / 508.8  # [mm]
    robot.drive(100, -60)
    for _ in range(67):
        robot.frame()
    one = robot.frame()
    for _ in range(133):
        two = robot.frame()
    seconds = 133 * 0.015
    way = [((two[k] - one[k] + 32768) % 65536 - 32768) * tick for k in (43, 44)]
    check("left wheel [mm]", way[0], 100 * seconds, 8)
    check("right wheel [mm], backwards below 0", way[1], -60 * seconds, 8)
    robot.say(128)
    for _ in range(30):
        last = robot.frame()
    after = robot.frame()
    check("START stops the wheels", (after[43], after[44]), (last[43], last[44]))
    robot.drive(100, 100)
    for _ in range(30):
        after = robot.frame()
    check("passive, it does not drive", (after[43], after[44]), (last[43], last[44]))
    robot.say(150, 0)
    time.sleep(0.1)
    robot.line.read(0.1)
    robot.buffer = b""
    check("a paused stream", robot.line.read(0.3), b"")
    robot.line.close()


# ---- Kobuki: AA 55 n {id size data} xor, little endian ---------------------------------------------------------


class Kobuki:
    def __init__(self, line):
        self.line = line
        self.buffer = b""

    def say(self, part):
        body = bytes([len(part)]) + part
        self.line.write(b"\xAA\x55" + body + bytes([functools.reduce(operator.xor, body)]))

    def drive(self, speed, radius):
        self.say(struct.pack("<BBhh", 1, 4, speed, radius))

    def frame(self):
        """The next one, as a dictionary of parts."""
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            size = self.buffer[2] + 4 if len(self.buffer) > 2 else 4
            if len(self.buffer) >= size:
                whole, self.buffer = self.buffer[:size], self.buffer[size:]
                check("head of a frame", whole[:2], b"\xAA\x55")
                check("sum of a frame", functools.reduce(operator.xor, whole[2:]), 0)
                parts, rest = {}, whole[3:-1]
                while rest:
                    check("a whole part", len(rest) >= 2 + rest[1], True)
                    parts[rest[0]], rest = rest[2:2 + rest[1]], rest[2 + rest[1]:]
                return parts
            self.buffer += self.line.read(0.1)
        sys.exit("FAILED: no frame")


def judge_kobuki(port):
    robot = Kobuki(Line(port, termios.B115200))

    def basic():
        return struct.unpack("<HBBBHHbbBBBB", robot.frame()[1])

    first = basic()
    begun, frames = time.monotonic(), 0
    while frames < 100:
        now, frames = basic(), frames + 1
    check("seconds a frame", (time.monotonic() - begun) / 100, 0.02, 0.005)
    check("its clock [ms]", (now[0] - first[0]) % 65536, 2000, 60)
    check("nothing touches it", now[1:4], (0, 0, 0))
    check("battery [0.1 V]", now[10], 165, 5)
    check("stands until it is told", now[4:6], first[4:6])
    robot.say(bytes.fromhex("09020B00"))
    parts, until = {}, time.monotonic() + PATIENCE_S
    while 0x0B not in parts and time.monotonic() < until:
        parts.update(robot.frame())
    check("the firmware's version", len(parts.get(0x0B, b"")), 4)

    def driven(speed, radius):
        """mm/s of both wheels, and deg/s of the gyro by both ways, in its second second."""
        robot.drive(speed, radius)
        for _ in range(50):
            one = basic()
        for _ in range(50):
            parts = robot.frame()
        two = struct.unpack("<HBBBHHbbBBBB", parts[1])
        seconds = (two[0] - one[0]) % 65536 / 1000
        wheels = [((two[k] - one[k] + 32768) % 65536 - 32768) / 11.7244166 / seconds for k in (4, 5)]
        readings = struct.unpack(f"<{parts[13][1]}h", parts[13][2:])
        return (*wheels, struct.unpack("<h", parts[4][2:4])[0] / 100, readings[2] * 0.00875)

    left, right, rate, raw = driven(120, 0)
    check("ahead, left [mm/s]", left, 120, 4)
    check("ahead, right [mm/s]", right, 120, 4)
    check("ahead, it does not turn", (abs(rate) < 0.5, abs(raw) < 0.5), (True, True))
    left, right, rate, raw = driven(58, 1)  # 0.504 rad/s
    check("on the spot, left [mm/s]", left, -58, 4)
    check("on the spot, right [mm/s]", right, 58, 4)
    check("on the spot [deg/s]", rate, 28.9, 1)
    check("on the spot, the gyro's own [deg/s]", raw, 28.9, 1)
    left, right, rate, raw = driven(-100, -300)  # back, round a centre on the right: counter-clockwise
    check("an arc, left [mm/s]", left, -100, 4)
    check("an arc, right [mm/s]", right, -100 * 185 / 415, 4)
    check("an arc [deg/s]", rate, 13.8, 1)
    robot.drive(0, 0)
    for _ in range(40):
        one = basic()
    two = basic()
    check("it stands", two[4:6], one[4:6])
    robot.line.close()


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    simulator, config = sys.argv[1:]
    amigo = functools.partial(judge_pioneer, subtype=b"amigo", mm=0.5083, velocity_mm_per_s=0.6154, range_mm=1.0, sonars=8)
    powerbot = functools.partial(judge_pioneer, subtype=b"powerbot", mm=0.5813, range_mm=1.0, sonars=32)
    for robot, judges in (("marco", (("base", judge_pioneer),)),
                          ("amigo", (("base", amigo),)),
                          ("powerbot", (("base", powerbot),)),
                          ("michoacan", (("pantilt", judge_pantilt), ("base", judge_base))),
                          ("homemade", (("base", judge_text_base),)),
                          ("create", (("base", judge_create),)),
                          ("kobuki", (("base", judge_kobuki),))):
        with tempfile.TemporaryDirectory() as folder:
            file = f"{config}/robots/{robot}.toml"
            if not os.path.exists(file):  # another Pioneer
                with open(f"{config}/robots/marco.toml", encoding="utf-8") as marco:
                    text = f'pioneer = "{robot}"\n' + marco.read()
                file = folder + "/robot.toml"
                with open(file, "w", encoding="utf-8") as other:
                    other.write(text)
            process = subprocess.Popen(
                [simulator, "--config", file, "--world", f"{config}/worlds/lab.toml",
                 "--start", "2", "3", "0", "--ports", folder, "--lcm-url", "memq://"], stdout=subprocess.DEVNULL)
            try:
                for port, judge in judges:
                    began, before = time.monotonic(), checks
                    judge(f"{folder}/{port}")
                    print(f"{robot} {port}: {checks - before} checks in {time.monotonic() - began:.1f} s", flush=True)
            finally:
                process.terminate()
                process.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
