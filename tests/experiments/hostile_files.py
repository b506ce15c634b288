#!/usr/bin/env python3
"""What hostile files cost, beside plain ones of the same drive: CPU seconds, peak memory, exit code and the last words.

usage: hostile_files.py BIN [--only WORD ...] [--keep FOLDER] [--seconds 120] [--megabytes 12000]

A file may take 20 times the CPU, and twice the memory and 200 MB, of a plain file with as many bytes as it unpacks to.
The plain file of each row is named; most unpack to more, so that a row within its bounds is within the promise.
BIN holds the programs. Everything is made in the folder, and is at most 2 GB there; sparse files say more.
"""
import argparse
import bz2
import gzip
import itertools
import math
import os
import random
import resource
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import tempfile
import time

SCANS, BEAMS, STEP_S = 600, 180, 0.2
WALLS = [(-5, -4, 5, -4), (5, -4, 5, 4), (5, 4, -5, 4), (-5, 4, -5, -4), (-5, 1, -2, 1), (1, 4, 1, 1.5), (2, -4, 2, -2.5)]
START_S = 1_000_000_000.0


def range_to(x, y, angle):
    c, s, nearest = math.cos(angle), math.sin(angle), 80.0
    for x1, y1, x2, y2 in WALLS:
        dx, dy = x2 - x1, y2 - y1
        across = c * dy - s * dx
        if abs(across) < 1e-9:
            continue
        ahead, along = ((x1 - x) * dy - (y1 - y) * dx) / across, ((x1 - x) * s - (y1 - y) * c) / across
        if 0.05 < ahead < nearest and 0 <= along <= 1:
            nearest = ahead
    return nearest


def drive(scans=SCANS, beams=BEAMS):
    """(t, x, y, theta, ranges) along an ellipse through the room, twice."""
    draw = random.Random(1)
    for i in range(scans):
        phase = 4 * math.pi * i / scans
        x, y, theta = 3 * math.cos(phase), -1 + 1.8 * math.sin(phase), math.atan2(1.8 * math.cos(phase), -3 * math.sin(phase))
        bearings = [theta - math.pi / 2 + math.pi * k / beams for k in range(beams)]
        yield START_S + STEP_S * i, x, y, theta, [range_to(x, y, b) + draw.gauss(0, 0.01) for b in bearings]


DRIVE = list(drive())


# CARMEN, and by `marco log import` LCM.
def carmen_line(i, t, x, y, theta, ranges, count=None):
    pose = "%.4f %.4f %.5f" % (x, y, theta)
    return "FLASER %d %s %s %s %.3f host %.3f" % (count or len(ranges), " ".join("%.2f" % r for r in ranges), pose, pose, t, t)


def carmen(path, change=lambda i, *scan: scan, **more):
    with open(path, "w") as file:
        for i, scan in enumerate(DRIVE):
            file.write(carmen_line(i, *change(i, *scan), **more) + "\n")


def events(path):
    data, at = open(path, "rb").read(), 0
    while at < len(data):
        _, number, utime, name, size = struct.unpack_from(">Iqqii", data, at)
        yield number, utime, data[at + 28:at + 28 + name], data[at + 28 + name:at + 28 + name + size]
        at += 28 + name + size


def lcm(path, change):
    if not os.path.exists("source.lcm"):
        carmen("source.log")
        subprocess.run([os.path.join(arguments.bin, "marco-log"), "import", "source.log", "source.lcm"], check=True, capture_output=True)
    with open(path, "wb") as file:
        for i, event in enumerate(events("source.lcm")):
            for number, utime, name, data in change(i, *event):
                file.write(struct.pack(">Iqqii", 0xEDA1DA01, number, utime, len(name), len(data)) + name + data)


