"""As much of LCM's UDP wire as the soak needs: hear messages, send any bytes, relay datagrams with losses."""
import random
import socket
import struct
import threading
import time

GROUP = "239.255.76.67"


def listener(port):
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
    sock.bind((GROUP, port))
    member = struct.pack("4s4s", socket.inet_aton(GROUP), socket.inet_aton("127.0.0.1"))
    sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
    sock.settimeout(0.2)
    return sock


def sender():
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
    return sock


def datagrams(channel, data, sequence):
    """A message as LCM sends it: in one datagram, or in fragments."""
    name = channel.encode() + b"\0"
    if len(name) + len(data) < 60000:
        return [struct.pack(">II", 0x4C433032, sequence) + name + data]
    whole, size, out = name + data, 60000, []
    count = (len(whole) + size - 1) // size
    for i in range(count):
        offset = i * size - (len(name) if i else 0)
        out.append(struct.pack(">IIIIHH", 0x4C433033, sequence, len(data), offset, i, count)
                   + whole[i * size:(i + 1) * size])
    return out


def events_of(path):
    """Channel and bytes of each whole event of a log."""
    with open(path, "rb") as log:
        while len(head := log.read(28)) == 28:
            sync, _, _, name_size, data_size = struct.unpack(">IqqII", head)
            name, data = log.read(name_size), log.read(data_size)
            if sync != 0xEDA1DA01 or len(data) != data_size:
                return
            yield name.decode(errors="replace"), data


class Ear(threading.Thread):
    """Hears poses and PROCESS_STATUS; counts messages by channel."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.sock, self.counts, self.poses, self.states, self.ended = listener(port), {}, {}, {}, False
        self.drops = {}
        self.start()

    def run(self):
        while not self.ended:
            try:
                data = self.sock.recv(65536)
            except socket.timeout:
                continue
            if data[:4] == b"LC03" and data[16:18] == b"\0\0":
                channel = data[20:].split(b"\0", 1)[0].decode(errors="replace")
                self.counts[channel] = self.counts.get(channel, 0) + 1
            if data[:4] != b"LC02":
                continue
            name, _, body = data[8:].partition(b"\0")
            channel = name.decode(errors="replace")
            self.counts[channel] = self.counts.get(channel, 0) + 1
            try:
                if channel in ("TRUE_POSE", "SLAM_POSE"):
                    self.poses[channel] = struct.unpack(">qddd", body[8:40])
                elif channel == "PROCESS_STATUS":
                    self.status(body[16:])
            except (struct.error, UnicodeDecodeError, IndexError):
                pass

    def status(self, body):
        def text(at):
            size = struct.unpack(">i", body[at:at + 4])[0]
            return body[at + 4:at + 3 + size].decode(), at + 4 + size

        process, at = text(0)
        count = struct.unpack(">i", body[at + 16:at + 20])[0]
        at += 20
        causes = []
        for _ in range(count):
            cause, at = text(at)
            causes.append(cause)
        self.drops[process] = dict(zip(causes, struct.unpack(f">{count}q", body[at:at + 8 * count])))
        state, _ = text(at + 8 * count + 16)
        self.states.setdefault(process, [])
        if not self.states[process] or self.states[process][-1] != state:
            self.states[process].append(state)


class Relay(threading.Thread):
    """Passes datagrams from one port's group to another's; loses and reorders some."""

    def __init__(self, source, target):
        super().__init__(daemon=True)
        self.sock, self.out, self.target = listener(source), sender(), (GROUP, target)
        self.loss, self.reordered, self.ended, self.random = 0.0, 0.0, False, random.Random(1)
        self.start()

    def run(self):
        held = None
        while not self.ended:
            try:
                data = self.sock.recv(65536)
            except socket.timeout:
                continue
            if self.random.random() < self.loss:
                continue
            if held is None and self.random.random() < self.reordered:
                held = data
                continue
            self.out.sendto(data, self.target)
            if held is not None:
                self.out.sendto(held, self.target)
                held = None


def flood(port, channel, data, per_s, seconds):
    sock, end, sequence = sender(), time.time() + seconds, 0
    sent = 0
    while time.time() < end:
        sequence += 1
        for datagram in datagrams(channel, data, sequence):
            try:
                sock.sendto(datagram, (GROUP, port))
            except OSError:
                pass
        sent += 1
        time.sleep(1.0 / per_s)
    return sent
