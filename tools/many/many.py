#!/usr/bin/python3 -I
"""marco map --many: see HELP. marco-recordings finds the recordings, marco-map maps each in a process of its own.

Results: OUT/NAME of each recording, as marco-map writes it, and OUT/jobs with the list of recordings, what each run printed
(NAME.log), why one failed (NAME.json) and a journal.
"""
import argparse
import collections
import contextlib
import csv
import ctypes
import dataclasses
import difflib
import fcntl
import html
import io
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import textwrap
import time

PROGRAM = "marco-map-many"
HELP = """\
Maps many recordings, each once: marco map --many DIR|LIST... --out OUT [--jobs N] [-- OPTIONS OF marco map]

DIR: every recording in it and in its folders; LIST: a text file with one recording per line. The parts of a split ROS recording
(NAME_0.bag, NAME_1.bag, ...) are one. OUT/NAME gets the results of each, as `marco map` writes them; OUT/index.html and
OUT/table.csv list all: log, format, scans, length, loops, verdict, CPU, picture. After an interruption the same command
continues, and repeats nothing. A recording that cannot be mapped is in the table with the reason; delete
OUT/jobs/NAME.json to retry it. Exit code: 0 all were mapped, 1 some could not be.
"""
OPTIONS = """\
Usage: marco-map-many [OPTIONS] [INPUT...]

Positionals:
  INPUT TEXT ...              folders, lists or recordings

Options:
  -h,--help                   Print this help message and exit
  --out TEXT=out              folder for all results
  --jobs INT:INT in [1 - 10000]
                              maps at a time (default: the number of processors)
  --slurm                     submit them to Slurm as an array job, and return
  --table                     only write the table of existing results
  --task UINT                 only map the Nth of OUT/jobs/list.tsv
  --version                   print the version and exit

"""
EXIT_DONE, EXIT_FAILED, EXIT_USAGE, EXIT_SIGNAL = 0, 1, 2, 128
MOST_TRIES = 5
CRASHES = (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL)
HERE = pathlib.Path(os.path.realpath(__file__)).parent
TEXT = {"encoding": "utf-8", "errors": "surrogateescape"}  # file names may not be UTF-8


class Failure(Exception):
    """A message for the user."""


@dataclasses.dataclass
class Entry:
    """A recording, and the name of its results' folder. Parts: absolute paths."""
    name: str
    parts: list


class Store:
    """The folder of all results, and the paths in it."""

    def __init__(self, out):
        self.out = pathlib.Path(os.path.join(os.getcwd(), out))
        self.jobs = self.out / "jobs"
        self.list = self.jobs / "list.tsv"

    def report(self, entry):
        return self.out / entry.name / "report.json"

    def failure(self, entry):
        return self.jobs / f"{entry.name}.json"

    def printed(self, entry):
        return self.jobs / f"{entry.name}.log"

    def is_done(self, entry):
        """Whether there is nothing left to do: a map was made, or it is known why there can be none."""
        return self.report(entry).exists() or self.failure(entry).exists()

    def note(self, entry, what):
        # One write a line: lines of several processes do not mix.
        with contextlib.suppress(OSError), open(self.jobs / "journal.csv", "a", **TEXT) as file:
            file.write(f"{time.time():.3f},{entry.name},{what}\n")


def printable(text):
    """For a terminal: control characters, and bytes that are not UTF-8, as escapes."""
    def escape(found):
        code = ord(found[0])
        return f"\\x{code & 0xff:02x}" if code < 0x100 or code >= 0xd800 else f"\\u{code:04x}"
    return re.sub("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\udc80-\udcff]", escape, text)


def say(text):
    print(printable(text), file=sys.stderr)


@contextlib.contextmanager
def locked(path):
    """Waits for the lock. The system lets go of it when this process ends, however it does."""
    with open(path, "a", **TEXT) as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield file


def read_whole(path):
    return path.read_bytes().decode(**TEXT)


