#!/usr/bin/env python3
"""A newcomer's first drive: config/sim.procman's script `drive`, the arrow keys in a terminal, and the map that grows
on the page. Run in a network of its own (isolated.sh).

Usage: newcomer.py BIN_FOLDER PROJECT_FOLDER       exit 0 = the keys drove, and the map on the page grew
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "web"))
from page_client import Client, http_get  # noqa: E402

PATIENCE_S = 120.0
PAGE_PORT = 8765


def wait_for(what, condition):
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        result = condition()
        if result:
            return result
        time.sleep(0.1)
    sys.exit(f"FAILED: {what} never came")


def page_answers():
    try:
        return http_get(PAGE_PORT, "/")
    except OSError:
        return False


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    if shutil.which("tmux") is None:
        print("SKIPPED: tmux is not installed")
        return 0
    programs, root = (os.path.abspath(folder) for folder in sys.argv[1:])
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}", MARCO_ROOT=root, MARCO_RUN=folder,
                           HOME=folder)
        environment.setdefault("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=0")
        os.makedirs(f"{folder}/ports")
        sheriff = subprocess.Popen(["marco-procman-sheriff", f"{root}/config/sim.procman", "drive", "-n", "-l",
                                    "--on-script-complete", "observer", "--output"],
                                   env=environment, stdout=open(f"{folder}/sheriff.log", "w"), stderr=subprocess.STDOUT)

        def tmux(*command):
            return subprocess.run(["tmux", "-L", f"marco-newcomer-{os.getpid()}", *command], env=environment,
                                  capture_output=True, text=True).stdout
        try:
            # Its port is open as soon as it runs.
            wait_for("the page", lambda: page_answers() or sheriff.poll() is not None)
            if sheriff.poll() is not None:
                sys.exit("FAILED: the sheriff ended:\n" + open(f"{folder}/sheriff.log").read())
            page = Client(PAGE_PORT)
            page.subscribe("page/tiles")
            tmux("-f", "/dev/null", "new-session", "-d", "-x", "100", "-y", "40", "marco-teleop; sleep 1000")
            wait_for("the operator's screen", lambda: "battery" in tmux("capture-pane", "-p").lower())
            if not page.wait(lambda: page.of("page/tiles"), PATIENCE_S):
                sys.exit("FAILED: no map on the page")
            began = time.monotonic()
            places = set()
            while time.monotonic() - began < 40.0:
                tmux("send-keys", "Up" if int(time.monotonic() - began) % 12 < 8 else "Left")
                page.step(0.2)
                pose = re.search(r"pose\s+(-?\d+\.\d+)", tmux("capture-pane", "-p"))
                if pose:
                    places.add(pose.group(1))
            revisions = [tiles["revision"] for tiles in page.of("page/tiles")]
            print(f"{len(revisions)} changes of the map, {len(places)} places", flush=True)
            if len(set(revisions)) < 10:
                sys.exit("FAILED: the map did not grow")
            if len(places) < 5:
                sys.exit("FAILED: the keys did not move the robot:\n" + tmux("capture-pane", "-p"))
        finally:
            tmux("kill-server")
            sheriff.terminate()
            try:
                sheriff.wait(30)
            except subprocess.TimeoutExpired:
                sheriff.kill()
    return 0


if __name__ == "__main__":
    sys.exit(main())