def sweeps(path, change):
    """Fifty seconds of a simulated tour, with twelve sweeps of a tilted laser."""
    if not os.path.exists("tour.lcm"):
        root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
        subprocess.run([os.path.join(arguments.bin, "marco-simulate"), "--world", f"{root}/config/worlds/lab.toml", "--tour",
                        f"{root}/config/tours/lab.toml", "--seed", "1", "--out", "tour.lcm"], check=True, capture_output=True)
    with open(path, "wb") as file:
        for event in itertools.islice(events("tour.lcm"), 9000):
            for number, utime, name, data in change(*event):
                file.write(struct.pack(">Iqqii", 0xEDA1DA01, number, utime, len(name), len(data)) + name + data)


def lidar(i, number, utime, name, data, change):
    """change(utime, ranges, rad0, radstep) of bot_core.planar_lidar_t"""
    if name != b"LIDAR":
        return [(number, utime, name, data)]
    stamp, count = struct.unpack_from(">qi", data, 8)
    ranges = struct.unpack_from(">%df" % count, data, 20)
    stamp, ranges, rad0, radstep = change(i, stamp, ranges, *struct.unpack(">2f", data[-8:]))
    data = data[:8] + struct.pack(">qi%dfi2f" % len(ranges), stamp, len(ranges), *ranges, 0, rad0, radstep)
    return [(number, utime, name, data)]


def sensor_info(number, utime, name, data, at, *values):
    """Doubles of marco.sensor_info_t from the one of index `at` on: 0 place, 3 quaternion, 10 duration, 11 range_min ..."""
    if name == b"SENSOR_INFO":
        data = bytearray(data)
        first = 8 + 8 + 4 + struct.unpack_from(">i", data, 16)[0] + 1
        struct.pack_into(">%dd" % len(values), data, first + 8 * at, *values)
    return [(number, utime, name, bytes(data))]


# ROS
def text(value):
    return struct.pack("<I", len(value)) + value


def header_cdr(t, frame):
    return struct.pack("<iI", int(t), int(t % 1 * 1e9)) + text(frame + b"\0")


def aligned(data, to):
    return data + b"\0" * (-(len(data) - 4) % to)


def scan_cdr(t, ranges):
    data = aligned(b"\0\1\0\0" + header_cdr(t, b"base_link"), 4)
    data += struct.pack("<7f", -math.pi / 2, math.pi / 2, math.pi / BEAMS, 0, STEP_S, 0.05, 30)
    return data + struct.pack("<I%dfI" % len(ranges), len(ranges), *ranges, 0)


def odometry_cdr(t, x, y, theta):
    data = aligned(aligned(b"\0\1\0\0" + header_cdr(t, b"odom"), 4) + text(b"base_link\0"), 8)
    return data + struct.pack("<7d", x, y, 0, 0, 0, math.sin(theta / 2), math.cos(theta / 2)) + bytes(8 * (36 + 6 + 36))


def record(op, content):
    return struct.pack("<BQ", op, len(content)) + content


def zeros_record(op, count):
    return struct.pack("<BQ", op, count), count


def channel(number, name, schema):
    return record(4, struct.pack("<HH", number, schema) + text(name) + text(b"cdr") + text(b""))


TYPES = record(3, struct.pack("<H", 1) + text(b"sensor_msgs/msg/LaserScan") + text(b"ros2msg") + text(b"x" * 1500))
TYPES += record(3, struct.pack("<H", 2) + text(b"nav_msgs/msg/Odometry") + text(b"ros2msg") + text(b"x" * 1500))
TYPES += channel(1, b"/scan", 1) + channel(2, b"/odom", 2)


def message(number, t, data):
    return record(5, struct.pack("<HIQQ", number, 0, int(t * 1e9), int(t * 1e9)) + data)


def messages():
    for t, x, y, theta, ranges in DRIVE:
        yield message(2, t, odometry_cdr(t, x, y, theta)) + message(1, t + 0.001, scan_cdr(t + 0.001, ranges))


