#!/usr/bin/python3
"""What a constant of the code is worth: each one halved and doubled, and what becomes of maps.

usage: constants.py TREE BUILD LOG[:TRUTH.tum] ... [--files REGEX] [--only REGEX] [--factors 0.5,2] [--jobs 1]

TREE is a copy of the sources that may be changed, BUILD a configured build tree of it. Numbers of the form
`constexpr double kName = ...;` in the .cpp files that match --files (default: those that decide about a map) are made
variables, which one environment variable multiplies; marco-map is built once, and run once for each constant, factor
and log. A row is printed where a map changes: the error over the poses (TRUTH, or the log's own), loop closures, the
verdict, and how far the path moves at most. Constants that change nothing are listed in the end: these logs do not need
them. Not varied: what the compiler needs (sizes of arrays), and gates in headers, which docs/gates.md lists.
"""
import argparse
import concurrent.futures
import glob
import json
import math
import os
import re
import subprocess
import sys
import tempfile

FILES = r"(slam|common/input)/(?!.*(known_plan|landmarks|localization|plan|session|process)/).*\.cpp$"
DECLARED = re.compile(r"^(\s*)constexpr (double|float|int|std::size_t) (k[A-Z]\w*\s*=[^;{]*);", re.M)
PART = re.compile(r"(k[A-Z]\w*)\s*=\s*((?:[^,(]|\([^)]*\))+)")
HEADER = """#pragma once
#include <cstdlib>
#include <cstring>
namespace marco {
// MARCO_VARY: NAME=FACTOR.
template <class T>
T varied(const char* name, T value) {
  const char* wish = std::getenv("MARCO_VARY");
  const std::size_t length = std::strlen(name);
  if (wish == nullptr || std::strncmp(wish, name, length) != 0 || wish[length] != '=') return value;
  return static_cast<T>(static_cast<double>(value) * std::atof(wish + length + 1));
}
}  // namespace marco
"""


def rewrite(tree, files, refused):
    """Makes variables of the constants. @returns their names, FILE:NAME."""
    names = []
    with open(f"{tree}/varied.hpp", "w", encoding="utf-8") as file:
        file.write(HEADER)
    for path in files:
        original = path + ".original"
        if not os.path.exists(original):
            os.rename(path, original)
        with open(original, encoding="utf-8") as file:
            text = file.read()
        short = os.path.relpath(path, tree)

        def declaration(found):
            indent, kind, parts = found.groups()
            pairs = PART.findall(parts)
            if not pairs or any(f"{short}:{name}" in refused for name, _ in pairs):
                return found.group(0)
            names.extend(f"{short}:{name}" for name, _ in pairs)
            variables = ", ".join(f'{name} = marco::varied<{kind}>("{short}:{name}", {value})' for name, value in pairs)
            return f"{indent}static const {kind} {variables};"

        changed = DECLARED.sub(declaration, text)
        with open(path, "w", encoding="utf-8") as file:
            file.write('#include "varied.hpp"\n' + changed)
    return names


def build(options):
    """@returns the names of what can be varied, once the compiler takes it."""
    files = sorted(path for path in glob.glob(f"{options.tree}/**/*.cpp", recursive=True)
                   if re.match(options.files, os.path.relpath(path, options.tree)))
    refused = set()
    while True:
        names = rewrite(options.tree, files, refused)
        done = subprocess.run(["ninja", "-C", options.build, "-k", "0", "marco-map"], capture_output=True, text=True)
        if done.returncode == 0:
            return names
        told = set()
        for line in done.stdout.splitlines():
            found = re.match(r"(\S+\.cpp):\d+:\d+: (?:error|note): (.*)", line)
            if found:
                short = os.path.relpath(found.group(1), options.tree)
                told |= {f"{short}:{name}" for name in re.findall(r"k[A-Z]\w*", found.group(2))}
        told = (told & set(names)) - refused
        if not told:
            sys.exit(done.stdout)
        print("not varied, for the compiler needs it:", *sorted(told), file=sys.stderr)
        refused |= told


def path_of(folder):
    with open(f"{folder}/trajectory.tum", encoding="utf-8") as file:
        return [tuple(map(float, line.split()[:3])) for line in file if not line.startswith("#")]


def mapped(options, log, wish):
    """@returns the path, and what is said of the map."""
    recording, _, truth = log.partition(":")
    with tempfile.TemporaryDirectory() as out:
        command = [f"{options.build}/bin/marco-map", recording, "--out", out]
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "MARCO_VARY": wish})
        if done.returncode not in (0, 3):
            return [], {"failed": done.stderr.strip().splitlines()[-1:]}
        with open(f"{out}/report.json", encoding="utf-8") as file:
            report = json.load(file)
        path = path_of(out)
        said = {"verdict": report.get("verdict", {}).get("verdict") if isinstance(report.get("verdict"), dict) else report.get("verdict"),
                "loops": report.get("loop_closures")}
        if truth:
            said["rms_m"] = rms_m(path, truth)
        elif "errors" in report:
            said["rms_m"] = report["errors"].get("path error rms_m")
        return path, said


def rms_m(path, truth):
    """Over the poses with a true one, after the best fit in the plane."""
    with open(truth, encoding="utf-8") as file:
        true = {round(float(line.split()[0]), 3): tuple(map(float, line.split()[1:3])) for line in file if line[0] != "#"}
    pairs = [((x, y), true[round(t, 3)]) for t, x, y in path if round(t, 3) in true]
    if not pairs:
        return None
    a = [complex(*p) for p, _ in pairs]
    b = [complex(*q) for _, q in pairs]
    am, bm = sum(a) / len(a), sum(b) / len(b)
    turn = sum((q - bm) * (p - am).conjugate() for p, q in zip(a, b))
    turn /= abs(turn) or 1.0
    return math.sqrt(sum(abs(turn * (p - am) - (q - bm)) ** 2 for p, q in zip(a, b)) / len(a))


def moved_m(path, other):
    return max((math.dist(p[1:], q[1:]) for p, q in zip(path, other)), default=0.0) if len(path) == len(other) else math.inf


def text(said):
    return "  ".join(f"{key} {value:.4f}" if isinstance(value, float) else f"{key} {value}" for key, value in said.items())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tree")
    parser.add_argument("build")
    parser.add_argument("logs", nargs="+")
    parser.add_argument("--files", default=FILES)
    parser.add_argument("--only", default=".")
    parser.add_argument("--factors", default="0.5,2")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    options.tree = os.path.realpath(options.tree)
    names = [name for name in build(options) if re.search(options.only, name)]
    usual = {log: mapped(options, log, "") for log in options.logs}
    for log, (_, said) in usual.items():
        print(f"as it is: {os.path.basename(log)}: {text(said)}", flush=True)
    jobs = [(name, factor, log) for name in names for factor in options.factors.split(",") for log in options.logs]
    changes = {name: 0 for name in names}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        results = pool.map(lambda job: mapped(options, job[2], f"{job[0]}={job[1]}"), jobs)
        for (name, factor, log), (path, said) in zip(jobs, results):
            if path == usual[log][0] and said == usual[log][1]:
                continue
            changes[name] += 1
            print(f"{name} x{factor}  {os.path.basename(log).partition(':')[0]}  {text(said)}  moves {moved_m(path, usual[log][0]):.4f} m", flush=True)
    print("changed nothing:", *(name for name in names if changes[name] == 0), sep="\n  ")


if __name__ == "__main__":
    main()
