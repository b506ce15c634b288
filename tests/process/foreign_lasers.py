#!/usr/bin/env python3
"""A judge of the emulators of lasers and of an inertial sensor that shares none of our code: written from notes on the makers' documents alone.

It starts marco-sim with a robot that stands in a plain room and carries every laser below, opens each laser's
pseudo-terminal or TCP port as a host would, at the laser's speed, takes its bytes apart, and holds each range against a ray that
it casts itself. Slamtec: "Interface Protocol and Application Notes"
(A, S series: requests, nodes, dense, ultra and ultra dense capsules). LDROBOT: "LD06 development manual" (packets, CRC). YDLIDAR: the X2, X4
and G4 development manuals (requests, packets, checksum, angle correction); health by 92 is the maker's SDK's. SICK: "Telegram Listing Ranging
sensors LMS1xx, TiM5xx" (CoLa A). Hokuyo: "Communication Protocol Specification for SCIP 2.0". Bosch: "BNO055 Data
sheet" (UART).

Usage: foreign_lasers.py MARCO_SIM          exit 0 = every packet and range came true
"""
import array
import contextlib
import fcntl
import math
import os
import select
import socket
import struct
import subprocess
import sys
import tempfile
import time
import tty

PATIENCE_S = 30.0
WIDTH_M, DEPTH_M, WALL_M = 6.0, 5.0, 0.1
X_M, Y_M, HEADING_DEG = 2.2, 1.9, 25.0
HEIGHT_M = 0.3
ROOM = f"""floor_m = [0, 0, {WIDTH_M}, {DEPTH_M}]
ceiling_m = 2.5
[[walls]]
corners_m = [0, 0, {WIDTH_M}, 0, {WIDTH_M}, {DEPTH_M}, 0, {DEPTH_M}, 0, 0]
thickness_m = {WALL_M}
"""
OPTICS = """[lasers.optics]
range_sigma_m = 0.0
missing_part = 0.0
footprint_deg = 0.0
"""

checks = 0


def check(what, value, wanted, tolerance=None):
    global checks
    good = value == wanted if tolerance is None else abs(value - wanted) <= tolerance
    if not good:
        sys.exit(f"FAILED: {what}: got {value!r}, wanted {wanted!r}" + (f" +- {tolerance}" if tolerance else ""))
    checks += 1


def true_range_m(bearing_deg):
    """From the laser to the wall; bearings clockwise from ahead."""
    angle = math.radians(HEADING_DEG - bearing_deg)
    dx, dy = math.cos(angle), math.sin(angle)
    half = WALL_M / 2
    to_x = ((WIDTH_M - half if dx > 0 else half) - X_M) / dx if abs(dx) > 1e-12 else math.inf
    to_y = ((DEPTH_M - half if dy > 0 else half) - Y_M) / dy if abs(dy) > 1e-12 else math.inf
    return min(to_x, to_y)


def check_range(what, bearing_deg, range_m, angle_error_deg, range_error_m=0.002):
    """The angle is rounded: the wall's range changes by so much."""
    around = [true_range_m(bearing_deg + d) for d in (-angle_error_deg, 0.0, angle_error_deg)]
    check(what + f" at {bearing_deg:.3f} deg", min(around) - range_error_m <= range_m <= max(around) + range_error_m, True)


class Line:
    """A serial line, raw, 8N1, of any speed (termios2)."""

    TCGETS2, TCSETS2, BOTHER, CBAUD = 0x802C542A, 0x402C542B, 0o010000, 0o010017

    def __init__(self, path, baud):
        until = time.monotonic() + PATIENCE_S
        while not os.path.exists(path) and time.monotonic() < until:
            time.sleep(0.05)
        self.fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.fd)
        settings = array.array("B", bytes(44))
        fcntl.ioctl(self.fd, self.TCGETS2, settings, True)
        fields = list(struct.unpack("<4I20s2I", settings))
        fields[2] = fields[2] & ~self.CBAUD | self.BOTHER
        fields[5] = fields[6] = baud
        fcntl.ioctl(self.fd, self.TCSETS2, struct.pack("<4I20s2I", *fields))

    def write(self, data):
        os.write(self.fd, data)

    def read(self, wait_s):
        ready, _, _ = select.select([self.fd], [], [], wait_s)
        return os.read(self.fd, 4096) if ready else b""

    def drain(self, for_s):
        until = time.monotonic() + for_s
        while time.monotonic() < until:
            self.read(0.02)

    def falls_silent(self):
        """Reads what is still on its way, which may come late on a busy computer. @returns whether it ends."""
        until = time.monotonic() + PATIENCE_S
        while self.read(0.5):
            if time.monotonic() > until:
                return False
        return True

    def close(self):
        os.close(self.fd)