def zstd(parts):
    """A frame of raw blocks, and of repeated zeros where a part is a number: 4 bytes for 128 kB."""
    blocks = []
    for part in parts:
        size = part if isinstance(part, int) else len(part)
        for at in range(0, size, 1 << 17):
            some = min(1 << 17, size - at)
            blocks.append((some, 1, b"\0") if isinstance(part, int) else (some, 0, part[at:at + some]))
    out = [struct.pack("<IBB", 0xFD2FB528, 0, 0x70)]  # a window of 16 MB
    for i, (size, kind, data) in enumerate(blocks):
        out.append(struct.pack("<I", (i + 1 == len(blocks)) | kind << 1 | size << 3)[:3] + data)
    return b"".join(out)


def chunk(parts, first, last, packed=True):
    size = sum(part if isinstance(part, int) else len(part) for part in parts)
    data = zstd(parts) if packed else b"".join(parts)
    head = struct.pack("<QQQI", int(first * 1e9), int(last * 1e9), size, 0) + text(b"zstd" if packed else b"")
    return record(6, head + struct.pack("<Q", len(data)) + data)


MAGIC = b"\x89MCAP0\r\n"
ENDS = DRIVE[0][0], DRIVE[-1][0] + 1


def mcap(path, chunks):
    with open(path, "wb") as file:
        file.write(MAGIC + record(1, text(b"ros2") + text(b"marco")))
        for data in chunks:
            file.write(data)
        file.write(record(15, struct.pack("<I", 0)) + record(2, bytes(20)) + MAGIC)


def interleaved(count, *padding):
    """Chunk i holds each `count`th message: all overlap."""
    all_messages = list(messages())
    for i in range(count):
        yield chunk([TYPES + b"".join(all_messages[i::count]), *padding], *ENDS)


def bag_record(data, **fields):
    head = b"".join(text(name.encode() + b"=" + value) for name, value in fields.items())
    return text(head) + text(data)


def bag(path, chunks):
    with open(path, "wb") as file:
        file.write(b"#ROSBAG V2.0\n" + bag_record(b" " * 4027, op=b"\3", index_pos=bytes(8), conn_count=bytes(4), chunk_count=bytes(4)))
        for data in chunks:
            file.write(data)


def bag_chunk(plain, compression=b"bz2", packed=None):
    packed = bz2.compress(plain) if packed is None else packed
    return bag_record(packed, op=b"\5", compression=compression, size=struct.pack("<I", len(plain)))


def bag_time(t):
    return struct.pack("<II", int(t), int(t % 1 * 1e9))


def bag_messages():
    connection = b"".join(text(field) for field in (b"topic=/scan", b"type=sensor_msgs/LaserScan", b"md5sum=90c7ef2dc6895d81024acba2ac42f369",
                                                    b"message_definition=x"))
    yield bag_record(connection, op=b"\7", conn=struct.pack("<I", 0), topic=b"/scan")
    for t, _, _, _, ranges in DRIVE:
        data = struct.pack("<IiI", 0, int(t), int(t % 1 * 1e9)) + text(b"base_link")
        data += struct.pack("<7fI%dfI" % len(ranges), -math.pi / 2, math.pi / 2, math.pi / BEAMS, 0, STEP_S, 0.05, 30, len(ranges), *ranges, 0)
        yield bag_record(data, op=b"\2", conn=struct.pack("<I", 0), time=bag_time(t))


def db3(path, schema="", rows=(), messages_table="CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)"):
    with sqlite3.connect(path) as base:
        base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, offered_qos_profiles TEXT)")
        base.execute("INSERT INTO topics VALUES(1, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr', '')")
        base.execute(messages_table)
        for statement in filter(None, schema.split(";")):
            base.execute(statement)
        for i, (t, data) in enumerate(rows):
            base.execute("INSERT INTO messages VALUES(NULL, 1, ?, ?)", (int(t * 1e9), data))


def sparse(path, head, size):
    with open(path, "wb") as file:
        file.write(head)
        file.truncate(size)


def folder_of(name):
    os.makedirs(name, exist_ok=True)
    return lambda file: os.path.join(name, file)


CASES = []


