"""Faults while mapping live, each in turn while a tour is driven, or many in random order. Prints for each: is every
process alive or restarted, how far is the map from that of the undisturbed run, where does SLAM say the robot is, how
much of the recording can be read, was it said what happened. Run by `./marco soak --faults [NAME...]` in a network and
mount namespace of its own; --random MINUTES --seed N for combinations."""
import argparse
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from fault_cases import CASES, combination  # noqa: E402
from live_stack import PROCESSES, LiveStack  # noqa: E402


def compare(arguments, stack):
    """The last map against the reference's: of the last recording that has one."""
    for path in reversed(stack.recordings()):
        answer = subprocess.run([arguments.bin + "/map_difference", stack.reference, path], capture_output=True, text=True)
        if answer.returncode == 0:
            return answer.stdout.strip()
    return "no map"


def readable(arguments, stack):
    """Events that can be read of all recordings; what is torn at an end is left out."""
    events, unreadable = 0, 0
    for path in stack.recordings():
        answer = subprocess.run([arguments.bin + "/marco-log", "info", "--json", path], capture_output=True, text=True)
        found = re.search(r'"events": *([0-9]+)', answer.stdout)
        events += int(found.group(1)) if found else 0
        unreadable += not found and os.path.getsize(path) > 0
    return f"{events} events in {len(stack.recordings())} files" + (f", {unreadable} UNREADABLE" if unreadable else "")


def everything_said(stack):
    lines = [f"{process}: {state}" for process, states in stack.ear.states.items() for state in states]
    lines += [f"{process}: dropped {causes}" for process, causes in stack.ear.drops.items() if causes]
    return "\n".join(lines) + "\n" + stack.told() + stack.outputs() + stack.second_said()


def run_case(name, case, arguments, reference):
    folder = tempfile.mkdtemp(prefix="marco_faults_")
    stack = LiveStack(arguments.root, arguments.bin, folder, case.options.get("relay", False),
                      case.options.get("clock_s"))
    stack.fault_hash, stack.reference = arguments.fault_hash, reference
    if "disk_mb" in case.options:
        access = ",ro" if case.options.get("read_only") else ""
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={case.options['disk_mb']}m{access}", "tmpfs", folder + "/rec"],
                       check=True)
    result = {"name": name, "folder": folder, "told": True}
    try:
        if not stack.start():
            return dict(result, verdict="the stack did not start, see " + folder)
        before = {command: stack.starts(command) for command in PROCESSES}
        if case.options.get("before_driving"):
            case.act(stack)
        stack.driven = stack.tour()
        time.sleep(15.0)
        if case.act and not case.options.get("before_driving"):
            case.act(stack)
        result["tour"] = stack.drive(240)
        time.sleep(6.0)
        result["error_m"] = stack.slam_error_m()
        result["missing"] = [command for command, program in PROCESSES.items() if not stack.pids(program)]
        result["restarts"] = {command: stack.starts(command) - before[command] for command in PROCESSES
                              if stack.starts(command) != before[command]}
        result["drops"] = {process: causes for process, causes in stack.ear.drops.items() if causes}
    finally:
        stack.stop()
    said = everything_said(stack)
    result["told"] = case.told is None or re.search(case.told, said)
    result["note"], result["log"] = stack.note, readable(arguments, stack)
    if reference:
        result["map"] = compare(arguments, stack)
        result["recording"] = stack.recordings()[-1]
    else:
        result["recording"] = shutil.copy(stack.recordings()[-1], folder + "/reference.lcm")
    if "disk_mb" in case.options:
        subprocess.run(["umount", "-l", folder + "/rec"], check=False)
    return result


def is_good(result):
    # Both ways, and what this run has alone: a part that was drawn askew must not vanish among what is right.
    far = [float(p95) for p95 in re.findall(r"p95 ([0-9.]+)", result.get("map", ""))]
    return not result["missing"] and all(p95 <= 0.0501 for p95 in far) and result["error_m"] <= 0.05 \
        and result.get("map") != "no map" and "UNREADABLE" not in result["log"] and bool(result["told"]) \
        and result["tour"] == 0 and not re.search(r"[A-Z]{4} ", result["note"])


def print_result(result):
    if "verdict" in result:
        print(f"{result['name']:22} BAD  {result['verdict']}", flush=True)
        return False
    good = is_good(result)
    restarted = " ".join(f"{command} {count}x" for command, count in result["restarts"].items()) or "-"
    print(f"{result['name']:22} {'good' if good else 'BAD '}  missing: {','.join(result['missing']) or '-'}; restarted: "
          f"{restarted}; SLAM off {result['error_m']:.3f} m; map: {result.get('map', 'the reference')}; "
          f"log: {result['log']}; {'said' if result['told'] else 'NOT SAID'}; {result['note']}")
    if result["drops"]:
        print(f"{'':22}       drops: {result['drops']}")
    if result["tour"] != 0:
        print(f"{'':22}       the tour was not ended: {result['tour']}")
    sys.stdout.flush()
    return good


def main():
    parser = argparse.ArgumentParser(prog="marco soak --faults")
    parser.add_argument("root")
    parser.add_argument("--faults", action="store_true", help="this")
    parser.add_argument("--bin")
    parser.add_argument("--random", type=float, metavar="MINUTES", help="faults in random order and combination")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--times", type=int, default=1, metavar="N", help="each fault so often")
    parser.add_argument("--keep", action="store_true", help="the folders of all runs")
    parser.add_argument("names", nargs="*", help="; ".join(CASES).replace("%", "%%"))
    arguments = parser.parse_intermixed_args()
    arguments.bin = arguments.bin or arguments.root + "/build/release/bin"
    answer = subprocess.run([arguments.bin + "/map_difference", "--fault-fingerprint"], capture_output=True, text=True)
    arguments.fault_hash = struct.pack(">Q", int(answer.stdout, 16))
    for name in arguments.names:
        if name not in CASES:
            parser.error(f"there is no fault '{name}'; there are: {'; '.join(CASES)}")
    cases = {name: CASES[name] for name in (arguments.names or ([] if arguments.random else CASES))}
    cases.pop("undisturbed", None)
    if arguments.random:
        cases[f"random, seed {arguments.seed}"] = combination(arguments.random, arguments.seed)
    first = run_case("undisturbed", CASES["undisturbed"], arguments, None)
    good = print_result(first)
    if "verdict" in first:
        return 1
    for name, case in list(cases.items()) * arguments.times:
        result = run_case(name, case, arguments, first["recording"])
        kept = print_result(result)
        good = good and kept
        if kept and not arguments.keep:
            shutil.rmtree(result["folder"], ignore_errors=True)
        elif not kept:
            print(f"{'':22}       what it left: {result['folder']}", flush=True)
    if not arguments.keep:
        shutil.rmtree(first["folder"], ignore_errors=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
