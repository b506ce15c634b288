#!/usr/bin/env python3
"""Rooms' names in any script: every file of marco-plan keeps them, and what no installed font has is said.
usage: plan_names_test.py BIN ROOT"""
import os
import subprocess
import sys
import tempfile

BIN, ROOT = sys.argv[1], sys.argv[2]
NAME, OF_NO_FONT = "Łazienka Кухня المطبخ 厨房", "\U000f0000"


def run(program, *words):
    return subprocess.run([os.path.join(BIN, program), *words], capture_output=True, text=True, timeout=120)


def main():
    with tempfile.TemporaryDirectory() as folder:
        out, names = os.path.join(folder, "map"), os.path.join(folder, "names.txt")
        made = run("marco-map", os.path.join(ROOT, "logs/sample.lcm"), "--out", out)
        assert made.returncode in (0, 3), made.stderr
        with open(names, "wb") as file:  # as Windows' Notepad writes it
            file.write(b"\xef\xbb\xbf" + f"{NAME} {OF_NO_FONT}\r\n".encode())
        plan = run("marco-plan", out, "--names", names, "--title", b"K\xfcche")  # in Latin-1
        assert plan.returncode == 0, plan.stderr
        said = [line for line in plan.stderr.splitlines() if line.startswith("plan.pdf: no installed font has")]
        assert len(said) == 1 and OF_NO_FONT in said[0] and "Ł" not in said[0], plan.stderr
        assert f"{NAME} {OF_NO_FONT}" in plan.stdout, plan.stdout

        def text_of(name, encoding):
            with open(os.path.join(out, name), encoding=encoding) as file:
                return file.read()
        for name in ("plan.svg", "plan.json"):
            assert f'{NAME} {OF_NO_FONT}' in text_of(name, "utf-8"), name
        assert "<title>K\\xfcche</title>" in text_of("plan.svg", "utf-8")
        dxf = text_of("plan.dxf", "ascii")
        assert "\n\\U+0141azienka \\U+041A\\U+0443\\U+0445\\U+043D\\U+044F " in dxf, "plan.dxf"
        assert os.path.getsize(os.path.join(out, "plan.pdf")) > 10000


if __name__ == "__main__":
    main()
