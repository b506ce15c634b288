#!/usr/bin/env python3
"""The command lines of README, CONTRIBUTING, CHANGELOG and docs/: every command, option, file, program and test they name is there,
the cheap commands are run on a simulated recording, and every file they promise comes of them.

Usage: readme_test.py BIN_FOLDER PROJECT_FOLDER [--write]     --write: only renews the pages that are printed from the code
"""
import glob
import os
import re
import subprocess
import sys
import tempfile

import generated_pages

# Started on the simulated recording, in the pages' order. Of the others the words are checked.
RUN = ("map", "check", "calibrate", "render", "evaluate", "evaluate-model", "log", "plan", "python")
TOUR = """start_m = [2.0, 3.0]
[[steps]]
kind = "sweep"
pans_deg = [0]
rows = 12
[[steps]]
to_m = [5.6, 2.2]
"""
ELSEWHERE = """start_m = [4.0, 7.0]
[[steps]]
to_m = [9.0, 7.0]
"""
# Flags of these go to Google Benchmark, CTest and CMake.
FOREIGN_FLAG = re.compile(r"--(benchmark_\w+|preset|build|target|install|prefix|test-dir)$")
OF_OTHER_MAPS = {"doctor_1.png", "trajectory_as_found.tum"}  # map_verdict_test and map_set_up_test look for them
COMMAND = re.compile(r"(\./marco|marco|marco-[a-z0-9-]+|cmake|ctest|build/release/bin/\S+|tests/\S+\.(sh|py)) ")
BLOCK = re.compile(r"(\./marco|cmake|ctest) ")  # in a block programs may be boxes of a drawing

failures = []


def fail(line, what):
    failures.append(f"`{line}`: {what}")


def command_lines(text):
    """Of indented blocks and of `code` in the text; comments and the lines of pictures made of letters left out."""
    lines = []
    for line in text.splitlines():
        if line.startswith("    "):
            line = re.split(r"\s+#", line.strip())[0]
            lines += [part.strip() for part in line.split("&&") if BLOCK.match(part.strip())]
        else:
            lines += [code for code in re.findall(r"`([^`]+)`", line) if COMMAND.match(code + " ")]
    return lines


class Checker:
    def __init__(self, programs, root, folder):
        self.programs, self.root, self.folder = programs, root, folder
        self.environment = dict(os.environ, MARCO_BIN=programs)
        self.environment.pop("DISPLAY", None)  # letters on stdin instead of a window
        self.helps = {}
        self.commands = set(re.findall(r"^  \./marco ([a-z-]+)", self.run(["./marco", "help"])[1], re.M))
        self.cmake = "".join(open(path).read() for path in glob.glob(f"{root}/**/CMakeLists.txt", recursive=True)
                             if "/build/" not in path)
        self.packages = open(f"{root}/cmake/packages.cmake").read()

    def run(self, words, stdin=""):
        if words[0] == "./marco":
            words = [self.root + "/marco"] + words[1:]
        done = subprocess.run(words, cwd=self.folder, env=self.environment, input=stdin, capture_output=True, text=True,
                              timeout=600)
        return done.returncode, done.stdout, done.stderr

    def help_of(self, words):
        key = tuple(words)
        if key not in self.helps:
            code, out, err = self.run(list(words) + ["--help"])
            self.helps[key] = out if code == 0 else ""
            if code != 0:
                fail(" ".join(words), f"--help ends with {code}: {err.strip()}")
        return self.helps[key]

    def check(self, line):
        words = re.sub(r"[\[\]|]|\.\.\.", " ", line).split()
        first = words[0]
        if words in (["marco"], ["./marco"], ["marco-robot"]):  # the front door itself
            return None
        if len(words) == 1 and f"marco_package({first} " in self.packages:
            return None
        if first in ("./marco", "marco"):
            if words[1] in ("help", "--version"):
                words = words[:1] + (words[2:] or ["map"])
            if words[1] not in self.commands:
                return fail(line, f"there is no command {words[1]}")
            asked = ["./marco", words[1]]
            if words[1] == "log" and len(words) > 2:
                asked.append(words[2])
            self.check_flags(line, words, self.help_of(asked))
        elif first.startswith("marco-"):
            if not os.access(f"{self.programs}/{first}", os.X_OK):
                return fail(line, f"there is no program {first}")
            self.check_flags(line, words, self.help_of([f"{self.programs}/{first}"]))
        elif first.startswith("build/release/bin/"):
            if not re.search(r"\w\(%s\b" % re.escape(os.path.basename(first)), self.cmake):
                fail(line, f"{first} is built by nothing")
        elif first.startswith("tests/") and line.find("--") > 0:
            with open(f"{self.root}/{first}") as script:
                self.check_flags(line, words, script.read())
        if "--preset" in words:
            preset = words[words.index("--preset") + 1]
            if f'"name": "{preset}"' not in open(self.root + "/CMakePresets.json").read():
                fail(line, f"there is no preset {preset}")
        for word in words:
            if re.match(r"(config|examples|tests|docs|logs|tools|cmake)/", word) and not os.path.exists(f"{self.root}/{word}"):
                fail(line, f"there is no {word}")

    def check_flags(self, line, words, known):
        for word in words:
            flag = word.split("=")[0]
            if re.match(r"--?[a-z]", flag) and not FOREIGN_FLAG.match(flag):
                if not re.search(r"(^|[\s,/\[(\"])" + re.escape(flag) + r"(?![\w-])", known, re.M):
                    fail(line, f"{words[0]} {words[1]} has no option {flag}")