class Connection:
    """The same over TCP; `port` is a number."""

    def __init__(self, port):
        until = time.monotonic() + PATIENCE_S
        while True:
            try:
                self.socket = socket.create_connection(("127.0.0.1", port), 2.0)
                break
            except ConnectionRefusedError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.05)

    write = property(lambda self: self.socket.sendall)
    drain = Line.drain
    falls_silent = Line.falls_silent

    def read(self, wait_s):
        ready, _, _ = select.select([self.socket], [], [], wait_s)
        return self.socket.recv(65536) if ready else b""

    def close(self):
        self.socket.close()


class Bytes:
    """What comes from the line, by the number of bytes wanted."""

    def __init__(self, line):
        self.line, self.buffer = line, b""

    def need(self, count):
        until = time.monotonic() + PATIENCE_S
        while len(self.buffer) < count:
            if time.monotonic() > until:
                sys.exit("FAILED: the bytes stopped")
            self.buffer += self.line.read(0.1)

    def take(self, count):
        self.need(count)
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def seek(self, mark):
        while True:
            self.need(len(mark))
            if self.buffer.startswith(mark):
                return
            self.buffer = self.buffer[1:]


# ---- LDROBOT: 54 2C, speed, start, twelve of (range, intensity), end, stamp, CRC-8 of 4D ---------------------


def crc8(data):
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x4D) & 0xFF if crc & 0x80 else crc << 1
    return crc


