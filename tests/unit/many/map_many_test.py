#!/usr/bin/env python3
"""Parts of marco map --many: which recordings there are and their names, the table, words for Slurm, locks and files.

usage: map_many_test.py BIN-FOLDER
"""
import importlib.machinery
import importlib.util
import json
import multiprocessing
import os
import pathlib
import signal
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("many", str(BIN / "marco-map-many"))
many = importlib.util.module_from_spec(importlib.util.spec_from_loader("many", loader))
sys.modules["many"] = many
loader.exec_module(many)

CARMEN = b"FLASER 2 1.0 1.0 0 0 0 0 0 0 1.0 host 1.0\n"


class InAFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="marco_many_")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name).resolve()

    def write(self, name, content):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path


class Recordings(InAFolder):
    def setUp(self):
        super().setUp()
        for name in ("z.log", "a b.log", ".hidden.log", "b/z.log", "mapped/slam.log"):
            self.write(name, CARMEN)
        self.write("notes.txt", "nothing\n")
        self.write("b/rosbag/metadata.yaml", "")
        self.write("b/rosbag/x.mcap", b"\x89MCAP0\r\n")
        self.write("mapped/report.json", "{}")

    def names_of(self, entries):
        return [entry.name for entry in entries]

    def test_are_found_in_a_folder_and_in_folders_within_it(self):
        entries = many.with_names([], many.find_recordings([self.folder]))
        self.assertEqual(self.names_of(entries), ["a_b", "rosbag", "z", "z_2"])
        self.assertEqual(entries[0].parts, [str(self.folder / "a b.log")])

    def test_are_listed_one_a_line(self):
        lines = self.write("list.txt", "# ours\nz.log\r\n\nb/z.log\n")
        self.assertEqual(self.names_of(many.with_names([], many.find_recordings([lines]))), ["z", "z_2"])
        self.write("list.txt", "gone.log\n")
        with self.assertRaisesRegex(many.Failure, "^[^:]*list.txt: there is no .*gone.log$"):
            many.find_recordings([lines])
        with self.assertRaisesRegex(many.Failure, "^[^:]*none: is missing$"):
            many.find_recordings([self.folder / "none"])
        with self.assertRaisesRegex(many.Failure, "^[^:]*empty.txt: contains neither a recording nor a list of recordings$"):
            many.find_recordings([self.write("empty.txt", "# none\n")])

    def test_of_several_parts_are_one_line(self):
        entries = many.with_names([], [["/logs/run_0.bag", "/logs/run_1.bag"], ["/logs/z_0.bag"]])
        self.assertEqual(self.names_of(entries), ["run", "z_0"])
        many.write_list(self.folder / "list.tsv", entries)
        again = many.read_list(self.folder / "list.tsv")
        self.assertEqual(again, entries)
        more = many.with_names(again, [["/logs/run_1.bag", "/logs/run_2.bag"]])
        self.assertEqual(self.names_of(more), ["run", "z_0"])

    def test_keep_their_names_when_others_come(self):
        first = many.with_names([], many.find_recordings([self.folder / "b"]))
        self.assertEqual(self.names_of(first), ["rosbag", "z"])
        many.write_list(self.folder / "list.tsv", first)
        more = many.with_names(many.read_list(self.folder / "list.tsv"), many.find_recordings([self.folder]))
        self.assertEqual(self.names_of(more), ["rosbag", "z", "a_b", "z_2"])
        self.assertEqual(more[1].parts, first[1].parts)

    def test_have_names_that_are_folders_and_words(self):
        for path, name in (("/a/jobs.lcm", "jobs_log"), ("/a/.x.bag", "log.x"), ("/a/r.bag.mcap", "r"), ("/a/ü;$.log", "____")):
            self.assertEqual(many.plain_name([path]), name)

    def test_may_have_names_that_are_no_utf8(self):
        odd = os.fsdecode(b"\xff.log")
        self.write(odd, CARMEN)
        entries = many.with_names([], many.find_recordings([self.folder / odd]))
        many.write_list(self.folder / "list.tsv", entries)
        self.assertEqual(many.read_list(self.folder / "list.tsv")[0].parts, [str(self.folder / odd)])
        self.assertTrue(many.printable(entries[0].parts[0]).endswith("/\\xff.log"))


