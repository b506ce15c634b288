#!/usr/bin/env python3
"""Map folders from strangers: no program that reads one follows a link out of it, or waits for a pipe in it.
usage: folder_test.py BIN ROOT"""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

BIN, ROOT = sys.argv[1], sys.argv[2]
LOG = os.path.join(ROOT, "logs/sample.lcm")
SECRET = b"-----BEGIN PRIVATE KEY-----"


def run(program, *words):
    return subprocess.run([os.path.join(BIN, program), *words], capture_output=True, timeout=60)


class Strangers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.top = tempfile.TemporaryDirectory()
        cls.secret = os.path.join(cls.top.name, "secret")
        with open(cls.secret, "wb") as out:
            out.write(SECRET)
        cls.own = os.path.join(cls.top.name, "own")
        made = run("marco-map", LOG, "--out", cls.own)
        assert made.returncode in (0, 3), made.stderr

    @classmethod
    def tearDownClass(cls):
        cls.top.cleanup()

    def bent(self, name, how):
        """A copy of the map, one file of it a link out, a link through a folder that leads out, or a pipe."""
        folder = os.path.join(self.top.name, "strangers")
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.own, folder)
        path = os.path.join(folder, name)
        if os.path.exists(path):
            os.unlink(path)
        if how == "link":
            os.symlink(self.secret, path)
        elif how == "folder":
            os.symlink(self.top.name, os.path.join(folder, "beside"))
            os.symlink("beside/secret", path)
        else:
            os.mkfifo(path)
        return folder

    def test_are_read_within_themselves(self):
        out = os.path.join(self.top.name, "out")
        readers = {
            "map.marco": [("marco-plan", "{}"), ("marco-map", LOG, "--localize", "{}", "--out", out),
                          ("marco-map", LOG, "--extend", "{}", "--out", out), ("marco-map", "--merge", "{}", self.own, "--out", out)],
            "map.pgm": [("marco-export", "{}", "--html", out), ("marco-viewer", "{}", "--out", out + ".png")],
            "map.yaml": [("marco-export", "{}", "--html", out)],
            "model.glb": [("marco-export", "{}", "--html", out)],
            "report.json": [("marco-export", "{}", "--html", out), ("marco-page", "{}", "--listen", "127.0.0.1:8781")]}
        for name, programs in readers.items():
            for how in ("link", "folder", "pipe"):
                folder = self.bent(name, how)
                for program, *words in programs:
                    result = run(program, *(word.format(folder) for word in words))
                    said = result.stdout + result.stderr
                    # A picture is made of what can be drawn; what cannot is said.
                    self.assertEqual(result.returncode, 0 if program == "marco-viewer" else 1, (program, name, how, said))
                    self.assertIn(b"is not a file" if how == "pipe" else b"points outside its folder", said, (program, name))
                    self.assertNotIn(SECRET, said)

    def test_that_are_links_of_their_users_are_read(self):
        link = os.path.join(self.top.name, "mine")
        os.symlink(self.own, link)
        os.rename(os.path.join(self.own, "report.json"), os.path.join(self.own, "kept.json"))
        os.symlink("kept.json", os.path.join(self.own, "report.json"))
        result = run("marco-export", link, "--html", os.path.join(self.top.name, "mine.html"))
        self.assertEqual(result.returncode, 0, result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], warnings="ignore")
