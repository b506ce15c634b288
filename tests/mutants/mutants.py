#!/usr/bin/env python3
"""Do the short tests notice when a line is wrong? Mutants: the sources of a room with one operator, number or statement
changed; each is built and judged by the tests that rooms.txt names.

usage: mutants.py PROJECT [ROOM] [N] [SEED]

  ROOM  a folder of rooms.txt, or one below it (all)
  N     mutants that build (60)
  SEED  which ones: the same commit and seed give the same (1)

`./marco test --mutants` calls this. Works on a clone of the last commit in build/mutants, and leaves it as it was. What was
found is kept in build/mutants: after an interruption the same command continues. A survivor is a behaviour that no short
test guards, or a change that changes nothing. Tests that hang have noticed. Exit code 1: fewer than 88 % were noticed.
"""
import contextlib
import os
import random
import re
import signal
import subprocess
import sys
import time

WANTED = 0.88
COUNT, SEED = 60, 1
PATIENCE = 3.0        # a mutant's tests get so many times the time of the right ones
LEAST_PATIENCE_S = 60.0
BUILD_S = 1800.0      # where a changed line makes the compiler hang
KILLED, SURVIVED, NOT_BUILT = "killed", "SURVIVED", "not built"

# Where a line compares what is measured, the border between < and <= is of no matter: there the comparison is turned round.
CONTINUOUS = re.compile(r"_(m|mm|s|rad|deg|m2|m3|m_per_s|rad_per_s|sigma|chi2)\b|\d\.\d|norm\(|\bstd::abs\(")
BORDERS = [(r" < ", " <= "), (r" <= ", " < "), (r" > ", " >= "), (r" >= ", " > ")]
TURNED = [(r" < ", " >= "), (r" <= ", " > "), (r" > ", " <= "), (r" >= ", " < ")]
REMOVED = (r"^(\s+)[a-z_][\w.>\[\]()*-]*( [-+*/]?= |\().*;$", r"\1;")
CHANGES = [
    (r" == ", " != "), (r" != ", " == "), (r" && ", " || "), (r" \|\| ", " && "), (r" \+ ", " - "), (r" - ", " + "),
    (r" \* ", " / "), (r" / ", " * "), (r" \+= ", " -= "), (r" -= ", " += "), (r"\+\+(?=\w)", "--"),
    (r"\bmin\(", "max("), (r"\bmax\(", "min("),
    (r"\btrue\b", "false"), (r"\bfalse\b", "true"), (r"\bif \(!", "if ("), (r"\bif \((?=[a-z_][\w.]*(->\w+)?(\(\))?\))", "if (!"),
    (r"\b(?!0\.0+\b)(\d+\.\d+)\b", r"(2.0 * \1)"), (r"\breturn (?!true|false|nullptr)[a-z_]\w*;", "return {};"), REMOVED]
STATEMENT = re.compile(r"^\s+(return|throw|const|constexpr|static|auto|using|case|else|for|while|break|continue|delete)\b")
STATEMENT_ENDS = re.compile(r"([;{}:]|^\s*//.*|^)$")
NO_PRODUCT = re.compile(r"(^|/)(tests|examples|python)/|main\.cpp$")
LEFT_ALONE = re.compile(r'^\s*(//|/\*|\*|#|namespace|template|static_assert)|"|<<|\bnoexcept\(')


def run(words, **options):
    return subprocess.run(words, check=True, capture_output=True, text=True, **options).stdout


def rooms_of(root):
    with open(f"{root}/tests/mutants/rooms.txt", encoding="utf-8") as file:
        rows = [line.split() for line in file if line.strip() and not line.startswith("#")]
    return {row[0]: row[1:] for row in rows}


def room_of(path, rooms):
    """The longest folder of `rooms` that holds `path`."""
    return max((room for room in rooms if path.startswith(room + "/")), key=len, default=None)


class Mutant:
    def __init__(self, path, number, line, changed):
        self.path, self.number, self.line, self.changed = path, number, line, changed

    @property
    def name(self):
        return f"{self.path}:{self.number + 1}  {self.line.strip()}  ->  {self.changed.strip()}"


