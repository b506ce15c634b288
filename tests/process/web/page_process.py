"""A marco-page as a child, with a network, folders for states, and counts of its own."""
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import page_bus
from page_client import Client

BIN, ROOT = sys.argv[1], sys.argv[2]
STATES = tempfile.TemporaryDirectory()  # pages keep their token and address below it
os.environ["XDG_STATE_HOME"] = STATES.name
TOKEN_FILE = os.path.join(STATES.name, "marco-page", "token")


def token():
    with open(TOKEN_FILE) as file:
        return file.read().strip()


def eventually(condition, seconds=10.0):
    end = time.time() + seconds
    while time.time() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False


class Page:
    """A marco-page with its first line read."""

    def __init__(self, *arguments, port=8765):
        self.folder = tempfile.TemporaryDirectory()
        self.errors = open(os.path.join(self.folder.name, "errors"), "w+")
        self.process = subprocess.Popen([os.path.join(BIN, "marco-page"), *arguments],
                                        stdout=subprocess.PIPE, stderr=self.errors, text=True)
        self.address = self.process.stdout.readline().strip()
        self.port = port

    def memory_kb(self, which="VmRSS"):
        with open(f"/proc/{self.process.pid}/status") as status:
            return int(re.search(which + r":\s+(\d+)", status.read())[1])

    def most_memory_kb(self):
        return self.memory_kb("VmHWM")

    def cpu_s(self):
        with open(f"/proc/{self.process.pid}/stat") as stat:
            fields = stat.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def said(self):
        self.errors.flush()
        with open(self.errors.name, errors="replace") as text:
            return text.read()

    def close(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(10)
        said = self.said()
        self.process.stdout.close()
        self.errors.close()
        self.folder.cleanup()
        return code, said


class WithPage(unittest.TestCase):
    arguments = ()

    @classmethod
    def setUpClass(cls):
        cls.bus = page_bus.Bus()
        cls.page = Page(*cls.arguments)

    @classmethod
    def tearDownClass(cls):
        code, said = cls.page.close()
        assert code == 0, said

    def refused(self):
        """How often, by cause, as PROCESS_STATUS says."""
        counts = {}
        status = next((payload for _, name, payload in reversed(self.bus.heard)
                       if name == "PROCESS_STATUS" and payload[20:31] == b"marco-page\0"), None)
        if status is None:
            return counts
        at = 16
        length = struct.unpack(">i", status[at:at + 4])[0]
        at += 4 + length + 16
        causes = struct.unpack(">i", status[at:at + 4])[0]
        at += 4
        names = []
        for _ in range(causes):
            length = struct.unpack(">i", status[at:at + 4])[0]
            names.append(status[at + 4:at + 3 + length].decode())
            at += 4 + length
        for name in names:
            counts[name] = struct.unpack(">q", status[at:at + 8])[0]
            at += 8
        return counts

    def assert_counted(self, part):
        self.assertTrue(eventually(lambda: any(part in cause for cause in self.refused()), 4),
                        f"{part} among {self.refused()}")

    def assert_serves(self):
        """Somebody else is answered at once."""
        begun = time.time()
        client = Client(8765)
        self.assertTrue(client.wait(lambda: "page/health" in client.channels, 2))
        client.close()
        self.assertLess(time.time() - begun, 1.0)