def is_still(file, path):
    """Whether a file that was opened by this path still has it."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))
    except FileNotFoundError:
        return False


def write_whole(path, text):
    """No reader sees half of it, nor does another writer."""
    part = path.with_name(path.name + ".part")
    while True:
        with locked(part) as file:
            if not is_still(file, part):  # the process that held the lock before has renamed it
                continue
            file.truncate(0)
            file.buffer.write(text.encode(**TEXT))
            file.flush()
            os.fsync(file.fileno())
            os.replace(part, path)
            return


# Recordings and their names

def find_recordings(inputs):
    """The recordings that folders, lists and files mean, as lists of parts."""
    asked = subprocess.run([HERE / "marco-recordings", "--", *inputs], capture_output=True, check=False, **TEXT)
    if asked.returncode != 0:
        raise Failure(asked.stderr.strip().removeprefix("marco-recordings: "))
    return [line.split("\t") for line in asked.stdout.splitlines()]


def plain_name(parts):
    """What can be a folder's name, and a word of a shell."""
    name = pathlib.Path(parts[0]).stem
    while name.endswith((".bag", ".mcap", ".db3")):
        name = name[:name.rindex(".")]
    if len(parts) > 1:
        name = name.rstrip("0123456789_") or name
    name = re.sub("[^A-Za-z0-9.-]", "_", os.fsencode(name).decode("latin-1"))
    if not name or name.startswith("."):
        name = "log" + name
    return "jobs_log" if name == "jobs" else name


def with_names(earlier, recordings):
    """Adds recordings to those of an earlier run, which keep their names; one of which a part is there already is not added.

    Names are those of files and folders without their endings, and a number where two are alike.
    """
    entries = list(earlier)
    names = {entry.name for entry in entries}
    known = {part for entry in entries for part in entry.parts}
    for parts in recordings:
        if not known.isdisjoint(parts):
            continue
        known.update(parts)
        plain = name = plain_name(parts)
        number = 2
        while name in names:
            name, number = f"{plain}_{number}", number + 1
        names.add(name)
        entries.append(Entry(name, parts))
    return entries


def read_list(path):
    """One a line: name and paths, tabs between them. A file that is not there holds none."""
    if not path.exists():
        return []
    rows = (line.split("\t") for line in read_whole(path).split("\n"))
    return [Entry(name, parts) for name, *parts in rows if parts]


def write_list(path, entries):
    write_whole(path, "".join("\t".join([entry.name, *entry.parts]) + "\n" for entry in entries))


# One recording

LIBC = ctypes.CDLL(None)


def start(words, output):
    """Starts a program, both outputs appended to a file. It is killed when this process ends before it: what it works on
    may be begun again at once. @returns its id"""
    PR_SET_PDEATHSIG, NOT_STARTED = 1, 127
    parent = os.getpid()
    child = os.fork()
    if child:
        return child
    try:
        LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        file = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        os.dup2(file, 1)
        os.dup2(file, 2)
        if os.getppid() == parent:
            os.execv(words[0], words)
    finally:
        os._exit(NOT_STARTED)


@dataclasses.dataclass
class ChildEnd:
    """How a process ended; `code` is negative where a signal ended it."""
    pid: int
    code: int
    cpu_s: float  # with that of its own children

    def was_killed(self):
        return (self.code < 0 and -self.code not in CRASHES) or self.code > EXIT_SIGNAL


def wait_for(pid):
    """Waits for one child, or for any (-1)."""
    pid, status, used = os.wait4(pid, 0)
    return ChildEnd(pid, os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime)


def last_line(path):
    """What a program said last: why it failed. A progress line writes over itself."""
    lines = (line.split("\r")[-1] for line in read_whole(path).split("\n"))
    return next(filter(None, reversed(list(lines))), "")


def record_failure(store, entry, message, cpu_s):
    message = message.encode(**TEXT).decode("utf-8", "replace")
    write_whole(store.failure(entry), json.dumps({"cpu_s": cpu_s, "message": message}, indent=2, ensure_ascii=False) + "\n")
    store.note(entry, "failed")


def try_once(store, entry, for_map):
    """Maps it once. @returns None where the results are there"""
    store.printed(entry).unlink(missing_ok=True)
    words = [HERE / "marco-map", *entry.parts, "--out", store.out / entry.name, *for_map]
    end = wait_for(start(words, store.printed(entry)))
    return None if store.report(entry).exists() else end


def run_job(store, entry, for_map):
    """Maps one recording, unless that is done; waits where somebody else does it now. A process killed meanwhile leaves
    nothing behind: a lock ends with its process, results appear as a whole. @returns whether there is a map"""
    with locked(store.jobs / f"{entry.name}.lock"):
        if store.is_done(entry):
            return store.report(entry).exists()
        store.note(entry, "begun")
        failed = try_once(store, entry, for_map)
        # A program that marco-map started may have been killed: what fails twice fails always.
        if failed and not failed.was_killed():
            failed = try_once(store, entry, for_map)
        if not failed:
            store.note(entry, "done")
        elif failed.was_killed():
            store.note(entry, "killed")
        else:
            message = f"crashed: signal {-failed.code}" if failed.code < 0 else last_line(store.printed(entry))
            record_failure(store, entry, message, failed.cpu_s)
        return not failed


