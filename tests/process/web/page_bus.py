"""LCM on the network without LCM: what a test sends and hears, as bytes."""
import os
import re
import socket
import struct
import threading
import time

# Where the programs speak: isolated.sh gives a port of its own where it cannot give a network.
GROUP, PORT = "239.255.76.67", int(re.search(r":(\d+)|$", os.environ.get("LCM_DEFAULT_URL", "").rpartition("//")[2])[1] or 7667)


class Bus:
    """Hears all whole messages; `last` by channel, `heard` in order. `bytes` are those of all datagrams."""

    def __init__(self):
        self.link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        self.link.bind(("", PORT))
        # On the interface of the route, as LCM.
        self.link.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0"))
        self.link.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        self.last, self.heard, self.number, self.bytes = {}, [], 0, bytearray()
        self.thread = threading.Thread(target=self.listen, daemon=True)
        self.thread.start()

    def listen(self):
        while True:
            data = self.link.recv(1 << 16)
            self.bytes += data
            if data[:4] != b"LC02":
                continue  # a fragment of a larger message
            name, _, payload = data[8:].partition(b"\0")
            self.last[name.decode()] = payload
            self.heard.append((time.time(), name.decode(), payload))

    def send(self, channel, payload):
        self.number += 1
        self.link.sendto(b"LC02" + struct.pack(">I", self.number) + channel.encode() + b"\0" + payload,
                         (GROUP, PORT))

    def wait(self, channel, seconds=5.0):
        """The channel's last message."""
        end = time.time() + seconds
        while channel not in self.last and time.time() < end:
            time.sleep(0.02)
        return self.last.get(channel)

    def of(self, channel):
        return [payload for _, name, payload in self.heard if name == channel]


def text(value):
    data = value.encode() if isinstance(value, str) else value
    return struct.pack(">i", len(data) + 1) + data + b"\0"


def process_status(fingerprint, process, state):
    """marco.process_status_t of now."""
    return (fingerprint + struct.pack(">q", int(time.time() * 1e6)) + text(process) +
            struct.pack(">qqi", 1, 1, 0) + struct.pack(">dd", 0, 0) + text(state))


def base_command(payload):
    """kind, velocity, yaw rate, x, y of a marco.base_command_t."""
    kind = payload[24]
    numbers = struct.unpack(">9d", payload[25:25 + 72])
    return {"kind": kind, "velocity": numbers[2], "yaw_rate": numbers[3], "x": numbers[4], "y": numbers[5]}