def write_often(path, letter):
    for _ in range(20):
        many.write_whole(path, letter * 5000)


class Files(InAFolder):
    def test_are_never_seen_half_written_by_two(self):
        path = self.folder / "table.csv"
        writers = [multiprocessing.Process(target=write_often, args=(path, letter)) for letter in "ab"]
        for writer in writers:
            writer.start()
        while any(writer.is_alive() for writer in writers):
            if path.exists():
                self.assertIn(path.read_text(), ("a" * 5000, "b" * 5000))
        self.assertEqual([writer.exitcode for writer in writers], [0, 0])
        self.assertEqual(list(self.folder.iterdir()), [path])


class Table(InAFolder):
    def setUp(self):
        super().setUp()
        self.store = many.Store(self.folder)
        self.store.jobs.mkdir()
        report = {"inputs": [{"format": "ROS bag"}], "scans": {"posed": 12}, "distance_m": 3.456,
                  "loops": [{"in_force": True}, {"in_force": False}], "verdict": "good", "cpu_s": 1.25}
        self.write("good/report.json", json.dumps(report))
        self.write("good/map.png", "")
        self.entries = [many.Entry(name, ["/" + name]) for name in ("good", "bad", "none")]
        many.record_failure(self.store, self.entries[1], 'no laser: it holds "a", <b>', 0.5)

    def test_tells_of_each_what_became_of_it(self):
        self.assertEqual(many.write_table(self.store, self.entries), many.EXIT_FAILED)
        self.assertEqual((self.folder / "table.csv").read_bytes().decode(),
                         "log,format,scans,length_m,loops,verdict,cpu_s,picture,reason,path\r\n"
                         "good,ROS bag,12,3.46,1,good,1.25,good/map.png,,/good\r\n"
                         'bad,,0,0.00,0,failed,0.50,,"no laser: it holds ""a"", <b>",/bad\r\n'
                         "none,,0,0.00,0,not done,0.00,,,/none\r\n")
        page = (self.folder / "index.html").read_text()
        self.assertIn("3 recordings, 1 good, 0 doubtful, 0 wrong, 1 failed, 1 not done", page)
        self.assertIn("failed: no laser: it holds &quot;a&quot;, &lt;b&gt;", page)
        self.assertIn('src="good/map.png"', page)

    def test_asks_nothing_more_of_what_is_mapped_or_failed(self):
        self.assertEqual([self.store.is_done(entry) for entry in self.entries], [True, True, False])

    def test_of_maps_alone_is_a_success(self):
        self.assertEqual(many.write_table(self.store, self.entries[:1]), many.EXIT_DONE)


class Slurm(unittest.TestCase):
    def test_takes_ranges_and_quoted_words(self):
        self.assertEqual(many.array_of([1, 2, 3, 7, 9, 10]), "1-3,7,9-10")
        self.assertEqual(many.array_of([4]), "4")
        self.assertEqual(many.quoted("it's $HOME"), "'it'\\''s $HOME'")


class Children(InAFolder):
    def end_of(self, script):
        return many.wait_for(many.start(["/bin/sh", "-c", script], self.folder / "printed"))

    def test_that_crash_are_told_from_those_that_are_killed(self):
        for script, was_killed in (("exit 1", False), ("exit 128", False), ("kill -SEGV $$", False), ("kill -KILL $$", True),
                                   ("kill -TERM $$", True), ("exit 130", True)):
            self.assertEqual(self.end_of(script).was_killed(), was_killed, script)

    def test_say_last_why_they_failed(self):
        self.end_of(r"printf 'first\n 1 %%\r 2 %%\rno scans\n 3 %%\r\n' >&2")
        self.assertEqual(many.last_line(self.folder / "printed"), "no scans")


if __name__ == "__main__":
    signal.alarm(100)
    unittest.main()