def case(name, make, plain="", command=("marco-map", "{}", "--out", "{out}")):
    CASES.append((name, make, plain, command))


def write(content):
    def make(path):
        with open(path, "wb") as file:
            file.write(content() if callable(content) else content)
    return make


# Recordings of ROS
def plain_mcap(path):
    mcap(path, [chunk([TYPES + b"".join(messages())], *ENDS)])


case("plain.mcap", plain_mcap)
def plain_chunk(path, parts):
    """An MCAP file of one chunk that is not packed: numbers are holes."""
    size = sum(part if isinstance(part, int) else len(part) for part in parts)
    with open(path, "wb") as file:
        file.write(MAGIC + record(1, text(b"ros2") + text(b"marco")) + struct.pack("<BQ", 6, 40 + size))
        file.write(struct.pack("<QQQI", int(ENDS[0] * 1e9), int(ENDS[1] * 1e9), size, 0) + text(b"") + struct.pack("<Q", size))
        for part in parts:
            file.seek(part, 1) if isinstance(part, int) else file.write(part)
        file.write(record(15, struct.pack("<I", 0)) + record(2, bytes(20)) + MAGIC)


case("plain_10GB.mcap", lambda path: plain_chunk(path, [TYPES + b"".join(messages()), *zeros_record(0x80, 10 << 30)]))
case("plain_6GB.mcap", lambda path: plain_chunk(path, [TYPES + b"".join(messages())] + [
    struct.pack("<BQHIQQ", 5, 22 + (100 << 20), 1, 0, int(1e9 * START_S), 0), 100 << 20] * 60))
case("bomb_40.mcap", lambda path: mcap(path, interleaved(40, *zeros_record(0x80, 250 << 20))), "plain_10GB.mcap")
case("bomb_1.mcap", lambda path: mcap(path, interleaved(1, *zeros_record(0x80, 250 << 20))), "plain.mcap")
case("interleaved_40.mcap", lambda path: mcap(path, interleaved(40)), "plain.mcap")
case("interleaved_400.mcap", lambda path: mcap(path, interleaved(400)), "plain.mcap")
case("messages_100MB.mcap", lambda path: mcap(path, [chunk([TYPES + b"".join(messages())], *ENDS)] + [
    chunk([struct.pack("<BQHIQQ", 5, 22 + (100 << 20), 1, 0, int(1e9 * START_S), 0), 100 << 20], *ENDS)] * 60), "plain_6GB.mcap")
def parts(path):
    in_folder = folder_of(path)
    all_messages = list(messages())
    for i in range(20):
        begin_s = START_S + 30 * STEP_S * i
        large = struct.pack("<BQHIQQ", 5, 22 + (250 << 20), 1, 0, int(1e9 * begin_s), 0), 250 << 20
        plain = TYPES + b"".join(all_messages[60 * i:60 * i + 60])
        mcap(in_folder("a_%d.mcap" % i), [chunk([plain, *large], begin_s, begin_s + 29.5 * STEP_S)])


case("parts_20", parts, "plain_6GB.mcap")
case("message_4GB.mcap", lambda path: mcap(path, [chunk([TYPES + b"".join(messages()), struct.pack("<BQHIQQ", 5, 22 + (4 << 30), 1, 0, int(1e9 * START_S), 0), 4 << 30], *ENDS)]), "plain.mcap")
case("channels_65k.mcap", lambda path: mcap(path, [chunk([TYPES + b"".join(channel(i, b"/t%d" % i, 1) for i in range(10, 65535)) + b"".join(messages())], *ENDS)]), "plain.mcap")
case("schemas_4MB.mcap", lambda path: mcap(path, [chunk([TYPES + b"".join(messages())], *ENDS)] + [
    chunk([struct.pack("<BQHI", 3, 2 + 12 + (4 << 20), i, 0) + text(b"") + struct.pack("<I", 4 << 20), 4 << 20], *ENDS) for i in range(10, 1000)]), "plain.mcap")
