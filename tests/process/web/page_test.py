#!/usr/bin/env python3
"""marco-page against clients and attackers over loopback, with the real LCM network of a namespace.
usage: page_test.py BIN ROOT"""
import json
import os
import pty
import signal
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import page_bus
from page_client import Client, Refused, http_get
from page_process import BIN, ROOT, Page, WithPage, eventually


class Files(WithPage):
    def test_address_and_headers(self):
        self.assertEqual(self.page.address, "http://127.0.0.1:8765/")
        status, fields, body = http_get(8765, "/page/nothing.js")
        self.assertEqual(status, 404)
        self.assertIn("script-src" if "script-src" in fields["Content-Security-Policy"] else "default-src 'self'",
                      fields["Content-Security-Policy"])
        self.assertEqual(fields["X-Content-Type-Options"], "nosniff")
        self.assertEqual(http_get(8765, "/snapshot.json")[0], 404)
        self.assertEqual(http_get(8765, "/", method="POST")[0], 405)
        self.assert_counted("a method other than GET")

    def test_no_path_leads_out(self):
        for path in ("/../../../../etc/passwd", "/page/../../../etc/passwd", "/page/..%2f..%2f..%2fetc%2fpasswd",
                     "/files/../../etc/passwd", "//etc/passwd", "/page//etc/passwd", "/page/%00", "/%2e%2e/marco",
                     "/page/....//x", "http://127.0.0.1/etc/passwd"):
            status, _, body = http_get(8765, path)
            self.assertEqual(status, 404, path)
            self.assertNotIn(b"root:", body)

    def test_a_name_of_another_is_refused(self):
        self.assertEqual(http_get(8765, "/", host="evil.org")[0], 421)
        self.assert_counted("unknown host name")

    def test_kept_connections_answer_again(self):
        with socket.create_connection(("127.0.0.1", 8765), timeout=5) as link:
            for _ in range(3):
                link.sendall(b"GET /page/x HTTP/1.1\r\nHost: localhost\r\n\r\n")
                answer = b""
                while b"Not found" not in answer:
                    answer += link.recv(4096)
                self.assertIn(b"404", answer)


class Protocol(WithPage):
    def test_both_subprotocols(self):
        for name in ("foxglove.sdk.v1", "foxglove.websocket.v1"):
            client = Client(8765, offer=name)
            self.assertEqual(client.subprotocol, name)
            self.assertTrue(client.wait(lambda: client.info and client.services and client.channels))
            self.assertEqual(client.info["metadata"]["mode"], "live")
            self.assertEqual(client.info["metadata"]["read_only"], "false")
            client.text({"op": "getParameters", "parameterNames": [], "id": "1"})
            self.assertTrue(client.wait(lambda: any(text["op"] == "parameterValues" for text in client.texts)))
            values = {one["name"]: one["value"] for one in client.texts[-1]["parameters"]}
            self.assertEqual((values["mode"], values["most_velocity_m_per_s"]), ("live", 0.5))
            client.close()
        for offer in ("mqtt", None):
            with self.assertRaises(Refused) as refusal:
                Client(8765, offer=offer)
            self.assertEqual(refusal.exception.args[0], 400)

    def test_a_page_of_another_site_is_refused(self):
        for origin in ("https://evil.org", "null", "http://127.0.0.1:8080"):
            with self.assertRaises(Refused) as refusal:
                Client(8765, origin=origin)
            self.assertEqual(refusal.exception.args[0], 403)
        Client(8765, origin="http://127.0.0.1:8765").close()
        foxglove = Client(8765, origin="https://app.foxglove.dev")
        foxglove.wait(lambda: foxglove.info)
        self.assertEqual(foxglove.info["metadata"]["read_only"], "true")
        foxglove.close()
        self.assert_counted("a page of another site")

    def test_every_channel_has_a_schema(self):
        client = Client(8765)
        self.assertTrue(client.wait(lambda: "PROCESS_STATUS" in client.channels, 5))
        for channel in client.channels.values():
            self.assertEqual((channel["encoding"], channel["schemaEncoding"]), ("json", "jsonschema"))
            self.assertEqual(json.loads(channel["schema"])["type"], "object", channel["topic"])
            self.assertTrue(channel["schemaName"])
        self.assertEqual(client.channels["PROCESS_STATUS"]["schemaName"], "marco.process_status_t")
        client.close()

    def test_unknown_and_broken_messages_do_no_harm(self):
        client = Client(8765)
        client.text({"op": "subscribeConnectionGraph"})
        client.text("nonsense")
        client.text("[" * 30000)
        client.binary(b"")
        client.binary(b"\x02\xff")
        client.binary(b"\xee" * 1000)
        client.wait(lambda: sum(text["op"] == "status" for text in client.texts) >= 4, 3)
        client.subscribe("page/health")
        self.assertTrue(client.wait(lambda: client.of("page/health"), 3))
        client.close()

    def test_names_of_programs_are_texts(self):
        client = Client(8765)
        client.subscribe("page/health")
        fingerprint = self.bus.wait("PROCESS_STATUS")[:8]
        name = "<script>alert('x')</script>\"\\"
        for _ in range(30):
            self.bus.send("PROCESS_STATUS", page_bus.process_status(fingerprint, name, b"no device: \xff\x01</b>"))
            client.wait(lambda: False, 0.1)
        programs = {program["name"]: program for program in client.of("page/health")[-1]["programs"]}
        self.assertEqual(programs[name]["text"], "no device: \ufffd\u0001</b>")
        self.assertEqual(programs[name]["state"], "error")
        client.close()


