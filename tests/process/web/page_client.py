"""A client of marco-page without any library but Python's: HTTP, WebSocket, Foxglove's protocol."""
import base64
import json
import os
import select
import socket
import struct
import time

SUBPROTOCOLS = "foxglove.sdk.v1, foxglove.websocket.v1"


def http_get(port, path, host="127.0.0.1", headers=(), method="GET"):
    """Status, headers and body. `path` is sent as it is."""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as link:
        lines = [f"{method} {path} HTTP/1.1", f"Host: {host}:{port}", "Connection: close", *headers]
        link.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        answer = b""
        while True:
            piece = link.recv(1 << 16)
            if not piece:
                break
            answer += piece
    head, _, body = answer.partition(b"\r\n\r\n")
    first, *rest = head.decode("latin-1").split("\r\n")
    fields = dict(line.split(": ", 1) for line in rest if ": " in line)
    return int(first.split()[1]), fields, body


class Refused(Exception):
    """The handshake was answered by another status than 101."""


class Client:
    """One WebSocket. `texts` and `messages` hold what came; step() reads more."""

    def __init__(self, port, offer=SUBPROTOCOLS, origin=None, host="127.0.0.1", path="/", reads=True):
        self.link = socket.create_connection(("127.0.0.1", port), timeout=10)
        if not reads:
            self.link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        fields = [f"GET {path} HTTP/1.1", f"Host: {host}:{port}", "Upgrade: websocket", "Connection: Upgrade",
                  "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode(), "Sec-WebSocket-Version: 13"]
        if offer:
            fields.append("Sec-WebSocket-Protocol: " + offer)
        if origin:
            fields.append("Origin: " + origin)
        self.link.sendall(("\r\n".join(fields) + "\r\n\r\n").encode())
        answer = b""
        while b"\r\n\r\n" not in answer:
            piece = self.link.recv(1 << 16)
            if not piece:
                raise Refused("closed")
            answer += piece
        head, _, self.pending = answer.partition(b"\r\n\r\n")
        status = int(head.split()[1])
        if status != 101:
            self.link.close()
            raise Refused(status)
        self.subprotocol = next(line.split(b": ")[1].decode() for line in head.split(b"\r\n")
                                if line.lower().startswith(b"sec-websocket-protocol"))
        self.info, self.channels, self.services = {}, {}, {}
        self.texts, self.messages, self.answers, self.failures = [], [], {}, {}
        self.topic_of, self.is_closed, self.parts = {}, False, b""
        self.calls = self.subscriptions = 0

    def close(self):
        self.link.close()

    # Outgoing.
    def frame(self, opcode, payload):
        mask = os.urandom(4)
        size = len(payload)
        head = bytes([0x80 | opcode])
        head += (bytes([0x80 | size]) if size < 126 else
                 bytes([0x80 | 126]) + struct.pack(">H", size) if size < 65536 else
                 bytes([0x80 | 127]) + struct.pack(">Q", size))
        key = int.from_bytes((mask * (size // 4 + 1))[:size], "big")
        self.link.sendall(head + mask + (int.from_bytes(payload, "big") ^ key).to_bytes(size, "big"))

    def text(self, value):
        self.frame(1, (value if isinstance(value, str) else json.dumps(value)).encode())

    def binary(self, payload):
        self.frame(2, payload)

    def subscribe(self, *topics):
        self.wait(lambda: all(topic in self.channels for topic in topics))
        chosen = []
        for topic in topics:
            self.subscriptions += 1
            self.topic_of[self.subscriptions] = topic
            chosen.append({"id": self.subscriptions, "channelId": self.channels[topic]["id"]})
        self.text({"op": "subscribe", "subscriptions": chosen})

    def advertise(self, number, topic, schema="x"):
        self.text({"op": "advertise", "channels": [
            {"id": number, "topic": topic, "encoding": "json", "schemaName": schema}]})

    def publish(self, number, value):
        self.binary(b"\x01" + struct.pack("<I", number) + json.dumps(value).encode())

    def call(self, service, request, seconds=12.0):
        """The service's answer, or the text of its failure."""
        self.wait(lambda: service in self.services)
        self.calls += 1
        number = self.calls
        self.binary(b"\x02" + struct.pack("<III", self.services[service]["id"], number, 4) + b"json" +
                    json.dumps(request).encode())
        self.wait(lambda: number in self.answers or number in self.failures, seconds)
        return self.answers.get(number, self.failures.get(number))

    # Incoming.
    def step(self, seconds=0.1):
        """Reads what is there within the time. False when the connection is over."""
        if not self.pending and not select.select([self.link], [], [], seconds)[0]:
            return True
        if select.select([self.link], [], [], 0)[0]:
            try:
                piece = self.link.recv(1 << 20)
            except ConnectionError:
                piece = b""
            if not piece:
                self.is_closed = True
            self.pending += piece
        while self.take_frame():
            pass
        return not self.is_closed

    def take_frame(self):
        data = self.pending
        if len(data) < 2:
            return False
        size, at = data[1] & 127, 2
        if size == 126:
            size, at = (struct.unpack(">H", data[2:4])[0], 4) if len(data) >= 4 else (1 << 60, 0)
        elif size == 127:
            size, at = (struct.unpack(">Q", data[2:10])[0], 10) if len(data) >= 10 else (1 << 60, 0)
        if len(data) < at + size:
            return False
        opcode, final = data[0] & 15, data[0] & 128
        payload, self.pending = data[at:at + size], data[at + size:]
        if opcode == 8:
            self.is_closed = True
        elif opcode == 9:
            self.frame(10, payload)
        elif opcode < 3:
            self.kind = opcode or self.kind
            self.parts += payload
            if final:
                whole, self.parts = self.parts, b""
                self.take(whole)
        return True

    def take(self, whole):
        if self.kind == 1:
            value = json.loads(whole)
            self.texts.append(value)
            op = value["op"]
            if op == "serverInfo":
                self.info = value
            elif op == "advertise":
                self.channels.update({channel["topic"]: channel for channel in value["channels"]})
            elif op == "unadvertise":
                self.channels = {topic: channel for topic, channel in self.channels.items()
                                 if channel["id"] not in value["channelIds"]}
            elif op == "advertiseServices":
                self.services.update({service["name"]: service for service in value["services"]})
            elif op == "serviceCallFailure":
                self.failures[value["callId"]] = value["message"]
        elif whole[0] == 1:
            subscription, stamp = struct.unpack("<IQ", whole[1:13])
            self.messages.append((self.topic_of.get(subscription), stamp, whole[13:], time.time()))
        elif whole[0] == 3:
            _, number, length = struct.unpack("<III", whole[1:13])
            self.answers[number] = json.loads(whole[13 + length:])

    def wait(self, condition, seconds=10.0):
        end = time.time() + seconds
        while not condition():
            if not self.step(0.05) or time.time() > end:
                return bool(condition())
        return True

    def of(self, topic):
        """The values of a topic's messages so far."""
        return [json.loads(payload) for name, _, payload, _ in self.messages if name == topic]