def prepare(checker):
    """A short simulated drive with a sweep and pictures as my.log and as the demo's recording, its plan as drawn.dxf, and its relations."""
    folder, root = checker.folder, checker.root
    with open(folder + "/tour.toml", "w") as tour:
        tour.write(TOUR)
    for name in ("config", "examples", "logs"):
        os.symlink(f"{root}/{name}", f"{folder}/{name}")
    os.makedirs(folder + "/out/demo")
    with open(folder + "/elsewhere.toml", "w") as tour:
        tour.write(ELSEWHERE)
    simulate = checker.programs + "/marco-simulate"
    for wanted, words in (
            (0, [simulate, "--world", "config/worlds/lab.toml", "--tour", "tour.toml", "--cameras",
                 "config/robots/michoacan.toml", "--out", "my.log"]),
            (0, [simulate, "--world", "config/worlds/office.toml", "--tour", "elsewhere.toml", "--out", "elsewhere.log"]),
            (0, ["./marco", "map", "my.log", "--out", "out/demo", "--lines"]),
            (0, ["./marco", "map", "my.log", "--out", "out/to_draw", "--sweep-meshes"]),
            (0, ["./marco", "plan", "out/to_draw"]),
            (1, ["./marco", "map", "my.log", "elsewhere.log", "--out", "out/two_buildings"])):
        code, _, err = checker.run(words)
        if code != wanted:
            sys.exit(f"FAILED: {' '.join(words)}: {err}")
    os.rename(folder + "/my.log", folder + "/out/demo/lab.lcm")
    os.symlink("out/demo/lab.lcm", folder + "/my.log")
    os.symlink("out/to_draw/plan.dxf", folder + "/drawn.dxf")
    rows = [line.split() for line in open(folder + "/out/demo/truth.tum")]
    with open(folder + "/my.relations", "w") as relations:
        relations.write(f"{rows[5][0]} {rows[-5][0]} 0 0 0 0 0 0\n")


def is_run(words):
    """Whole command lines on files: in a sentence `./marco map --many` is a name; out/run is of live runs."""
    names_file = any(re.search(r"[./]", word) for word in words[2:])
    return words[0] == "./marco" and len(words) > 1 and words[1] in RUN and names_file and not re.search(r"\bLOG\b|out/run/", " ".join(words))


def run_line(checker, line):
    words = line.split()
    code, out, err = checker.run(words, stdin="a")
    if code != 0:
        return fail(line, f"ends with {code}: {(err or out).strip()[-300:]}")
    for flag in ("--out",):
        if flag in words:
            path = f"{checker.folder}/{words[words.index(flag) + 1]}"
            if not os.path.exists(path):
                fail(line, f"wrote no {path}")
            elif path.endswith(".png") and len(set(open(path, "rb").read())) < 100:
                fail(line, f"{path} is empty")
    return None


def check_outputs(checker, text):
    """The table of what `map` writes."""
    table = text.split("| file | what |")[1].split("\n\n")[0]
    names = [name for row in table.splitlines() for name in re.findall(r"`([^`]+)`", row.split(" | ")[0])]
    if len(names) < 15:
        fail("| file | what |", "the table of outputs is not found")
    for name in names:
        if name not in OF_OTHER_MAPS and not any(glob.glob(f"{checker.folder}/out/{run}/{name}") for run in ("mine", "demo", "to_draw", "two_buildings")):
            fail(name, "no run of map writes it")


def main():
    if len(sys.argv) != 3 and sys.argv[3:] != ["--write"]:
        print(__doc__, file=sys.stderr)
        return 2
    programs, root = (os.path.abspath(path) for path in sys.argv[1:3])
    generated_pages.check(programs, root, len(sys.argv) == 4, fail)
    if len(sys.argv) == 4:
        return 0
    text = ""
    for path in [f"{root}/README.md", f"{root}/CONTRIBUTING.md", f"{root}/CHANGELOG.md", *sorted(set(glob.glob(f"{root}/docs/*.md")) - {f"{root}/docs/options.md"})]:
        with open(path) as page:
            text += page.read() + "\n"
    with tempfile.TemporaryDirectory() as folder:
        checker = Checker(programs, root, folder)
        lines = command_lines(text)
        if len(lines) < 40:
            sys.exit(f"FAILED: only {len(lines)} command lines")
        for line in lines:
            checker.check(line)
        for name in re.findall(r"`(\w+_test)`", text):
            is_file = glob.glob(f"{root}/tests/**/{name}.cpp", recursive=True)
            if not is_file and not re.search(r"(marco_test\(\s*|NAME )%s\b" % name, checker.cmake):
                fail(name, "there is no such test")
        if not failures:
            prepare(checker)
            ran = [line for line in dict.fromkeys(lines) if is_run(line.split())]
            for line in ran:
                run_line(checker, line)
            check_outputs(checker, text)
            print(f"{len(lines)} command lines, {len(ran)} of them run")
    for failure in failures:
        print("FAILED:", failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