class Attacks(WithPage):
    def test_a_large_frame_ends_its_sender_only(self):
        other = Client(8765)
        client = Client(8765)
        try:
            client.text("x" * (2 << 20))
            self.assertTrue(client.wait(lambda: client.is_closed, 5))
        except ConnectionError:
            pass
        self.assertFalse(other.is_closed)
        self.assert_counted("above 32 kB")
        other.close()

    def test_a_slow_request_is_given_up(self):
        links = []
        for _ in range(20):
            link = socket.create_connection(("127.0.0.1", 8765), timeout=12)
            link.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n")
            links.append(link)
        begun = time.time()
        while time.time() - begun < 4:
            for link in links:
                link.sendall(b"X-a: b\r\n")
            time.sleep(1)
        self.assert_serves()
        for link in links:
            try:
                self.assertEqual(link.recv(100), b"")
            except ConnectionError:
                pass
            link.close()
        self.assertLess(time.time() - begun, 8)
        self.assert_counted("a request that took too long")

    def test_a_large_header_is_refused(self):
        with socket.create_connection(("127.0.0.1", 8765), timeout=5) as link:
            try:
                link.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * 100000)
                link.recv(1000)
            except ConnectionError:
                pass
        self.assert_counted("malformed request")

    def test_a_thousand_connections(self):
        reader = Client(8765)
        reader.subscribe("page/health")
        self.assertTrue(reader.wait(lambda: reader.of("page/health")))
        before_kb = self.page.memory_kb()
        links = []
        for _ in range(1000):
            try:
                links.append(socket.create_connection(("127.0.0.1", 8765), timeout=5))
            except OSError:
                break
        got = len(reader.of("page/health"))
        self.assertTrue(reader.wait(lambda: len(reader.of("page/health")) >= got + 2, 3.5))
        self.assertFalse(reader.is_closed)
        self.assertLess(self.page.memory_kb() - before_kb, 60000)
        for link in links:
            link.close()
        self.assertTrue(eventually(lambda: http_get(8765, "/page/x")[0] == 404, 5))
        self.assert_serves()
        self.assert_counted("more than 256 connections")
        reader.close()

    def test_a_flood_of_messages_is_let_go(self):
        client = Client(8765)
        try:
            for _ in range(20000):
                client.text({"op": "x"})
        except ConnectionError:
            pass
        self.assertTrue(client.wait(lambda: client.is_closed, 5))
        self.assert_serves()
        self.assert_counted("client sends too much")


