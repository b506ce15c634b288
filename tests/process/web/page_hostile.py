"""Three hundred clients without a token, each of one of ten kinds, for a minute and a half. usage: page_hostile.py PORT"""
import base64
import json
import os
import random
import socket
import struct
import sys
import time

PORT = int(sys.argv[1])
CHOICE = random.Random(1)


def frame(opcode, payload, final=True):
    size = len(payload)
    head = bytes([(0x80 if final else 0) | opcode])
    head += (bytes([0x80 | size]) if size < 126 else
             bytes([0x80 | 126]) + struct.pack(">H", size) if size < 65536 else
             bytes([0x80 | 127]) + struct.pack(">Q", size))
    return head + b"\0\0\0\0" + payload


def upgrade(path="/"):
    return (f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{PORT}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n").encode()


def subscribe(first, last):
    return frame(1, json.dumps({"op": "subscribe", "subscriptions": [
        {"id": i, "channelId": i} for i in range(first, last)]}).encode())


GET = f"GET /page/space.js HTTP/1.1\r\nHost: 127.0.0.1:{PORT}\r\n\r\n".encode()
# By kind: what is sent at first, then again and again, and whether it reads.
KINDS = [
    (b"", b"", False),                                                             # says nothing
    (b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: ", b"y", False),                    # never ends its request
    (GET * 20, GET * 20, False),                                                   # does not take the answers
    (upgrade(), b"", False),                                                       # holds a place
    (upgrade() + subscribe(1, 200), subscribe(1, 200), False),                     # subscribes and does not read
    (upgrade(), frame(1, b'{"op":"subscribe","subscriptions":' + b"[" * 30000), True),
    (upgrade(), frame(1, b'{"op":"subscribe","subscriptions":' + b"[" * 900000), True),
    (upgrade(), frame(9, b"x" * 125) * 40, True),                                  # pings
    (upgrade() + frame(1, b"{", False), frame(0, b"", False) * 500, True),         # a message without an end
    (upgrade(), subscribe(1, 100) + frame(1, json.dumps({"op": "unsubscribe", "subscriptionIds": list(
        range(1, 100))}).encode()), True),
    (upgrade("/?token=" + "k3jhd84hfkw92-_xQ7"), b"", True),                       # guesses
]


class Attacker:
    def __init__(self, number):
        self.first, self.again, self.reads = KINDS[number % len(KINDS)]
        self.link = None

    def step(self):
        if self.link is None:
            self.link = socket.socket()
            if not self.reads:
                self.link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            self.link.settimeout(1.0)
            self.link.connect(("127.0.0.1", PORT))
            self.link.setblocking(False)
            self.link.send(self.first)
        elif self.again:
            self.link.send(self.again)
        if self.reads and not self.link.recv(1 << 16):
            raise ConnectionError


attackers = [Attacker(i) for i in range(300)]
end = time.time() + 100
while time.time() < end:
    for one in CHOICE.sample(attackers, 30):
        try:
            one.step()
        except BlockingIOError:
            pass
        except OSError:
            if one.link:
                one.link.close()
            one.link = None
    time.sleep(0.005)
