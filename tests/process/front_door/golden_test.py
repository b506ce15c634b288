#!/usr/bin/env python3
"""./marco test --golden on recordings that a stub maps: what moves is named with both figures, what does not passes.

usage: golden_test.py PROJECT
"""
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.abspath(sys.argv[1])
sys.path.insert(0, ROOT + "/tests/golden")
import golden  # noqa: E402

# Writes what is in the folder `results` as the map of every log but refused.log.
MAP = """#!/bin/bash
[[ $1 != */refused.log ]] || { echo "note" >&2; echo "refused.log: no laser" >&2; exit 1; }
mkdir -p "$3" && cp "$RESULTS"/* "$3"
[ ! -e "$RESULTS/wrong" ] || exit 3
"""
EVALUATE = """#!/bin/bash
echo "n=7 skipped=0 translation_m mean=0.0123 std=0.01 p95=0.02 max=0.3 rotation_deg mean=0.2 std=0.1 p95=0.4 max=0.5"
"""
REPORT = {"verdict": "good", "cpu_s": 1.0, "distance_m": 12.5, "scans": {"posed": 9, "keyframes": 3},
          "inputs": [{"notes": ["ranges in mm"]}],
          "loops": [{"in_force": True}, {"in_force": False}], "errors": {"path error rms_m": 0.010},
          "calibration": {"use": "in_force", "remarks": [],
                          "parameters": [{"name": "laser.yaw_deg", "assumed": 0, "found": 12.0, "state": "off"}]}}


class Bench:
    def __init__(self, folder):
        self.folder, self.figures = folder, folder + "/figures.json"
        self.environment = dict(os.environ, MARCO_TEST_DATA=folder + "/data", RESULTS=folder + "/results")
        for name in ("data/a", "results", "bin"):
            os.makedirs(f"{folder}/{name}")
        for name in ("one.log", "one.relations", "refused.log", "notes.txt"):
            self.put("data/a/" + name, name)
        for name, text in (("marco-map", MAP), ("marco-evaluate", EVALUATE)):
            self.put("bin/" + name, text)
            os.chmod(f"{folder}/bin/{name}", 0o755)
        self.put("results/trajectory.tum", "0 0 0 0 0 0 0 1\n")
        self.put("results/map.pgm", "P5\n4 2\n255\n12345678")
        self.put("results/map.yaml", "image: map.pgm\nresolution: 0.05\n")
        self.report()

    def put(self, name, text):
        with open(f"{self.folder}/{name}", "w", encoding="utf-8") as file:
            file.write(text)

    def report(self, **changes):
        self.put("results/report.json", json.dumps({**REPORT, **changes}))

    def call(self, *words):
        command = [sys.executable, f"{ROOT}/tests/golden/golden.py", self.folder + "/bin", "--figures", self.figures]
        done = subprocess.run([*command, *words], capture_output=True, text=True, env=self.environment, check=False)
        return done.returncode, done.stdout, done.stderr


def expect(what, condition, said=""):
    if not condition:
        sys.exit(f"FAILED: {what}: {said}")


def expect_moved(bench, what, *rows):
    code, out, _ = bench.call()
    expect(f"{what}: exit code 1", code == 1 and "1 recordings, 1 moved" in out, out)
    figures = [" ".join(line.split()) for line in out.splitlines() if line.startswith("  ")]
    expect(f"{what}: only {rows} moved", figures == list(rows), out)


def main():
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(folder)
        code, _, err = bench.call("--write", "a/")
        with open(bench.figures, encoding="utf-8") as file:
            kept = json.load(file)
        kept.pop("machine")
        expect("what can be mapped is kept, by its path below the data", code == 0 and list(kept) == ["a/one.log"], err)
        one = kept["a/one.log"]
        expect("figures", one["loops"] == "2, 1 in force" and one["keyframes"] == 3 and one["grid"] == "4 x 2 cells of 0.05 m" and
               one["relations"]["mean_m"] == 0.0123 and one["set_up"]["parameters"] == {"laser.yaw_deg": "off 12"} and
               one["set_up"]["notes"] == ["ranges in mm"], one)
        code, out, _ = bench.call()
        expect("the same again", code == 0 and "1 recordings, 0 moved" in out, out)

        bench.report(cpu_s=9.0)
        expect("CPU is not compared", bench.call()[0] == 0)
        bench.report(errors={"path error rms_m": 0.012}, verdict="doubtful")
        expect_moved(bench, "an error and the verdict", "errors.path error rms_m 0.01 -> 0.012 (+0.002)",
                     "verdict good -> doubtful")
        bench.report()
        bench.put("results/map.pgm", "P5\n4 2\n255\n12345679")
        bench.put("results/wrong", "")  # exit code 3 is a map, too
        before, now = one["map"], golden.entries.map_figures.digest(f"{folder}/results/map.pgm")
        expect_moved(bench, "a cell of the map", f"map {before} -> {now}")
        expect("a name that nothing begins with", bench.call("b/")[0] == 1)
        code, out, _ = bench.call("a/")
        expect("a recording that is named", code == 1 and "1 recordings, 1 moved" in out, out)

        os.rename(f"{folder}/data/a/one.log", f"{folder}/data/a/refused.log")
        os.symlink("refused.log", f"{folder}/data/a/one.log")
        bench.put("bin/marco-map", MAP.replace("*/refused.log", "*.log"))
        code, out, _ = bench.call()
        expect("a recording that is refused now", code == 1 and "refused.log: no laser" in out, out)
        del bench.environment["MARCO_TEST_DATA"]
        code, out, _ = bench.call()
        expect("without data", code == 0 and out.startswith("SKIPPED: 1 recordings: MARCO_TEST_DATA is not set"), out)

    live = {"errors": {"path error rms_m": 0.02}, "verdict": "good"}
    expect("a live run within its bounds", not golden.moved("live/x", live, {**live, "errors": {"path error rms_m": 0.029}}))
    expect("a live run beyond its bounds", golden.moved("live/x", live, {**live, "errors": {"path error rms_m": 0.031}}))
    expect("a live run's verdict", golden.moved("live/x", live, {**live, "verdict": "wrong"}))
    expect("no bounds for the others", golden.moved("x", live, {**live, "errors": {"path error rms_m": 0.0200001}}))
    print("what moves is named")


if __name__ == "__main__":
    main()