class Steers(WithPage):
    def test_velocities_become_orders_and_end_with_a_stop(self):
        client = Client(8765)
        client.wait(lambda: client.info)
        client.advertise(1, "/cmd_vel", "geometry_msgs/Twist")
        del self.bus.heard[:]
        for _ in range(10):
            client.publish(1, {"linear": {"x": 9.0}, "angular": {"z": 0.1}})
            client.wait(lambda: False, 0.06)
        client.publish(1, {"linear": {"x": 0.0}, "angular": {"z": 0.0}})
        self.assertTrue(eventually(lambda: any(page_bus.base_command(order)["kind"] == 0
                                               for order in self.bus.of("BASE_COMMAND")), 2))
        orders = [page_bus.base_command(order) for order in self.bus.of("BASE_COMMAND")]
        self.assertGreaterEqual(len(orders), 8)
        self.assertEqual((orders[0]["kind"], orders[0]["velocity"]), (3, 0.5))
        # Two hands on one stick.
        other = Client(8765)
        other.advertise(1, "/cmd_vel")
        client.publish(1, {"linear": {"x": 0.1}, "angular": {"z": 0.0}})
        client.wait(lambda: False, 0.1)
        other.publish(1, {"linear": {"x": -0.1}, "angular": {"z": 0.0}})
        self.assertTrue(other.wait(lambda: any("another client drives" in text.get("message", "")
                                               for text in other.texts), 2))
        del self.bus.heard[:]
        client.publish(1, {"linear": {"x": 0.1}, "angular": {"z": 0.0}})
        client.wait(lambda: False, 0.1)
        client.close()  # a browser that is gone drives no more
        self.assertTrue(eventually(lambda: [page_bus.base_command(order)["kind"]
                                            for order in self.bus.of("BASE_COMMAND")] == [3, 0], 2))
        other.close()

    def test_orders_that_cannot_be_are_refused(self):
        client = Client(8765)
        self.assertIn("SLAM_POSE", client.call("go", {"x_m": 1, "y_m": 2})["text"])
        for request in ({"x_m": 1}, {"x_m": "1", "y_m": 2}, {"x_m": 1e9, "y_m": 0}, []):
            self.assertFalse(client.call("go", request)["ok"], request)
        self.assertFalse(client.call("procman", {"command": "<b>", "action": "start"})["ok"])
        for request in ({"command": "save", "folder": "../x"}, {"command": "save", "folder": "/x"},
                        {"command": "fly"}, {"command": 7}):
            self.assertFalse(client.call("slam", request)["ok"], request)
        self.assertIsNone(self.bus.last.get("SLAM_COMMAND"))
        begun = time.time()
        self.assertIn("did not answer", client.call("slam", {"command": "pause"}, 13)["text"])
        self.assertLess(time.time() - begun, 11.5)
        client.close()

    def test_a_stop_stops_and_is_seen_by_all(self):
        client, other = Client(8765), Client(8765)
        other.subscribe("page/stop")
        self.assertTrue(other.wait(lambda: other.of("page/stop")))
        self.assertTrue(client.call("stop", {"engaged": True})["ok"])
        self.assertTrue(eventually(lambda: len(self.bus.of("EMERGENCY_STOP")) >= 8, 2))
        self.assertEqual(self.bus.last["EMERGENCY_STOP"][16], 1)
        self.assertTrue(other.wait(lambda: other.of("page/stop")[-1]["engaged"], 2))
        self.assertIn("emergency stop", client.call("go", {"x_m": 0, "y_m": 0})["text"])
        self.assertTrue(client.call("stop", {"engaged": False})["ok"])
        self.assertTrue(other.wait(lambda: not other.of("page/stop")[-1]["engaged"], 2))
        for one in (client, other):
            one.close()