case("chunks_4M.mcap", lambda path: mcap(path, [chunk([TYPES + b"".join(messages())], *ENDS)] + [chunk([b""], 0, 0, False) * 1000] * 4000), "plain.mcap")
case("metadata_3M.mcap", lambda path: mcap(path, [chunk([TYPES + b"".join(messages())], *ENDS)] + [
    b"".join(record(12, text(b"%d" % (1000 * k + i)) + text(b"")) for i in range(1000)) for k in range(3000)]), "plain.mcap")
case("claims_10_bytes.mcap", lambda path: sparse(path, MAGIC + record(1, text(b"") * 2) + chunk([TYPES + b"".join(messages())], *ENDS) + struct.pack(
    "<BQQQQI", 6, 40 + (20 << 30), 0, 10**18, 10, 0) + text(b"") + struct.pack("<Q", 20 << 30), (20 << 30) + 2000000), "plain_10GB.mcap")
case("zeros.mcap.zstd", write(lambda: zstd([MAGIC, 20 << 30])), "plain_10GB.mcap")
case("plain.bag", lambda path: bag(path, [bag_chunk(b"".join(bag_messages()))]))
def wide_bag(path, compression, pack):
    all_messages = list(bag_messages())
    plain = (b"".join(all_messages[:1] + all_messages[1 + i::16]) + bag_record(bytes(100 << 20), op=b"\4", conn=bytes(4)) for i in range(16))
    bag(path, (bag_chunk(data, compression, pack(data)) for data in plain))


case("plain_1.6GB.bag", lambda path: wide_bag(path, b"none", bytes))
case("bomb_16_bz2.bag", lambda path: wide_bag(path, b"bz2", bz2.compress), "plain_1.6GB.bag")
case("chunks_1M.bag", lambda path: bag(path, [bag_chunk(b"".join(bag_messages()))] + [bag_chunk(b"", b"none", b"x") * 1000] * 1000), "plain.bag")
case("plain.db3", lambda path: db3(path, rows=[(t, scan_cdr(t, ranges)) for t, _, _, _, ranges in DRIVE]))
case("blobs_300MB.db3", lambda path: db3(path, rows=[(t, scan_cdr(t, ranges)) for t, _, _, _, ranges in DRIVE] + [(START_S, bytes(300 << 20))] * 2), "plain.db3")
case("view.db3", lambda path: db3(path, messages_table="CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
                                  "SELECT i AS id, 1 AS topic_id, i AS timestamp, zeroblob(100000000) AS data FROM n"), "plain.db3")
case("generated.db3", lambda path: db3(path, "INSERT INTO messages(topic_id, timestamp) " + " UNION ALL ".join(["SELECT 1, 1"] * 400),
                                       messages_table="CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB AS (zeroblob(900000000)))"), "plain.db3")

# CARMEN
DRAW = random.Random(2)
case("plain.log", carmen)
case("all_far.log", lambda path: carmen(path, lambda i, t, x, y, theta, ranges: (t, x, y, theta, [DRAW.uniform(20, 79.9) for _ in ranges])), "plain.log")
case("noise_60.log", lambda path: carmen(path, lambda i, t, x, y, theta, ranges: (t, x, y, theta, [DRAW.uniform(0.3, 79.9) if DRAW.random() < 0.6 else r for r in ranges])), "plain.log")
case("equal_stamps.log", lambda path: carmen(path, lambda i, t, *scan: (START_S, *scan)), "plain.log")
case("scan_a_year.log", lambda path: carmen(path, lambda i, t, *scan: (START_S + 3.15e7 * i, *scan)), "plain.log")
case("leaps.log", lambda path: carmen(path, lambda i, t, x, y, theta, ranges: (t, 1e6 * i, -1e6 * i, 1e3 * i, ranges)), "plain.log")
case("beams_1M.log", write(lambda: "\n".join(carmen_line(i, *scan[:4], scan[4] * 5556) for i, scan in enumerate(DRIVE[:20])).encode()), "plain.log")
case("one_line.log", write(lambda: b"FLASER 180 " + b"1.0 " * 30_000_000), "plain.log")
case("params.log", write(lambda: b"PARAM robot_frontlaser_offset 1e9\nPARAM laser_front_laser_resolution 1e-300\nPARAM robot_front_laser_max 1e308\n" + open("plain.log", "rb").read()), "plain.log")