# All of them

class Interrupts:
    """The first SIGINT, SIGTERM or SIGHUP is noted, so that the command can clean up; the second ends it."""

    def __init__(self):
        self.number = 0

    def catch(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self.take)

    def take(self, number, _frame):
        if self.number:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        self.number = number


INTERRUPTS = Interrupts()


def run_jobs(store, entries, jobs, command):
    """Does what is not done yet, `jobs` at a time, each in a process of its own (--task). One that is killed is begun again
    when the others are through, five times at most. Ctrl-C: waits for those that run, which get the same signal, and
    begins no others. @param command  the arguments that every task has"""
    waiting = collections.deque(i for i, entry in enumerate(entries) if not store.is_done(entry))
    running, tries, done, begun_with = {}, collections.Counter(), 0, len(waiting)
    while running or (waiting and not INTERRUPTS.number):
        while len(running) < jobs and waiting and not INTERRUPTS.number:
            i = waiting.popleft()
            tries[i] += 1
            words = [os.path.realpath(__file__), "--task", str(i + 1), *command]
            running[start(words, store.printed(entries[i]))] = i
        if not running:
            break
        end = wait_for(-1)
        i = running.pop(end.pid)
        if store.is_done(entries[i]):
            done += 1
            say(f"[{done}/{begun_with}] {entries[i].name}")
        elif tries[i] < MOST_TRIES:
            waiting.append(i)
        elif not INTERRUPTS.number:
            record_failure(store, entries[i], "was killed five times", end.cpu_s)


# Slurm

def array_of(numbers):
    """Numbers as Slurm's --array takes them: "1-3,7"."""
    ranges = []
    for number in numbers:
        if ranges and ranges[-1][1] == number - 1:
            ranges[-1][1] = number
        else:
            ranges.append([number, number])
    return ",".join(f"{first}-{last}" if last > first else str(first) for first, last in ranges)


def quoted(word):
    """A word that a shell takes as it is."""
    return "'" + str(word).replace("'", "'\\''") + "'"


def submitted(*arguments):
    """The number of the job that sbatch --parsable prints, "4711" or "4711;cluster"."""
    try:
        said = subprocess.run(["sbatch", "--parsable", *arguments], stdout=subprocess.PIPE, check=True, text=True).stdout
        return re.match("[0-9]+", said)[0]
    except (OSError, subprocess.CalledProcessError, TypeError):
        raise Failure("sbatch did not accept the job (apt-get install slurm-client)") from None


def write_script(path, options, task):
    write_whole(path, "#!/bin/bash\n" + "".join(f"#SBATCH {option}\n" for option in options) + f"exec {task}\n")


def submit(store, entries, jobs, command):
    """Submits what is not done yet as one array job, `jobs` tasks at a time, and a job behind it that writes the table. Slurm
    schedules them and begins those of a broken node again. @returns a line for the user"""
    numbers = [i + 1 for i, entry in enumerate(entries) if not store.is_done(entry)]
    program = quoted(os.path.realpath(__file__))
    words = "".join(f" {quoted(word)}" for word in command)
    array_script, table_script = store.jobs / "array.sbatch", store.jobs / "table.sbatch"
    # A relative pattern of names: Slurm would read % in a folder's own name.
    write_script(array_script, ["--job-name=marco-map", "--cpus-per-task=1", "--requeue", "--open-mode=append",
                                "--output=slurm_%a.log"], f'{program} --task "$SLURM_ARRAY_TASK_ID"{words}')
    write_script(table_script, ["--job-name=marco-table", "--output=slurm_table.log"],
                 f"{program} --table --out {quoted(store.out)}")
    where, after, said = f"--chdir={store.jobs}", [], "nothing left to do; "
    if numbers:
        number = submitted(where, f"--array={array_of(numbers)}%{jobs}", array_script)
        after = [f"--dependency=afterany:{number}"]
        said = f"{len(numbers)} tasks of job {number}; "
    number = submitted(where, *after, table_script)
    return f"{said}job {number} writes the table to {store.out / 'index.html'}"


# The table

