#!/usr/bin/env python3
"""What marco-page costs, and how late a browser sees: on a simulated network of one host, lasers at 75 Hz, and a map of
100 m x 100 m of which a part changes every five seconds.
usage: page.py BIN ROOT [--seconds 60] [--clients 1] [--stalled 0] [--hz 75] [--beams 1080] [--connections 0]     (inside lcm_tools/tests/support/isolated.sh)
--connections: that many idle connections are opened at once.
Prints latency from LCM's message to the client's socket, CPU of the server in percent of a core, and its memory over time."""
import argparse
import math
import multiprocessing
import os
import re
import resource
import socket
import struct
import subprocess
import sys
import time

parser = argparse.ArgumentParser()
parser.add_argument("bin")
parser.add_argument("root")
parser.add_argument("--seconds", type=float, default=60)
parser.add_argument("--clients", type=int, default=1)
parser.add_argument("--stalled", type=int, default=0)
parser.add_argument("--hz", type=float, default=75)
parser.add_argument("--beams", type=int, default=1080)
parser.add_argument("--connections", type=int, default=0)
arguments = parser.parse_args()
sys.path.insert(0, os.path.join(arguments.root, "tests/process/web"))
from page_client import Client

GROUP, PORT = "239.255.76.67", 7667
TOPICS = ("page/scan", "page/tiles", "page/health", "page/commands", "page/output", "page/stop", "/pose", "/path", "LIDAR")


def fingerprint(path):
    """Of a type of primitives, as lcm-gen computes it from its source."""
    with open(os.path.join(arguments.root, path)) as source:
        text = re.sub(r"//.*|const [^;]*;", "", source.read())
    fields = re.findall(r"(\w+)\s+(\w+)((?:\[\w+\])*)\s*;", text[text.index("{"):])
    value = 0x12345678

    def add(number):
        nonlocal value
        value = ((value << 8) ^ (value >> 55)) + number
        value = (value + 2**63) % 2**64 - 2**63

    def add_text(word):
        for number in (len(word), *word.encode()):
            add(number)

    for kind, name, dimensions in fields:
        add_text(name)
        add_text(kind)
        sizes = re.findall(r"\w+", dimensions)
        add(len(sizes))
        for size in sizes:
            add(0 if size.isdigit() else 1)
            add_text(size)
    return struct.pack(">Q", (value << 1) % 2**64 + (value >> 63 & 1))


class Sender:
    def __init__(self):
        self.link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.link.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        self.link.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        self.number = 0

    def send(self, channel, payload):
        self.number += 1
        head = channel.encode() + b"\0"
        if len(payload) < 60000:
            self.link.sendto(b"LC02" + struct.pack(">I", self.number) + head + payload, (GROUP, PORT))
            return
        pieces = [payload[at:at + 60000] for at in range(0, len(payload), 60000)]
        at = 0
        for i, piece in enumerate(pieces):
            self.link.sendto(b"LC03" + struct.pack(">IIIHH", self.number, len(payload), at, i, len(pieces)) +
                             (head if i == 0 else b"") + piece, (GROUP, PORT))
            at += len(piece)


def publish(until, prints):
    """A robot that turns in a large hall."""
    sender = Sender()
    lidar, pose, odometry, grid = (prints[name] for name in ("planar_lidar_t", "slam_pose_t", "odometry_t", "grid_map_t"))
    tiles = {(x, y): bytearray(os.urandom(64)) * 1024 for x in range(8) for y in range(8)}
    for tile in tiles.values():  # as a map: large areas of one value, walls and some noise
        for at in range(len(tile)):
            tile[at] = 0 if tile[at % 64] < 200 else 100 if tile[at % 64] < 230 else 255
    number, revision, next_map = 0, 0, time.time() + 1
    begun = time.time()
    while time.time() < until:
        due = begun + number / arguments.hz
        time.sleep(max(0, due - time.time()))
        theta = 0.3 * (time.time() - begun)
        ranges = [8 + 3 * math.sin(0.05 * i + theta) for i in range(arguments.beams)]
        utime = int(time.time() * 1e6)
        sender.send("LIDAR", lidar + struct.pack(f">qi{arguments.beams}fiff", utime, arguments.beams, *ranges, 0,
                                                 -math.pi, 2 * math.pi / arguments.beams))
        sender.send("ODOMETRY", odometry + struct.pack(">q5dqq", utime, 0, 0, theta, 0, 0.3, 0, 0))
        sender.send("SLAM_POSE", pose + struct.pack(">q3d9dbd", utime, 0, 0, theta % (2 * math.pi) - math.pi,
                                                    *[0.0] * 9, 0, 1.0))
        number += 1
        if time.time() >= next_map:
            next_map += 5
            revision += 1
            for place in ((revision % 8, 3), (3, revision % 8), (4, 4)):
                tiles[place][revision * 300:revision * 300 + 200] = os.urandom(200)
            for (x, y), tile in tiles.items():
                sender.send("GRID_MAP", grid + struct.pack(">qq3diii", utime, revision, x * 12.8 - 51.2, y * 12.8 - 51.2,
                                                           0.05, 256, 256, 65536) + bytes(tile))


