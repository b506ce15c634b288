#!/usr/bin/env python3
"""./marco test --mutants on a project of one room: what its test notices is killed, what it does not survives, an interruption
leaves the clone as it was, and the same command continues.

usage: mutants_test.py PROJECT
"""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = os.path.abspath(sys.argv[1])
sys.path.insert(0, ROOT + "/tests/mutants")
import mutants  # noqa: E402

PRESETS = """{"version": 3, "configurePresets": [{"name": "dev", "generator": "Ninja", "binaryDir": "${sourceDir}/build/dev"}]}"""
BUILD = """cmake_minimum_required(VERSION 3.25)
project(tiny LANGUAGES CXX)
enable_testing()
add_executable(room_test room/sum.cpp tests/room_test.cpp)
add_test(NAME room_test COMMAND room_test)
"""
ROOM = """int sum_to(int last) {
  int sum = 0;
  for (int i = 0; i <= last; ++i) {
    sum += i;
  }
  return sum;
}

bool is_even(int value) {
  return value % 2 == 0;
}
"""
TEST = """int sum_to(int last);
int main() { return sum_to(4) == 10 ? 0 : 1; }
"""
BOTH = """int sum_to(int last);
bool is_even(int value);
int main() { return sum_to(4) == 10 && is_even(4) && !is_even(5) ? 0 : 1; }
"""


def expect(what, condition, said=""):
    if not condition:
        sys.exit(f"FAILED: {what}: {said}")


def git(folder, *words):
    command = ["git", "-C", folder, "-c", "user.name=t", "-c", "user.email=t@t"]
    return subprocess.run([*command, *words], check=True, capture_output=True, text=True).stdout


def project(folder):
    for path, text in {"CMakePresets.json": PRESETS, "CMakeLists.txt": BUILD, "room/sum.cpp": ROOM, "tests/room_test.cpp": TEST,
                       "tests/mutants/rooms.txt": "# room, tests\nroom  room_test\n", ".gitignore": "/build/\n"}.items():
        os.makedirs(os.path.dirname(f"{folder}/{path}"), exist_ok=True)
        with open(f"{folder}/{path}", "w", encoding="utf-8") as file:
            file.write(text)
    git(folder, "init", "-q")
    git(folder, "add", ".")
    git(folder, "commit", "-qm", "All")


# Hanging loops are waited for a second.
CALL = """import sys
sys.path.insert(0, sys.argv.pop(1))
import mutants
mutants.LEAST_PATIENCE_S, mutants.PATIENCE = 1.0, 0.0
sys.exit(mutants.main())
"""


def call(folder, *words):
    return subprocess.Popen([sys.executable, "-c", CALL, ROOT + "/tests/mutants", folder, *words], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True)


def verdicts(out):
    return dict(reversed(line.split(None, 1)) for line in out.splitlines() if line.startswith(("killed ", "SURVIVED ")))


def judge_all(folder):
    process = call(folder, "room", "60", "2")
    out, err = process.communicate()
    return process.returncode, out, err


def main():
    if not all(map(shutil.which, ("git", "cmake", "ninja"))):
        print("SKIPPED: git, cmake or ninja is not installed")
        return
    expect("a comment is no code", not list(mutants.changed_lines("  f();  // a + b, true", "x,")))
    expect("a border between measures", list(mutants.changed_lines("  if (way_m < 2) {", "")) == ["  if (way_m >= 2) {"])
    expect("a border between counts", list(mutants.changed_lines("  if (count < 2) {", "")) == ["  if (count <= 2) {"])
    expect("what others print", not list(mutants.changed_lines('  print("a + b", a + b);', ";")))
    expect("the second line of a statement", not list(mutants.changed_lines("      pose.inverse();", "  x =")))
    with tempfile.TemporaryDirectory() as folder:
        project(folder)
        # Interrupted at the second mutant that is built.
        process = call(folder, "room", "60", "2")
        expect("a first verdict", process.stdout.readline().split()[0] in ("killed", "SURVIVED", "not"))
        clone = folder + "/build/mutants/clone"
        until = time.monotonic() + 60.0
        while not git(clone, "status", "--porcelain") and time.monotonic() < until:
            time.sleep(0.005)
        process.send_signal(signal.SIGTERM)
        process.communicate()
        expect("SIGTERM ends it", process.returncode == 143, process.returncode)
        expect("SIGTERM leaves the clone as it was", git(clone, "status", "--porcelain") == "", git(clone, "diff"))

        code, out, err = judge_all(folder)
        said = verdicts(out)
        expect("the rest is judged", code == 1 and len(said) >= 3, out + err)
        expect("what the test notices is killed", said.get("room/sum.cpp:4  sum += i;  ->  sum -= i;", "killed") == "killed", out)
        expect("what the test does not notice survives", "room/sum.cpp:10  return value % 2 == 0;  ->  return value % 2 != 0;" in
               out.partition("survivors:")[2], out)
        expect("the clone is as it was", git(clone, "status", "--porcelain") == "")
        last = out.splitlines()[-1]
        again = judge_all(folder)
        expect("judged once", again[0] == 1 and not verdicts(again[1]) and again[1].splitlines()[-1] == last, again[1])
        names = [mutant.name for mutant in mutants.drawn(clone, "room", {"room": []}, 7)]
        expect("the same seed gives the same", names == [mutant.name for mutant in mutants.drawn(clone, "room", {"room": []}, 7)] and
               names != [mutant.name for mutant in mutants.drawn(clone, "room", {"room": []}, 8)])

        # A test of both functions, and of the loop's end: a mutant that hangs is killed, too.
        with open(folder + "/tests/room_test.cpp", "w", encoding="utf-8") as file:
            file.write(BOTH)
        git(folder, "commit", "-qam", "Test")
        code, out, _ = judge_all(folder)
        expect("a new commit is judged anew", code == 0 and "room/sum.cpp:10" in "".join(verdicts(out)) and "SURVIVED" not in out, out)
        expect("a mutant that hangs", "++i) {  ->  for (int i = 0; i <= last; --i)" in out, out)
        # A test that fails judges nothing.
        with open(folder + "/tests/room_test.cpp", "a", encoding="utf-8") as file:
            file.write("bool fails = (__builtin_trap(), true);\n")
        git(folder, "commit", "-qam", "Wrong")
        code, out, err = judge_all(folder)
        expect("tests that fail anyway", code == 1 and "fail on the sources as they are" in err, out + err)
    print("mutants are judged")


if __name__ == "__main__":
    main()