def changed_lines(line, before):
    """`line` with one change each; `before` is the line above it."""
    if LEFT_ALONE.search(line):
        return
    code, comment = re.fullmatch(r"(.*?)(\s*//.*)?", line).groups("")
    for change in (TURNED if CONTINUOUS.search(code) else BORDERS) + CHANGES:
        if change is REMOVED and (STATEMENT.search(code) or not STATEMENT_ENDS.search(before)):
            continue
        changed = re.sub(*change, code, count=1)
        if changed != code:
            yield changed + comment


def mutants_of(root, path):
    with open(f"{root}/{path}", encoding="utf-8") as file:
        lines = file.read().split("\n")
    for number, line in enumerate(lines):
        for changed in changed_lines(line, lines[number - 1] if number else ""):
            yield Mutant(path, number, line, changed)


def drawn(root, room, rooms, seed):
    """All mutants of a room in the order in which they are tried."""
    files = [path for path in run(["git", "ls-files", "*.cpp"], cwd=root).split() if not NO_PRODUCT.search(path)]
    files = [path for path in files if room_of(path, rooms) and (not room or path.startswith(room + "/"))]
    mutants = [mutant for path in files for mutant in mutants_of(root, path)]
    random.Random(seed).shuffle(mutants)
    return mutants


class Bench:
    """A clone with a build tree of its own, in which one line is changed at a time."""

    def __init__(self, root):
        self.root, self.clone = root, f"{root}/build/mutants/clone"
        self.build, self.running, self.known, self.usual_s = f"{self.clone}/build/dev", None, set(), {}

    def prepare(self):
        commit = run(["git", "rev-parse", "HEAD"], cwd=self.root).strip()
        if not os.path.exists(self.clone + "/.git"):
            run(["git", "clone", "--quiet", "--shared", self.root, self.clone])
        run(["git", "fetch", "--quiet", self.root, commit], cwd=self.clone)
        run(["git", "reset", "--quiet", "--hard", commit], cwd=self.clone)
        if not os.path.exists(self.build + "/build.ninja"):
            run(["cmake", "--preset", "dev"], cwd=self.clone)
        names = run(["ctest", "--test-dir", self.build, "-N", "-LE", "long|peers"])
        self.known = set(re.findall(r"Test +#\d+: (\S+)", names))
        return commit

    def call(self, words, patience_s):
        """@returns the exit code; None when it took too long. Whatever it started ends with it."""
        self.running = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        try:
            return self.running.wait(patience_s)
        except subprocess.TimeoutExpired:
            return None
        finally:
            self.end_running()

    def end_running(self):
        """Politely first: ninja's compilers are in groups of their own, and only ninja ends them."""
        if self.running:
            for signal_number, patience_s in ((signal.SIGTERM, 5.0), (signal.SIGKILL, None)):
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(self.running.pid, signal_number)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self.running.wait(patience_s)
            self.running = None

    def cases(self, tests):
        """CTest's names of test programs: one that is run in shards has several."""
        return [name for test in tests for name in sorted(self.known) if re.fullmatch(re.escape(test) + r"(_\d+|_alone)?", name)]

    def builds(self, tests):
        targets = {"programs" if test.endswith("_process") else test for test in tests}  # a script drives the programs
        return self.call(["ninja", "-C", self.build, *sorted(targets)], BUILD_S) == 0

    def passes(self, tests, patience_s):
        names = "|".join(re.escape(name) for name in self.cases(tests))
        return self.call(["ctest", "--test-dir", self.build, "-R", f"^({names})$", "-j", str(os.cpu_count()),
                          "--stop-on-failure"], patience_s) == 0

    def judge_unchanged(self, tests):
        """How long the tests of the right sources take [s]; without that no mutant can be judged."""
        if not self.cases(tests):
            sys.exit(f"mutants: no test is called {' or '.join(tests)}")
        if not self.builds(tests):
            sys.exit(f"mutants: {', '.join(tests)} cannot be built")
        begun = time.monotonic()
        if not self.passes(tests, None):
            sys.exit(f"mutants: {', '.join(tests)} fail on the sources as they are")
        return time.monotonic() - begun

    def judge(self, mutant, tests):
        if tuple(tests) not in self.usual_s:
            self.usual_s[tuple(tests)] = self.judge_unchanged(tests)
        path = f"{self.clone}/{mutant.path}"
        with open(path, encoding="utf-8") as file:
            whole = file.read()
        lines = whole.split("\n")
        lines[mutant.number] = mutant.changed
        try:
            with open(path, "w", encoding="utf-8") as file:
                file.write("\n".join(lines))
            if not self.builds(tests):
                return NOT_BUILT
            patience_s = max(LEAST_PATIENCE_S, PATIENCE * self.usual_s[tuple(tests)])
            return SURVIVED if self.passes(tests, patience_s) else KILLED
        finally:
            self.end_running()
            with open(path, "w", encoding="utf-8") as file:
                file.write(whole)