# LCM
case("plain.lcm", lambda path: lcm(path, lambda i, *event: [event]))
for value in ("1e30", "1e-38", "nan"):
    case("radstep_%s.lcm" % value, lambda path, value=value: lcm(path, lambda i, *event: lidar(i, *event, lambda i, stamp, ranges, rad0, step: (stamp, ranges, rad0, float(value)))), "plain.lcm")
case("mount_9m.lcm", lambda path: lcm(path, lambda i, *event: sensor_info(*event, 0, 9, 9, 9)), "plain.lcm")
case("mount_100km.lcm", lambda path: lcm(path, lambda i, *event: sensor_info(*event, 0, 1e5, 1e5, 0)), "plain.lcm")
case("mount_nan.lcm", lambda path: lcm(path, lambda i, *event: sensor_info(*event, 0, *[math.nan] * 3)), "plain.lcm")
case("sweeps.lcm", lambda path: sweeps(path, lambda *event: [event]))
case("sweeps_9m.lcm", lambda path: sweeps(path, lambda *event: sensor_info(*event, 0, 9, 9, 9)), "sweeps.lcm")
case("quaternion_0.lcm", lambda path: lcm(path, lambda i, *event: sensor_info(*event, 3, 0, 0, 0, 0)), "plain.lcm")
case("range_0.lcm", lambda path: lcm(path, lambda i, *event: sensor_info(*event, 12, 0)), "plain.lcm")
case("stamps_int64.lcm", lambda path: lcm(path, lambda i, *event: lidar(i, *event, lambda i, stamp, *scan: ((2**63 - 1) * (-1)**i, *scan))), "plain.lcm")
case("stamps_equal.lcm", lambda path: lcm(path, lambda i, *event: [(event[0], 0, event[2], event[3][:8] + bytes(8) + event[3][16:])]), "plain.lcm")
case("events_equal.lcm", lambda path: lcm(path, lambda i, number, utime, *event: [(number, 0, *event)]), "plain.lcm")
case("beams_1M.lcm", lambda path: lcm(path, lambda i, *event: lidar(i, *event, lambda i, stamp, ranges, *step: (stamp, ranges * 5556, *step)) if i < 60 else []), "plain.lcm")
case("lidars_60k.lcm", lambda path: lcm(path, lambda i, number, utime, name, data: [(number, utime, name, data)] + (
    [(number, utime, b"LIDAR_%d" % (100 * i + k), data) for k in range(40)] if name == b"LIDAR" else [])), "plain.lcm")
case("infos_60k.lcm", lambda path: lcm(path, lambda i, number, utime, name, data: [(number, utime, name, data)] + (
    [(number, utime, name, data[:16] + struct.pack(">i", 13) + b"LIDAR_%06d\0" % k + data[26:]) for k in range(60000)] if i == 0 else [])), "plain.lcm")

# Sparse, pipes
for ending, head in ((".bag", b"#ROSBAG V2.0\n"), (".mcap", MAGIC), (".lcm", b"\xED\xA1\xDA\x01"), (".log", b"FLASER 180 1\n")):
    case("sparse_1TB" + ending, lambda path, head=head: sparse(path, head, 1 << 40), "plain" + ending)
for ending in (".bag", ".log", ".toml"):
    case("pipe" + ending, os.mkfifo, "plain.log", ("marco-map", "{}", "--out", "{out}") if ending != ".toml" else ("marco-map", "plain.log", "--config", "{}", "--out", "{out}"))
for ending in (".ply", ".pcd", ".obj"):
    case("pipe" + ending, os.mkfifo, "plain.log", ("marco-model", "{}", "--out", "{out}"))
