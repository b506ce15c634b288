#!/usr/bin/env python3
"""A newcomer's first drive: config/sim.procman's script `drive`, the arrow keys in a terminal, and the map that grows
in a picture. Run in a network of its own (isolated.sh).

Usage: newcomer.py BIN_FOLDER PROJECT_FOLDER       exit 0 = the picture was rewritten, and the map in it grew
"""
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time

PATIENCE_S = 120.0


def wait_for(what, condition):
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        result = condition()
        if result:
            return result
        time.sleep(0.1)
    sys.exit(f"FAILED: {what} never came")


def png_size(path):
    """Width and height; never half a picture: it is renamed into place."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"\x89PNG\r\n\x1a\n" or data[-8:-4] != b"IEND":
        sys.exit("FAILED: half a picture")
    return struct.unpack(">II", data[16:24])


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
        display = None
        if shutil.which("Xvfb"):
            reader, writer = os.pipe()
            display = subprocess.Popen(["Xvfb", "-displayfd", str(writer), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"],
                                       pass_fds=[writer], stderr=subprocess.DEVNULL)
            environment["DISPLAY"] = ":" + os.read(reader, 16).decode().strip()
        else:
            environment.pop("DISPLAY", None)
        sheriff = subprocess.Popen(["marco-procman-sheriff", f"{root}/config/sim.procman", "drive", "-n", "-l",
                                    "--on-script-complete", "observer", "--output"],
                                   env=environment, stdout=open(f"{folder}/sheriff.log", "w"), stderr=subprocess.STDOUT)

        def tmux(*command):
            return subprocess.run(["tmux", "-L", f"marco-newcomer-{os.getpid()}", *command], env=environment,
                                  capture_output=True, text=True).stdout
        try:
            picture = f"{folder}/map.png"
            wait_for("a first picture", lambda: os.path.exists(picture) or sheriff.poll() is not None)
            if sheriff.poll() is not None:
                sys.exit("FAILED: the sheriff ended:\n" + open(f"{folder}/sheriff.log").read())
            tmux("-f", "/dev/null", "new-session", "-d", "-x", "100", "-y", "40", "marco-teleop; sleep 1000")
            wait_for("the operator's screen", lambda: "battery" in tmux("capture-pane", "-p").lower())
            began = time.monotonic()
            seen, sizes, places = set(), [png_size(picture)], set()
            while time.monotonic() - began < 40.0:
                tmux("send-keys", "Up" if int(time.monotonic() - began) % 12 < 8 else "Left")
                time.sleep(0.2)
                seen.add(os.stat(picture).st_mtime_ns)
                sizes.append(png_size(picture))
                pose = re.search(r"pose\s+(-?\d+\.\d+)", tmux("capture-pane", "-p"))
                if pose:
                    places.add(pose.group(1))
            lasted = time.monotonic() - began
            keep = os.environ.get("MARCO_NEWCOMER_OUT")  # for who wants to see it
            if keep:
                shutil.copy(picture, keep)
            print(f"{len(seen)} pictures in {lasted:.0f} s, {len(places)} places, size {sizes[0]} -> {sizes[-1]}", flush=True)
            if len(seen) < lasted / 3:
                sys.exit("FAILED: the picture was not rewritten about every second")
            if len(places) < 5:
                sys.exit("FAILED: the keys did not move the robot:\n" + tmux("capture-pane", "-p"))
            if len(set(sizes)) < 2:
                sys.exit("FAILED: the map did not grow")
        finally:
            tmux("kill-server")
            sheriff.terminate()
            try:
                sheriff.wait(30)
            except subprocess.TimeoutExpired:
                sheriff.kill()
            if display:
                display.terminate()
                display.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