class Sheriff(WithPage):
    """The sheriff of a terminal, with a script that waits for a message."""
    file = """cmd "one" { exec = "sleep 1000"; deputy = "localhost"; auto_respawn = "true"; }
              cmd "two" { exec = "sleep 1001"; deputy = "localhost"; }
              script "go" { restart cmd "one" wait "running"; wait cmd "one" publishing "GO";
                            start cmd "two" wait "running"; }"""

    def state_of(self, command):
        commands = self.client.of("page/commands")[-1]["commands"]
        return next((one["state"] for one in commands if one["name"] == command), None)

    def test_an_order_of_the_page_does_not_stall_its_script(self):
        self.client = Client(8765)
        self.client.subscribe("page/commands")
        for _ in range(int(os.environ.get("MARCO_PROCMAN_ROUNDS", 1))):
            folder = tempfile.TemporaryDirectory()
            config = os.path.join(folder.name, "two.procman")
            with open(config, "w") as out:
                out.write(self.file)
            screen, terminal = pty.openpty()
            sheriff = subprocess.Popen(
                [os.path.join(BIN, "marco-procman-sheriff"), "-l", config, "go"], stdin=terminal, stdout=terminal,
                stderr=terminal, env=os.environ | {"TERM": "xterm", "XDG_RUNTIME_DIR": folder.name, "XDG_STATE_HOME": folder.name})
            os.close(terminal)
            threading.Thread(target=lambda: [None for _ in iter(lambda: self.drawn(screen), b"")], daemon=True).start()
            self.assertTrue(self.client.wait(lambda: self.client.of("page/commands") and
                                             self.state_of("one") == "running", 20))
            self.assertTrue(self.client.call("procman", {"command": "one", "action": "restart"})["ok"])
            self.client.wait(lambda: False, 2.5)  # so that a sheriff that only watches has missed its turn
            self.assertEqual((self.state_of("one"), self.state_of("two")), ("running", "stopped"))
            self.bus.send("GO", b"")
            self.assertTrue(self.client.wait(lambda: self.state_of("two") == "running", 20), self.state_of("two"))
            sheriff.send_signal(signal.SIGTERM)
            sheriff.wait(20)
            self.assertTrue(self.client.wait(lambda: self.state_of("two") != "running", 20))
            folder.cleanup()
        self.client.close()

    @staticmethod
    def drawn(screen):
        try:
            return os.read(screen, 65536)
        except OSError:  # its end
            return b""