def look(until, results):
    """Latencies of the messages that carry their stamp [ms], and how many came, by topic."""
    client = Client(8765)
    client.subscribe(*(topic for topic in TOPICS if "/" in topic))
    late, counts, last_tiles = {"LIDAR": [], "/pose": [], "page/scan": []}, {}, 0
    while time.time() < until and client.step(0.05):
        if "LIDAR" in client.channels and "LIDAR" not in client.topic_of.values():
            client.subscribe("LIDAR")
        for topic, stamp, payload, at in client.messages:
            counts[topic] = counts.get(topic, 0) + 1
            if topic in ("LIDAR", "page/scan"):
                begin = payload.index(b'"utime":') + 8
                stamp = 1000 * int(payload[begin:begin + 16])
            if topic in late:
                late[topic].append(1e3 * at - stamp / 1e6)
            if topic == "page/tiles":
                last_tiles += len(payload)
        client.messages.clear()
    results.put((late, counts, last_tiles, client.is_closed))


def flood(until, count):
    """Connections as fast as they are taken, all at once; what is refused is not tried again."""
    resource.setrlimit(resource.RLIMIT_NOFILE, (count + 100, count + 100))
    links, begun, refused = [], time.time(), 0
    for _ in range(count):
        try:
            links.append(socket.create_connection(("127.0.0.1", 8765), timeout=5))
        except OSError:
            refused += 1
    print(f"{count} connections within {time.time() - begun:.1f} s, {refused} refused at once", flush=True)
    time.sleep(max(0.0, until - time.time()))


def memory_kb(process):
    with open(f"/proc/{process.pid}/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def cpu_s(process):
    with open(f"/proc/{process.pid}/stat") as stat:
        fields = stat.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


prints = {name: fingerprint(f"{folder}/{name}.lcm") for folder, name in
          (("lcm_tools/lcmtypes/bot_core", "planar_lidar_t"), ("lcmtypes/marco", "slam_pose_t"),
           ("lcmtypes/marco", "odometry_t"), ("lcmtypes/marco", "grid_map_t"))}
page = subprocess.Popen([os.path.join(arguments.bin, "marco-page")], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
page.stdout.readline()
until = time.time() + arguments.seconds + 2
robot = multiprocessing.Process(target=publish, args=(until, prints))
robot.start()
results = multiprocessing.Queue()
lookers = [multiprocessing.Process(target=look, args=(until, results)) for _ in range(arguments.clients)]
for looker in lookers:
    looker.start()
stalled = []
for _ in range(arguments.stalled):
    client = Client(8765, reads=False)
    client.wait(lambda: "page/scan" in client.channels and "LIDAR" in client.channels)
    client.subscribe(*TOPICS, "/map", "GRID_MAP")
    stalled.append(client)
time.sleep(2)
flooder = multiprocessing.Process(target=flood, args=(until, arguments.connections))
if arguments.connections:
    flooder.start()
begun, before = time.time(), cpu_s(page)
memory = []
while time.time() < until - 0.5:
    memory.append((time.time() - begun, memory_kb(page)))
    time.sleep(min(max(0.1, until - 0.5 - time.time()), max(1.0, arguments.seconds / 12)))
share = 100 * (cpu_s(page) - before) / (time.time() - begun)
for number in range(arguments.clients):
    late, counts, tile_bytes, is_closed = results.get()
    for topic, values in late.items():
        values.sort()
        part = lambda share_: values[min(len(values) - 1, int(share_ * len(values)))] if values else float("nan")
        print(f"client {number}: {topic}: {len(values)} messages; latency {part(0.5):.1f} ms in the median, "
              f"{part(0.99):.1f} ms in 99 of 100, {part(1.0):.1f} ms at most")
    print(f"client {number}: {counts.get('page/tiles', 0)} messages of tiles, {tile_bytes / 1e6:.2f} MB"
          f"{'; let go' if is_closed else ''}")
print(f"server: {share:.1f} % of a core; memory " +
      ", ".join(f"{kb / 1024:.1f} MB at {at:.0f} s" for at, kb in memory))
for process in (*lookers, robot, *([flooder] if arguments.connections else [])):
    process.join()
page.terminate()
page.wait()