VERDICTS = ("good", "doubtful", "wrong", "failed", "not done")
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Maps</title><style>
body { font: 15px sans-serif; margin: 2em; }
table { border-collapse: collapse; }
th, td { border-bottom: 1px solid #ccc; padding: 4px 10px; text-align: left; vertical-align: middle; }
td.n { text-align: right; }
img { max-width: 200px; max-height: 120px; }
.good { color: #060; } .doubtful { color: #a60; } .wrong, .failed { color: #b00; }
</style></head><body>
"""


@dataclasses.dataclass
class Row:
    """The result of one recording."""
    name: str
    path: str
    format: str = ""
    scans: int = 0
    length_m: float = 0.0
    loops: int = 0  # in force
    verdict: str = "not done"
    reason: str = ""  # why it failed
    cpu_s: float = 0.0
    picture: str = ""


def row_of(store, entry):
    """From its report.json, or the record of its failure."""
    row = Row(entry.name, "; ".join(entry.parts))
    if store.report(entry).exists():
        report = json.loads(store.report(entry).read_text("utf-8", "replace"))
        row.format = ", ".join(one.get("format", "") for one in report.get("inputs", []))
        row.scans = report.get("scans", {}).get("posed", 0)
        row.length_m = report.get("distance_m", 0.0)
        row.loops = sum(loop.get("in_force", False) for loop in report.get("loops", []))
        row.verdict = report.get("verdict", "none")
        row.cpu_s = report.get("cpu_s", 0.0)
        if (store.out / entry.name / "map.png").exists():
            row.picture = f"{entry.name}/map.png"
    elif store.failure(entry).exists():
        failure = json.loads(store.failure(entry).read_text("utf-8", "replace"))
        row.verdict, row.reason, row.cpu_s = "failed", failure.get("message", ""), failure.get("cpu_s", 0.0)
    return row


def csv_of(rows):
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["log", "format", "scans", "length_m", "loops", "verdict", "cpu_s", "picture", "reason", "path"])
    for row in rows:
        writer.writerow([row.name, row.format, row.scans, f"{row.length_m:.2f}", row.loops, row.verdict, f"{row.cpu_s:.2f}",
                         row.picture, row.reason, row.path])
    return text.getvalue()


def safe(text):
    return html.escape(text, quote=False).replace('"', "&quot;")


def html_of(rows):
    """The same as a page, with pictures; its links are relative to the folder of all results."""
    counts = collections.Counter(row.verdict for row in rows)
    text = PAGE + f"<p>{len(rows)} recordings" + "".join(f", {counts[verdict]} {verdict}" for verdict in VERDICTS)
    text += ("</p>\n<table><tr><th>log<th>format<th>scans<th>length, m<th>loops<th>verdict<th>CPU, "
             "s<th>map</tr>\n")
    for row in rows:
        name, verdict = safe(row.name), safe(row.verdict)
        log = f"jobs/{name}.log" if row.verdict == "failed" else f"{name}/report.json"
        reason = f": {safe(row.reason)}" if row.reason else ""
        picture = safe(row.picture)
        picture = picture and f'<a href="{picture}"><img loading=lazy alt="map" src="{picture}"></a>'
        text += (f'<tr><td title="{safe(row.path)}"><a href="{log}">{name}</a><td>{safe(row.format)}<td class=n>{row.scans}'
                 f'<td class=n>{row.length_m:.1f}<td class=n>{row.loops}<td class="{verdict}">{verdict}{reason}'
                 f"<td class=n>{row.cpu_s:.1f}<td>{picture}</tr>\n")
    return text + "</table></body></html>\n"


def write_table(store, entries):
    """@returns the exit code"""
    rows = [row_of(store, entry) for entry in entries]
    write_whole(store.out / "table.csv", csv_of(rows))
    write_whole(store.out / "index.html", html_of(rows))
    counts = collections.Counter(row.verdict for row in rows)
    text = "".join(f", {count} {verdict}" for verdict, count in sorted(counts.items()))
    print(printable(f"{len(rows)} recordings{text}; the table is in {store.out / 'index.html'}"))
    return EXIT_FAILED if counts["failed"] or counts["not done"] else EXIT_DONE


# The command line

def print_help():
    width = max(80, min(shutil.get_terminal_size((100, 24)).columns if sys.stdout.isatty() else 100, 120))
    for paragraph in HELP.split("\n\n"):
        print(textwrap.fill(" ".join(paragraph.split()), width, break_on_hyphens=False, break_long_words=False))
        print(end="" if paragraph.endswith("\n") else "\n")
    print(OPTIONS, end="")


def print_version():
    said = subprocess.run([HERE / "marco-map", "--version"], stdout=subprocess.PIPE, check=True, text=True).stdout
    print(said.replace("marco-map", PROGRAM, 1), end="")


class Parser(argparse.ArgumentParser):
    def error(self, message):
        say(f"{PROGRAM}: {message.removeprefix('argument ')}\nTry {PROGRAM} --help")
        sys.exit(EXIT_USAGE)


def number_in(least, most):
    def parsed(word):
        if not word.isdecimal() or not least <= int(word) <= most:
            raise argparse.ArgumentTypeError(f"Value {word} not in range {least} to {most}")
        return int(word)
    return parsed


def parse(words):
    """@returns the arguments, or None where help or version was all that was wanted"""
    end = words.index("--") if "--" in words else len(words)
    parser = Parser(add_help=False, allow_abbrev=False)
    parser.add_argument("inputs", nargs="*")
    parser.add_argument("--out", default="out")
    parser.add_argument("--jobs", type=number_in(1, 10000), default=os.cpu_count() or 1)
    parser.add_argument("--task", type=number_in(0, sys.maxsize), default=0)
    flags = ("-h", "--help", "--slurm", "--table", "--version")
    for flag in flags[1:]:
        parser.add_argument(*(["-h"] if flag == "--help" else []), flag, action="store_true")
    arguments, unknown = parser.parse_known_intermixed_args(words[:end])
    if unknown:
        name = unknown[0].split("=")[0]
        near = difflib.get_close_matches(name, [*flags, "--out", "--jobs", "--task"], 1, 2 / 3)
        parser.error(f"unknown option '{name}'" + (f"; did you mean '{near[0]}'?" if near else ""))
    arguments.for_map = words[end + 1:]
    if arguments.help:
        print_help()
    elif arguments.version:
        print_version()
    else:
        return arguments
    return None


def keep_options(store, for_map):
    """What the maps of a folder were made with: others would not be comparable."""
    text = "".join(f"{quoted(word)}\n" for word in for_map)
    path = store.jobs / "options"
    if not path.exists():
        write_whole(path, text)
    elif read_whole(path) != text:
        raise Failure(f"{store.out}: its maps were made with other options of marco map ({path}); choose another --out")


def run(arguments):
    store = Store(arguments.out)
    if arguments.task:
        entries = read_list(store.list)
        if arguments.task > len(entries):
            raise Failure(f"{store.list}: has no line {arguments.task}")
        return EXIT_DONE if run_job(store, entries[arguments.task - 1], arguments.for_map) else EXIT_FAILED
    if arguments.table:
        return write_table(store, read_list(store.list))
    INTERRUPTS.catch()
    entries = with_names(read_list(store.list), find_recordings(arguments.inputs) if arguments.inputs else [])
    if not entries:
        raise Failure("name recordings, a folder of them, or a list")
    store.jobs.mkdir(parents=True, exist_ok=True)
    keep_options(store, arguments.for_map)
    write_list(store.list, entries)
    command = ["--out", str(store.out), "--", *arguments.for_map]
    if arguments.slurm:
        print(printable(submit(store, entries, arguments.jobs, command)))
        return EXIT_DONE
    run_jobs(store, entries, arguments.jobs, command)
    if INTERRUPTS.number:
        raise Failure("interrupted")
    return write_table(store, entries)


def finish_stdout():
    try:
        print(end="", flush=True)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for what is left of it
        raise Failure(f"standard output is not complete: {error.strerror}") from None


def main():
    for number in (signal.SIGINT, signal.SIGPIPE):
        signal.signal(number, signal.SIG_DFL)
    try:
        arguments = parse(sys.argv[1:])
        code = run(arguments) if arguments else EXIT_DONE
        finish_stdout()
        return code
    except (Failure, OSError, ValueError, subprocess.CalledProcessError) as failure:
        if not INTERRUPTS.number:
            say(f"{PROGRAM}: {failure}")
            return EXIT_FAILED
        # The same Ctrl-C ended the programs that this one started: their complaints are no news.
        say(f"{PROGRAM}: interrupted; the same command continues")
        return EXIT_SIGNAL + INTERRUPTS.number


if __name__ == "__main__":
    sys.exit(main())