class TwoSlams(WithPage):
    """Scan SLAM and line SLAM both take an order: each one's answer is told, by the page and by the command."""

    def test_both_answer(self):
        with tempfile.TemporaryDirectory() as folder:
            slams = [subprocess.Popen([os.path.join(BIN, name)], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                     for name in ("marco-slam", "marco-line-slam")]
            client = Client(8765)
            client.subscribe("page/health")

            def running():
                told = client.of("page/health")
                return {program["name"] for program in told[-1]["programs"]} if told else set()
            self.assertTrue(client.wait(lambda: {"marco-slam", "marco-line-slam"} <= running(), 10))
            answer = client.call("slam", {"command": "pause"}, 8)
            self.assertTrue(answer["ok"])
            self.assertEqual(answer["text"].split("\n"),
                             ["marco-line-slam: PAUSE: scans are ignored", "marco-slam: PAUSE: scans are ignored"])
            # One cannot, the other finds no such map: neither word is lost.
            answer = client.call("slam", {"command": "localize", "folder": "nowhere"}, 8)
            self.assertFalse(answer["ok"])
            self.assertIn("marco-line-slam: refused: LOCALIZE: the line SLAM cannot relocalize", answer["text"])
            self.assertRegex(answer["text"], r"(?m)^marco-slam: (refused|failed): .*nowhere")
            command = subprocess.run([os.path.join(BIN, "marco-slam-order"), "resume"], capture_output=True, text=True)
            self.assertEqual((command.returncode, command.stdout),
                             (0, "marco-line-slam: RESUME: mapping continues\nmarco-slam: RESUME: mapping continues\n"))
            client.close()
            for slam in slams:
                slam.terminate()
                slam.wait()


class Maps(WithPage):
    """A recording is played to marco-slam; two clients look, a third never reads."""

    def test_the_map_comes_whole_and_a_stalled_client_costs_nothing(self):
        slam = subprocess.Popen([os.path.join(BIN, "marco-slam")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        stalled = Client(8765, reads=False)
        stalled.wait(lambda: "page/scan" in stalled.channels)
        stalled.subscribe("page/scan", "page/tiles", "/map", "/scan", "/tf")
        reader = Client(8765)
        reader.subscribe("page/tiles", "page/scan", "/pose", "/tf", "/path")
        player = subprocess.Popen(["lcm-logplayer", "--speed=2", os.path.join(ROOT, "logs/sample.lcm")],
                                  stdout=subprocess.DEVNULL)
        while player.poll() is None:
            reader.step(0.1)
            if "LIDAR" in reader.channels and "LIDAR" not in reader.topic_of.values():
                reader.subscribe("LIDAR")
        reader.wait(lambda: False, 1.0)
        slam.terminate()
        slam.wait()
        tiles_before = -1
        while tiles_before != len(reader.of("page/tiles")):  # the last ones come late on a busy host
            tiles_before = len(reader.of("page/tiles"))
            reader.wait(lambda: False, 1.0)
        sent = sum(name == "LIDAR" for _, name, _ in self.bus.heard)
        self.assertGreater(sent, 200)
        self.assertGreater(len(reader.of("LIDAR")), 0.97 * sent)
        tiles = reader.of("page/tiles")
        self.assertGreater(len(tiles), 3)
        known = {}
        for message in tiles:
            if message.get("clear"):
                known.clear()
            for tile in message["tiles"]:
                known[(tile["x_m"], tile["y_m"])] = tile["png"]
        late = Client(8765)
        late.subscribe("page/tiles", "/path", "/map")
        self.assertTrue(late.wait(lambda: late.of("page/tiles") and late.of("/path") and late.of("/map"), 3))
        whole = {(tile["x_m"], tile["y_m"]): tile["png"] for tile in late.of("page/tiles")[0]["tiles"]}
        self.assertTrue(late.of("page/tiles")[0]["clear"])
        self.assertGreater(len(whole), 2)
        for place, png in whole.items():
            self.assertEqual(known[place], png, place)
        frames = {(transform["parent_frame_id"], transform["child_frame_id"])
                  for message in reader.of("/tf") for transform in message["transforms"]}
        self.assertEqual(frames & {("map", "odom"), ("odom", "base"), ("base", "laser")},
                         {("map", "odom"), ("odom", "base"), ("base", "laser")})
        points = reader.of("page/scan")[-1]
        self.assertEqual(len(points["x_m"]), len(points["y_m"]))
        self.assertGreater(len(points["x_m"]), 50)
        # It is sent no more than its socket holds, and let go once it has taken nothing for 30 s.
        self.assertLess(self.page.memory_kb(), 150000)
        for one in (reader, late, stalled):
            one.close()


class Folder(unittest.TestCase):
    def test_a_map_is_shown_and_nothing_beside_it(self):
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "map")
            subprocess.run([os.path.join(BIN, "marco-map"), os.path.join(ROOT, "logs/sample.lcm"), "--out", out],
                           check=True, capture_output=True)
            with open(os.path.join(folder, "secret"), "w") as secret:
                secret.write("secret")
            page = Page(out, "--listen", "127.0.0.1:8771")
            client = Client(8771)
            client.wait(lambda: client.info)
            self.assertEqual(client.info["metadata"]["mode"], "folder")
            status, fields, body = http_get(8771, "/snapshot.json")
            self.assertEqual((status, fields["Content-Type"]), (200, "application/json"))
            snapshot = json.loads(body)
            self.assertGreater(len(snapshot["tiles"]), 0)
            if snapshot["model"]:
                self.assertEqual(http_get(8771, "/" + snapshot["model"])[0], 200)
            for path in ("/files/report.json", "/files/../secret", "/files/secret"):
                self.assertEqual(http_get(8771, path)[0], 404)
            client.close()
            self.assertEqual(page.close()[0], 0)

    def test_what_is_no_map_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            result = subprocess.run([os.path.join(BIN, "marco-page"), folder], capture_output=True, text=True)
            self.assertEqual(result.returncode, 1)
            self.assertEqual(result.stdout, "")


class Tls(unittest.TestCase):
    def test_a_certificate_gives_https(self):
        with tempfile.TemporaryDirectory() as folder:
            names = [os.path.join(folder, name) for name in ("certificate.pem", "key.pem")]
            subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost",
                            "-addext", "subjectAltName=DNS:localhost", "-out", names[0], "-keyout", names[1]],
                           check=True, capture_output=True)
            page = Page("--listen", "127.0.0.1:8773", "--certificate", names[0], "--key", names[1])
            self.assertEqual(page.address, "https://127.0.0.1:8773/")
            trust = ssl.create_default_context(cafile=names[0])
            with socket.create_connection(("127.0.0.1", 8773), timeout=5) as plain:
                with trust.wrap_socket(plain, server_hostname="localhost") as link:
                    link.sendall(b"GET /page/x HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                    self.assertIn(b"404", link.recv(4096))
            with socket.create_connection(("127.0.0.1", 8773), timeout=5) as plain:
                with trust.wrap_socket(plain, server_hostname="localhost") as link:
                    link.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                                 b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
                                 b"Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n")
                    answer = b""
                    while b"serverInfo" not in answer:
                        piece = link.recv(4096)
                        self.assertTrue(piece, answer)
                        answer += piece
                    self.assertTrue(answer.startswith(b"HTTP/1.1 101"))
            with socket.create_connection(("127.0.0.1", 8773), timeout=8) as plain:
                plain.sendall(b"GET / HTTP/1.1\r\n\r\n")
                try:
                    self.assertNotIn(b"HTTP/1.1 200", plain.recv(1000))
                except ConnectionError:
                    pass
            self.assertEqual(page.close()[0], 0)

    def test_a_certificate_that_is_none_is_refused(self):
        with tempfile.NamedTemporaryFile() as file:
            result = subprocess.run([os.path.join(BIN, "marco-page"), "--listen", "127.0.0.1:8774", "--certificate", file.name,
                                     "--key", file.name], capture_output=True, text=True)
            self.assertEqual(result.returncode, 1)
            self.assertIn("cannot be used", result.stderr)