def judge_ldrobot(port, baud, samples_per_s):
    manual = bytes.fromhex("542C6808AB7EE000E4DC00E2D900E5D500E3D300E4D000E9CD00E4CA00E2C700E9C500E5C200E5C000E5BE823A1A50")
    check("this judge's CRC on the manual's packet", crc8(manual[:-1]), manual[-1])
    line = Line(port, baud)
    stream = Bytes(line)
    stream.seek(b"\x54\x2C")
    stream.take(47)  # may have been cut by the opening
    stream.seek(b"\x54\x2C")
    # Read all first: at 84 kB a second, a reader that computes between packets loses some.
    packets, raw = [], [stream.take(47) for _ in range(4 * samples_per_s // 12)]
    line.close()
    for data in raw:
        check("marks", data[:2], b"\x54\x2C")
        check("CRC", crc8(data[:-1]), data[-1])
        speed, start = struct.unpack_from("<HH", data, 2)
        end, stamp = struct.unpack_from("<HH", data, 42)
        packets.append((start / 100, end / 100, stamp))
        check("speed, ten turns a second", speed, 3600)
        for i in range(12):
            range_mm, intensity = struct.unpack_from("<HB", data, 6 + 3 * i)
            bearing = start / 100 + i * ((end - start) / 100 % 360) / 11
            check_range("LDROBOT range", bearing, range_mm / 1000, 0.02)
            check("an echo has an intensity", intensity > 0, True)
    elapsed_ms = 0
    for (start, end, stamp), (next_start, _, next_stamp) in zip(packets, packets[1:]):
        check("packets join", (next_start - end) % 360, (end - start) % 360 / 11, 0.03)
        check("stamps lie below 30000", 0 <= next_stamp < 30000, True)
        elapsed_ms += (next_stamp - stamp) % 30000
    check("milliseconds of all samples", elapsed_ms, (len(packets) - 1) * 12e3 / samples_per_s, 2)
    check("the stamps wrapped", any(b[2] < a[2] for a, b in zip(packets, packets[1:])), True)


# ---- YDLIDAR: AA 55, kind, count, first and last angle, sum, samples of mm * 4 -------------------------------


def beside_deg(range_mm):
    return math.degrees(math.atan(21.8 * (155.3 - range_mm) / (155.3 * range_mm))) if range_mm > 0 else 0.0


def read_packet(stream):
    head = stream.take(10)
    check("mark of a packet", head[:2], b"\xaa\x55")
    kind, count = head[2], head[3]
    first, last, total = struct.unpack_from("<HHH", head, 4)
    body = struct.unpack(f"<{count}H", stream.take(2 * count))
    check("count", 1 <= count <= 80, True)
    check("bit 0 of the angles", (first & 1, last & 1), (1, 1))
    xor = 0x55AA ^ (kind | count << 8) ^ first ^ last
    for word in body:
        xor ^= word
    check("sum", xor, total)
    first, last = (first >> 1) / 64, (last >> 1) / 64
    step = (last - first) % 360 / (count - 1) if count > 1 else 0.0
    return kind, [((first + i * step) % 360, word / 4) for i, word in enumerate(body)]


def judge_packets(stream, samples_per_s, turns_per_s):
    turns, since_zero, sizes = 0, 0, []
    while turns < 12:
        kind, samples = read_packet(stream)
        if kind & 1:
            check("a turn begins with one sample", len(samples), 1)
            check("turns a second", (kind >> 1) / 10, turns_per_s)
            check("the angle of the first", samples[0][0] < 1.0, True)
            if turns:
                sizes.append(since_zero)
            turns, since_zero = turns + 1, 0
        since_zero += len(samples)
        for angle, range_mm in samples:
            check_range("YDLIDAR range", angle + beside_deg(range_mm), range_mm / 1000, 0.02)
    check("samples a turn", sum(sizes) / len(sizes), samples_per_s / turns_per_s, 1.0)


def reply(stream, header, size):
    check("header of a reply", stream.take(7), bytes.fromhex(header))
    return stream.take(size)


def judge_ydlidar(port, baud, samples_per_s, model, health_command):
    # The manual's own sum: 53AE twice, 0101, 55AA.
    check("this judge's sum on the manual's packet", 0x55AA ^ 0x0101 ^ 0xAE53 ^ 0xAE53, 0x54AB)
    check("correction at 1 m and 8 m", (round(beside_deg(1000), 4), round(beside_deg(8000), 4)), (-6.7622, -7.8374))
    line = Line(port, baud)
    line.write(b"\xa5\x65")
    line.drain(0.2)
    stream = Bytes(line)
    line.write(b"\xa5\x90")
    info = reply(stream, "A55A1400000004", 20)
    check("model", info[0], model)
    line.write(bytes([0xA5, 0x91 + 0x92 - health_command]))  # the other one's: no answer
    line.write(bytes([0xA5, health_command]))
    check("health", reply(stream, "A55A0300000006", 3), bytes(3))
    if model == 5:
        line.write(b"\xa5\x0d")
        check("7.00 turns a second", struct.unpack("<I", reply(stream, "A55A0400000004", 4)), (700,))
        line.write(b"\xa5\xd1")
        check("9 kHz", reply(stream, "A55A0100000004", 1), b"\x02")
    line.write(b"\xa5\x60")
    check("scan", stream.take(7), bytes.fromhex("A55A0500004081"))
    judge_packets(stream, samples_per_s, 7.0)
    line.write(b"\xa5\x65")
    check("silence after a stop", line.falls_silent(), True)
    line.close()


def judge_x2(port):
    line = Line(port, 115200)
    line.write(b"\xa5\x65\xa5\x90")  # it hears nothing
    stream = Bytes(line)
    stream.seek(b"\xaa\x55")
    judge_packets(stream, 3000, 7.0)
    line.close()


# ---- Slamtec: A5 command [n data xor]; A5 5A, length and mode, kind; nodes of 5 bytes, dense capsules of 84 -----


def slamtec(command, data=b""):
    request = bytes([0xA5, command]) + (bytes([len(data)]) + data if data else b"")
    xor = 0
    for byte in request:
        xor ^= byte
    return request + (bytes([xor]) if data else b"")


def configuration(line, stream, key, mode=b""):
    line.write(slamtec(0x84, struct.pack("<I", key) + mode))
    head = stream.take(7)
    check("head of a configuration", (head[:2], head[6]), (b"\xa5\x5a", 0x20))
    length, = struct.unpack("<I", head[2:6])
    data = stream.take(length)
    check("its key", struct.unpack_from("<I", data), (key,))
    return data[4:]


# Bands of a range of 12 bits: from this code on, this range, in steps of so much.
BANDS = ((3328, 16384, 16), (1792, 4096, 8), (1280, 2048, 4), (512, 512, 2), (0, 0, 1))


def banded(code):
    for first, range_mm, step in BANDS:
        if code >= first:
            return range_mm + (code - first) * step, step


def ultra_ranges(words, word_behind):
    ranges = []
    for word, behind in zip(words, words[1:] + (word_behind,)):
        own, after = banded(word & 0xFFF), banded(behind & 0xFFF)
        ranges.append(own + (0.5 * own[1],))
        for difference, base in ((word >> 12 & 0x3FF, own if own[0] or not after[0] else after), (word >> 22, after)):
            difference -= 1024 if difference >= 512 else 0
            ranges.append((0 if difference in (-512, 511) else base[0] + difference * base[1], base[1], 0.5 * base[1]))
    return ranges


def ultra_behind_deg(range_mm):
    if range_mm < 50:
        return 7.5
    near = 98361 // (4 * range_mm)
    return math.degrees((int(8 * math.pi * 65536 / 180) - 64 * near - near ** 3 // 98304) / 65536)


def judge_ultra(line, stream, express_us, turns_per_s):
    check("this judge's ranges", [r[0] for r in ultra_ranges((0xFFC012F4, 0x801FF3EE, 0x00BFD000), 0x5EE)],
          [1000, 1002, 1498, 1500, 0, 0, 0, 2988, 3008])
    line.write(slamtec(0x82, b"\x01" + bytes(4)))
    check("a scan of ultra capsules", stream.take(7), bytes.fromhex("A55A8400004084"))
    before, told = None, 0
    for _ in range(150):
        data = stream.take(132)
        xor = 0
        for byte in data[2:]:
            xor ^= byte
        check("marks and sum of a capsule", (data[0], data[1]), (0xA0 | xor & 15, 0x50 | xor >> 4))
        word, = struct.unpack_from("<H", data, 2)
        start, words = (word & 0x7FFF) / 64, struct.unpack_from("<32I", data, 4)
        if before is not None:
            span = (start - before[0]) % 360
            check("span of a capsule", span, 96 * express_us * 1e-6 * turns_per_s * 360, 0.04)
            for k, (range_mm, _, half_step) in enumerate(ultra_ranges(before[1], words[0])):
                if range_mm > 0:  # none: beside a corner
                    bearing = before[0] + span * k / 96 - ultra_behind_deg(range_mm)
                    check_range("ultra range", bearing, range_mm / 1000, 0.1, 0.002 + half_step / 1000)
                    told += 1
        before = start, words
    check("nearly all samples have a range", told > 0.98 * 149 * 96, True)
    line.write(slamtec(0x25))
    check("silence after a stop", line.falls_silent(), True)
    line.close()


def judge_slamtec(port, baud, model, express_us, turns_per_s, kind):
    check("this judge's request", slamtec(0x84, bytes.fromhex("710000000000")), bytes.fromhex("A58406710000000000" "56"))
    line = Line(port, baud)
    line.write(slamtec(0x25))
    line.drain(0.1)
    stream = Bytes(line)
    line.write(slamtec(0x50))
    check("model", reply(stream, "A55A1400000004", 20)[0], model)
    line.write(slamtec(0x52))
    check("health", reply(stream, "A55A0300000006", 3), bytes(3))
    mode = configuration(line, stream, 0x7C)
    check("mode", mode, b"\x01\x00")
    check("microseconds a sample", struct.unpack("<I", configuration(line, stream, 0x71, mode))[0] / 256, express_us, 0.01)
    check("kind of answer", configuration(line, stream, 0x75, mode), bytes([kind]))
    if model >> 4 in (6, 7, 8):
        line.write(slamtec(0xA8, struct.pack("<H", 600)))
    if model >> 4 in (2, 3):
        line.write(slamtec(0xF0, struct.pack("<H", 660)))
    if kind == 0x84:
        return judge_ultra(line, stream, express_us, turns_per_s)
    if kind == 0x82:
        return judge_nodes(line, stream, turns_per_s)
    judge_dense(line, stream, express_us, turns_per_s, kind)


def dense(data):
    return struct.unpack_from("<H", data, 2)[0], [float(range_mm) for range_mm in struct.unpack_from("<40H", data, 4)]


def ultra_dense(data):
    """Each range: 20 bits; the lowest two say how many bits it has (10 to 13) and how large its steps are (2 to 5 mm)."""
    angle, = struct.unpack_from("<H", data, 8)
    ranges_mm = []
    for low, middle, high in struct.iter_unpack("<HHB", data[10:]):
        for value in (low + (high % 16 << 16), middle + (high >> 4 << 16)):
            scale = value % 4
            steps = value // 4 % 2 ** (10 + scale)
            ranges_mm.append((0, 2046, 8187, 24567)[scale] + (2 + scale) * steps)
            strength = value >> 12 + scale << scale
            check("an echo has a strength", strength > 0, ranges_mm[-1] > 0)
    return angle, ranges_mm


def judge_dense(line, stream, express_us, turns_per_s, kind):
    size, read, error_m = {0x85: (84, dense, 0.002), 0x86: (170, ultra_dense, 0.0025)}[kind]
    line.write(slamtec(0x82, b"\x01" + bytes(4)))
    check("a scan of capsules", stream.take(7), b"\xa5\x5a" + struct.pack("<I", size | 1 << 30) + bytes([kind]))
    before, capsules = None, 0
    while capsules < 150:
        data = stream.take(size)
        xor = 0
        for byte in data[2:]:
            xor ^= byte
        check("marks and sum of a capsule", (data[0], data[1]), (0xA0 | xor & 15, 0x50 | xor >> 4))
        word, ranges_mm = read(data)
        check("only the first is marked as such", word >> 15, int(before is None))
        start = (word & 0x7FFF) / 64
        if before is not None:
            span, count = (start - before[0]) % 360, len(before[1])
            check("span of a capsule", span, count * express_us * 1e-6 * turns_per_s * 360, 0.04)
            for k, range_mm in enumerate(before[1]):
                check_range("dense range", before[0] + span * k / count, range_mm / 1000, 0.04, error_m)
        before = start, ranges_mm
        capsules += 1
    line.write(slamtec(0x25))
    check("silence after a stop", line.falls_silent(), True)
    line.close()


def judge_nodes(line, stream, turns_per_s):
    line.write(slamtec(0x20))
    check("a standard scan", stream.take(7), bytes.fromhex("A55A0500004081"))
    turns, size, sizes = 0, 0, []
    while turns < 12:
        head, angle, distance = struct.unpack("<BHH", stream.take(5))
        check("check bits of a node", (head & 3 in (1, 2), angle & 1), (True, 1))
        if head & 1:
            sizes.append(size)
            turns, size = turns + 1, 0
        size += 1
        check_range("node", (angle >> 1) / 64, distance / 4000, 0.03)
        check("an echo has a quality", head >> 2 > 0, True)
    check("samples a turn", sum(sizes[1:]) / len(sizes[1:]), 1 / 508e-6 / turns_per_s, 1.0)
    line.write(slamtec(0x25))
    line.close()


# ---- SICK CoLa A: 02, words, 03; numbers in hexadecimal, signed ones as 32 bits --------------------------------


def cola(stream, request=None):
    if request is not None:
        stream.line.write(b"\x02" + request.encode() + b"\x03")
    stream.seek(b"\x02")
    stream.take(1)
    text = b""
    while (byte := stream.take(1)) != b"\x03":
        check("a printable character", 0x20 <= byte[0] < 0x7F, True)
        text += byte
    return text.decode()


def signed(word):
    return int(word) if word[0] in "+-" else (int(word, 16) ^ 0x80000000) - 0x80000000


def channels(words):
    found = {}
    for _ in range(int(next(words), 16)):
        name = next(words)
        scale, offset = (struct.unpack(">f", bytes.fromhex(next(words)))[0] for _ in range(2))
        start, step, count = signed(next(words)) / 1e4, signed(next(words)) / 1e4, int(next(words), 16)
        found[name] = start, step, [int(next(words), 16) * scale + offset for _ in range(count)]
    return found


def cola_scan(text):
    words = iter(text.split(" "))
    check("a scan", [next(words) for _ in range(2)][1], "LMDscandata")
    head = [int(next(words), 16) for _ in range(16)]
    check("status", head[3:5], [0, 0])
    for _ in range(int(next(words), 16)):  # encoders
        next(words), next(words)
    found = {**channels(words), **channels(words)}
    rest = " ".join(words)
    return {"count": head[6], "begin_us": head[7], "sent_us": head[8], "rate": head[14] / 100, "rest": rest, **found}


def judge_cola(port, model, rate, start, step, beams):
    listed = ("sRA LMDscandata 1 1 89A27F 0 0 343 347 27477BA9 2747813B 0 0 7 0 0 1388 168 0 1 DIST1 3F800000 00000000 186A0 1388 "
              "3 8A1 8A5 8AB 0 0 0 0 0 0")
    scan = cola_scan(listed)
    check("this judge on the listing's scan", (scan["DIST1"], scan["rate"], scan["count"]), ((10.0, 0.5, [2209, 2213, 2219]), 50.0, 839))
    line = Connection(port)
    stream = Bytes(line)
    length, name = cola(stream, "sRN DeviceIdent").split(" ")[2:4]
    check("model, behind its length", (int(length, 16), name), (len(model), model))
    check("state", cola(stream, "sRN SCdevicestate"), "sRA SCdevicestate 1")
    check("a name that nobody knows", cola(stream, "sRN Nothing"), "sFA 3")
    check("no settings without login", cola(stream, "sWN LMDscandatacfg 01 00 1 0 0 00 00 0 0 0 0 +1"), "sFA 1")
    single = cola(stream, "sRN LMDscandata")
    check("a single scan", single[:16], "sRA LMDscandata ")
    check("ranges alone", "RSSI1" in cola_scan(single), False)
    check("login", cola(stream, "sMN SetAccessMode 03 F4724744"), "sAN SetAccessMode 1")
    check("intensities", cola(stream, "sWN LMDscandatacfg 01 00 1 0 0 00 00 0 0 0 0 +1"), "sWA LMDscandatacfg")
    check("run", cola(stream, "sMN Run"), "sAN Run 1")
    check("stream", cola(stream, "sEN LMDscandata 1"), "sEA LMDscandata 1")
    before, gaps = None, []
    for _ in range(60):
        text = cola(stream)
        check("of a stream", text[:4], "sSN ")
        scan = cola_scan(text)
        first, by, ranges = scan["DIST1"]
        check("fan", (first, by, len(ranges), scan["rate"]), (start, step, beams, rate))
        check("intensities", len(scan["RSSI1"][2]), beams)
        check("sent behind the last beam", scan["sent_us"] - scan["begin_us"] & 0xFFFFFFFF >= 1e6 * step * (beams - 1) / 360 / rate, True)
        for i, range_mm in enumerate(ranges):
            check_range("CoLa range", 90 - (first + i * by), range_mm / 1000, 0.001)
        if before:
            check("counted", scan["count"] - before["count"], 1)
            gaps.append((scan["begin_us"] - before["begin_us"]) % 2**32)
        before = scan
    check("microseconds of all turns", sum(gaps) / len(gaps), 1e6 / rate, 1.0)
    check("stopped", cola_last(stream, "sEN LMDscandata 0"), "sEA LMDscandata 0")
    check("silence after a stop", line.falls_silent(), True)
    line.close()


def cola_last(stream, request):
    """The answer, behind scans that were under way."""
    text = cola(stream, request)
    while text.startswith("sSN"):
        text = cola(stream)
    return text


# ---- Hokuyo SCIP 2.0: echo, status, lines that end with a sum, an empty line ------------------------------------


def scip(stream, request=None):
    if request is not None:
        stream.line.write(request.encode() + b"\n")
    lines = []
    while True:
        text = b""
        while (byte := stream.take(1)) != b"\n":
            text += byte
        if not text:
            return lines
        lines.append(text.decode())


def summed(text, without_semicolon=False):
    body = text[:-1].rstrip(";") if without_semicolon else text[:-1]
    check("sum of a line", text[-1], chr((sum(body.encode()) & 0x3F) + 0x30))
    return text[:-1]


def number(text):
    value = 0
    for character in text:
        value = value << 6 | ord(character) - 0x30
    return value


def judge_hokuyo(port, model):
    line = Connection(port)
    stream = Bytes(line)
    check("stopped", scip(stream, "QT"), ["QT", "00P"])
    facts = dict(summed(text, True).rstrip(";").split(":") for text in scip(stream, "PP")[2:])
    check("model", facts["MODL"], model)
    turn, front, first, last, rpm = (int(facts[key]) for key in ("ARES", "AFRT", "AMIN", "AMAX", "SCAN"))
    check("fan", (turn, front, first, last, rpm), (1440, 540, 0, 1080, 2400))
    if model == "UST-10LX":
        check("it has no speed", scip(stream, "SS115200"), ["SS115200", "0Ee"])
    check("laser on", scip(stream, "BM"), ["BM", "00P"])
    for command, width in (("MD", 3), ("ME", 6)):
        request = f"{command}{first:04}{last:04}01000"
        check("stream", scip(stream, request), [request, "00P"])
        stamps = []
        for _ in range(40):
            echo, status, stamp, *data = scip(stream)
            check("a scan", (echo, summed(status)), (request, "99"))
            stamps.append(number(summed(stamp)))
            text = "".join(summed(part) for part in data)
            check("lines of 64", all(len(part) == 65 for part in data[:-1]), True)
            check("characters", len(text), width * (last - first + 1))
            for step in range(first, last + 1):
                at = width * (step - first)
                check_range("SCIP range", (front - step) / 4, number(text[at:at + 3]) / 1000, 0.001)
        check("milliseconds of all turns", stamps[-1] - stamps[0], 39 * 25, 2)
        stream.line.write(b"QT\n")
        while scip(stream)[0] != "QT":
            pass
    line.close()


# ---- Bosch BNO055: AA 01 register n -> BB n data; AA 00 register n data -> EE 01; EE 07: no time -----------------


def bosch(line, stream, request, tries=60):
    for _ in range(tries):
        line.write(request)
        kind, second = stream.take(2)
        if kind == 0xBB:
            return stream.take(second)
        check("a status", (kind, second in (1, 7)), (0xEE, True))
        if second == 1:
            return second
        time.sleep(0.003)
    sys.exit("FAILED: it never has time")


def judge_bno055(port):
    line = Line(port, 115200)
    line.drain(0.1)
    stream = Bytes(line)
    check("its name", bosch(line, stream, b"\xaa\x01\x00\x01"), b"\xa0")
    check("it is not configured", bosch(line, stream, b"\xaa\x01\x3d\x01"), b"\x00")
    check("nothing is measured", bosch(line, stream, b"\xaa\x01\x08\x12"), bytes(18))
    line.write(b"\xaa\x01\x69\x12")
    check("no such registers", stream.take(2), b"\xee\x04")
    for units, gravity, rate in ((0x00, 980.7, 16.0), (0x03, 1000.0, 900 / math.degrees(1))):
        check("first mode", bosch(line, stream, b"\xaa\x00\x3d\x01\x00"), 1)
        check("units", bosch(line, stream, bytes([0xAA, 0, 0x3B, 1, units])), 1)
        check("fusion", bosch(line, stream, b"\xaa\x00\x3d\x01\x08"), 1)
        time.sleep(0.05)
        turns = []
        for _ in range(100):
            words = struct.unpack("<9h", bosch(line, stream, b"\xaa\x01\x08\x12"))
            check("gravity", words[2], gravity, 1)
            check("level", words[:2], (0, 0))
            turns.append(words[8])
        check("turning rate of a robot at rest, a bias of 0.2", sum(turns) / 100 / rate, 0.2, 0.03)
    line.close()


DEVICES = {
    "bno055": judge_bno055,
    "tim551": lambda port: judge_cola(port, "TiM551", 15.0, -45.0, 1.0, 271),
    "tim561": lambda port: judge_cola(port, "TiM561", 15.0, -45.0, 0.3333, 811),
    "lms111": lambda port: judge_cola(port, "LMS111_FieldEval", 50.0, -45.0, 0.5, 541),
    "hokuyo_ust": lambda port: judge_hokuyo(port, "UST-10LX"),
    "hokuyo_utm": lambda port: judge_hokuyo(port, "UTM-30LX"),
    "rplidar": lambda port: judge_slamtec(port, 115200, 0x18, 254, 5.5, 0x82),
    "rplidar_a2": lambda port: judge_slamtec(port, 115200, 0x28, 254, 10.0, 0x82),
    "rplidar_a3": lambda port: judge_slamtec(port, 256000, 0x31, 62.5, 10.0, 0x84),
    "rplidar_s1": lambda port: judge_slamtec(port, 256000, 0x61, 108.7, 10.0, 0x84),
    "rplidar_c1": lambda port: judge_slamtec(port, 460800, 0x41, 200, 10.0, 0x85),
    "rplidar_s2": lambda port: judge_slamtec(port, 1000000, 0x71, 31.25, 10.0, 0x85),
    "rplidar_s3": lambda port: judge_slamtec(port, 1000000, 0x81, 31.25, 10.0, 0x86),
    "ld19": lambda port: judge_ldrobot(port, 230400, 4500),
    "stl27l": lambda port: judge_ldrobot(port, 921600, 21600),
    "ydlidar_x2": judge_x2,
    "ydlidar_x4": lambda port: judge_ydlidar(port, 128000, 5000, 6, 0x91),
    "ydlidar_g4": lambda port: judge_ydlidar(port, 230400, 9000, 5, 0x92),
}

ETHERNET = ("tim551", "tim561", "lms111", "hokuyo_ust", "hokuyo_utm")


@contextlib.contextmanager
def simulated(simulator, device):
    """A robot that stands in the room with this device. @returns its port: a path, or a number for those on Ethernet."""
    with tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/room.toml", "w") as file:
            file.write(ROOM)
        tcp = device in ETHERNET
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1] if tcp else f"{folder}/laser"
        with open(f"{folder}/robot.toml", "w") as file:
            if device == "bno055":
                port = f"{folder}/imu"
                file.write('imu = true\nimu_device = "bno055"\n')
            file.write(f'[[lasers]]\nport = "laser"\ndevice = "{device if device != "bno055" else "sick"}"\nposition_m = [0, 0, {HEIGHT_M}]\n'
                       f'tcp_port = {port if tcp else -1}\n{OPTICS}')
        process = subprocess.Popen(
            [simulator, "--config", f"{folder}/robot.toml", "--world", f"{folder}/room.toml", "--start", str(X_M),
             str(Y_M), str(HEADING_DEG), "--ports", folder, "--lcm-url", "memq://"], stdout=subprocess.DEVNULL)
        try:
            yield port
        finally:
            process.terminate()
            process.wait()


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for device, judge in DEVICES.items():
        with simulated(sys.argv[1], device) as port:
            began, before = time.monotonic(), checks
            judge(port)
            print(f"{device}: {checks - before} checks in {time.monotonic() - began:.1f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