class Results:
    """Verdicts by mutant, in a file that begins with the commit they hold for."""

    def __init__(self, path, commit):
        self.path, self.verdicts = path, {}
        lines = []
        if os.path.exists(path):
            with open(path, encoding="utf-8") as file:
                lines = file.read().splitlines()
        if lines[:1] != [commit]:
            with open(path, "w", encoding="utf-8") as file:
                file.write(commit + "\n")
        else:
            self.verdicts = dict(reversed(line.split("\t", 1)) for line in lines[1:] if "\t" in line)

    def add(self, mutant, verdict):
        self.verdicts[mutant.name] = verdict
        with open(self.path, "a", encoding="utf-8") as file:
            file.write(f"{verdict}\t{mutant.name}\n")


def judged(bench, mutants, rooms, results, count):
    """The verdicts of the first `count` mutants that build."""
    found = []
    for mutant in mutants:
        if len(found) == count:
            break
        verdict = results.verdicts.get(mutant.name)
        if verdict is None:
            verdict = bench.judge(mutant, rooms[room_of(mutant.path, rooms)])
            results.add(mutant, verdict)
            print(f"{verdict:9} {mutant.name}", flush=True)
        if verdict != NOT_BUILT:
            found.append((verdict, mutant))
    return found


def report(found):
    """@returns the exit code."""
    survivors = [mutant for verdict, mutant in found if verdict == SURVIVED]
    if survivors:
        print("survivors:")
    for mutant in survivors:
        print(f"  {mutant.name}")
    killed = len(found) - len(survivors)
    print(f"{len(found)} mutants, {killed} killed ({killed / max(1, len(found)):.0%}; wanted {WANTED:.0%})")
    return 0 if found and killed >= WANTED * len(found) else 1


def main():
    if not 2 <= len(sys.argv) <= 5 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    root = os.path.abspath(sys.argv[1])
    words = sys.argv[2:]
    room = words.pop(0).strip("/") if words and not words[0].isdigit() else ""
    count, seed = (int(words[i]) if i < len(words) else usual for i, usual in enumerate((COUNT, SEED)))
    rooms = rooms_of(root)
    if room and not any(name == room or name.startswith(room + "/") or room.startswith(name + "/") for name in rooms):
        print(f"mutants: no room is called {room}; they are in tests/mutants/rooms.txt", file=sys.stderr)
        return 2
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    bench = Bench(root)
    os.makedirs(f"{root}/build/mutants", exist_ok=True)
    if run(["git", "status", "--porcelain", "-uno"], cwd=root):
        print("mutants: of the last commit, without the changes that are not committed yet", file=sys.stderr)
    commit = bench.prepare()
    results = Results(f"{root}/build/mutants/{room.replace('/', '_') or 'all'}_{seed}.txt", commit)
    return report(judged(bench, drawn(bench.clone, room, rooms, seed), rooms, results, count))


if __name__ == "__main__":
    sys.exit(main())