class Recording(unittest.TestCase):
    def test_a_recording_plays_pauses_and_takes_no_orders(self):
        page = Page(os.path.join(ROOT, "logs/sample.lcm"), "--listen", "127.0.0.1:8772", "--speed", "5")
        client = Client(8772)
        client.wait(lambda: "LIDAR" in client.channels)
        self.assertEqual(client.info["metadata"]["mode"], "recording")
        self.assertIn("playbackControl", client.info["capabilities"])
        self.assertEqual(client.info["dataStartTime"]["sec"], 1700000000)
        client.subscribe("LIDAR", "page/scan")
        self.assertTrue(client.wait(lambda: len(client.of("page/scan")) > 20))
        self.assertFalse(client.call("stop", {"engaged": True})["ok"])
        seek = (1700000010 * 10**9)
        client.binary(b"\x03\x01" + struct.pack("<fBQI", 1.0, 1, seek, 1) + b"a")
        client.wait(lambda: False, 0.5)
        got = len(client.of("LIDAR"))
        client.wait(lambda: False, 1.0)
        self.assertEqual(len(client.of("LIDAR")), got)
        client.binary(b"\x03\x00" + struct.pack("<fBQI", 1.0, 0, 0, 1) + b"b")
        self.assertTrue(client.wait(lambda: len(client.of("LIDAR")) > got + 3, 3))
        after = client.of("LIDAR")[got]["utime"] / 1e6
        self.assertLess(abs(after - 1700000010), 1.0)
        client.close()
        page.close()

    def test_what_is_no_recording_is_refused(self):
        result = subprocess.run([os.path.join(BIN, "marco-page"), "/nowhere"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn("no such file", result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], warnings="ignore")