case("pipe.lcm", os.mkfifo, "plain.lcm", ("marco-log", "info", "{}"))

# TOML
CONFIG = ("marco-map", "plain.log", "--config", "{}", "--check")
case("plain.toml", write(b""), "", CONFIG)
case("dots.toml", write(b".".join([b"a"] * 50000) + b"=1\n"), "plain.toml", CONFIG)
case("header.toml", write(b"[" + b".".join([b"a"] * 50000) + b"]\n"), "plain.toml", CONFIG)
case("nested.toml", write(b"a=" + b"[" * 200 + b"{a.a.a.a.a.a.a.a.a=" * 50 + b"1" + b"}" * 50 + b"]" * 200 + b"\n"), "plain.toml", CONFIG)
case("arrays.toml", write(lambda: b"a=[" + b"1," * 20_000_000 + b"]\n"), "plain.toml", CONFIG)
case("keys.toml", write(lambda: b"".join(b"a%d.b=1\n" % i for i in range(1_000_000))), "plain.toml", CONFIG)


def made_elsewhere(make, name):
    """By a child: what this process holds would count as that of the programs it starts."""
    child = os.fork()
    if child == 0:
        make(name)
        os._exit(0)
    if os.waitpid(child, 0)[1] != 0:
        sys.exit(name + ": cannot be created")


def measure(command, seconds, megabytes):
    def limit():
        os.setsid()
        resource.setrlimit(resource.RLIMIT_AS, (megabytes << 20,) * 2)
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 2))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.nice(10)

    with tempfile.TemporaryFile() as words:
        process = subprocess.Popen(command, preexec_fn=limit, stdin=subprocess.DEVNULL, stdout=words, stderr=subprocess.STDOUT)
        end = time.monotonic() + (20 if "pipe" in " ".join(command) else 4 * seconds)
        while True:
            pid, status, used = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > end:
                os.killpg(process.pid, signal.SIGKILL)
            time.sleep(0.02)
        process.returncode = os.waitstatus_to_exitcode(status)
        words.seek(max(0, words.seek(0, 2) - 2000))
        lines = words.read().decode(errors="replace").strip().splitlines()
        return process.returncode, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, " | ".join(line[:200] for line in lines[-2:])


def main():
    plain_cost = {}
    print("%-22s %5s %7s %6s | %7s %6s |" % ("file", "exit", "CPU s", "MB", "plain s", "MB"))
    for name, make, plain, command in CASES:
        is_wanted = not arguments.only or any(word in name for word in arguments.only)
        is_plain = not plain or any(other[2] == name for other in CASES)
        if not is_wanted and not (is_plain and any(word in other[0] for word in arguments.only for other in CASES if other[2] == name)):
            continue
        if not os.path.exists(name):
            made_elsewhere(make, name)
        words = [word.replace("{}", name).replace("{out}", "out") for word in command]
        words[0] = os.path.join(arguments.bin, words[0])
        code, cpu_s, mb, said = measure(words, arguments.seconds, arguments.megabytes)
        plain_cost[name] = cpu_s, mb
        beside = "%7.2f %6.0f" % plain_cost[plain] if plain in plain_cost else " " * 14
        over = plain in plain_cost and (cpu_s > 20 * plain_cost[plain][0] + 1 or mb > 2 * plain_cost[plain][1] + 200)
        print("%-22s %5d %7.2f %6.0f | %s | %s%s" % (name, code, cpu_s, mb, beside, "OVER " if over else "", said[:300]), flush=True)
        shutil.rmtree("out", ignore_errors=True)
        if plain:
            shutil.rmtree(name) if os.path.isdir(name) else os.remove(name)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("bin", type=os.path.abspath)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--keep")
    parser.add_argument("--seconds", type=int, default=120)
    parser.add_argument("--megabytes", type=int, default=12000)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="marco_hostile_") as temporary:
        if arguments.keep:
            os.makedirs(arguments.keep, exist_ok=True)
        os.chdir(arguments.keep or temporary)
        main()
