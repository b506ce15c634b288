"""How much of the decoders the corpora reach: coverage.py BIN WORK CORPUS, run by `./marco fuzz --coverage`. Replays every
target's corpus (committed, and grown in WORK) with libFuzzer's -print_coverage and prints, for each source file of ours
that decodes bytes, the branches (edges of clang's control flow graph) that were reached by any target."""
import collections
import os
import re
import subprocess
import sys

DECODERS = re.compile(r"/(drivers/[^/]*/(codec|blocks|scans|answers|line_exchange|firmware|scip1|geometry|readings)\.cpp"
                      r"|lcmtypes/(?!generated)[^/]*\.cpp|common/files/[^/]*\.cpp|procman/(config_parser|exec_line|wire|"
                      r"command_form)[^/]*\.cpp|tools/(lcm_schema|spy|log)/[^/]*\.cpp|slam/process/checkpoint\.cpp|"
                      r"common/process/config\.cpp)$")
FUNCTION = re.compile(r"^(COVERED|UNCOVERED)_FUNC: hits: \d+ edges: (\d+)/(\d+) (.*) (/\S+):(\d+)(:\d+)?$")
MISSED = re.compile(r"^\s+UNCOVERED_PC: (?:.* )?(/\S+)$")


def replay(program, target, work, corpus):
    """Each function's edges and what of them was missed, by places in the source."""
    folders = [folder for folder in (f"{work}/{target}", f"{corpus}/{target}") if os.path.isdir(folder)]
    answer = subprocess.run([program, f"--target={target}", "-runs=0", "-print_coverage=1", "-max_len=4096", *folders],
                            capture_output=True, text=True, errors="replace", timeout=3600)
    functions, name = {}, None
    for line in answer.stderr.splitlines():
        if found := FUNCTION.match(line):
            name = (found[5], found[4]) if DECODERS.search(found[5]) else None
            if name:
                functions[name] = (int(found[3]), int(found[2]), collections.Counter())
        elif name and (found := MISSED.match(line)):
            functions[name][2][found[1]] += 1
    return functions


def main():
    programs, work, corpus = sys.argv[1], sys.argv[2], sys.argv[3]
    best = {}
    for file in sorted(os.listdir(programs)):
        if not file.startswith("fuzz_"):
            continue
        program = f"{programs}/{file}"
        targets = subprocess.run([program], capture_output=True, text=True).stdout.split()
        for target in targets:
            for name, (edges, covered, missed) in replay(program, target, work, corpus).items():
                old = best.get(name)
                if covered == 0:
                    missed = None  # everything
                if old is None or old[1] is None:
                    best[name] = (edges, missed)
                elif missed is not None:
                    best[name] = (edges, old[1] & missed)  # missed by both
    files = collections.defaultdict(lambda: [0, 0])
    for (path, _), (edges, missed) in best.items():
        files[path][0] += edges
        files[path][1] += edges if missed is None else min(edges, sum(missed.values()))
    if not files:
        print("coverage: no functions of the decoders found: is llvm-symbolizer installed?", file=sys.stderr)
        return 1
    prefix = os.path.commonpath(list(files))
    for path, (edges, missed) in sorted(files.items()):
        print(f"{os.path.relpath(path, prefix):44} {edges - missed:6}/{edges:<6} {100 * (1 - missed / edges):5.1f} %")
    edges, missed = (sum(column) for column in zip(*files.values()))
    print(f"{'all decoders':44} {edges - missed:6}/{edges:<6} {100 * (1 - missed / edges):5.1f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
