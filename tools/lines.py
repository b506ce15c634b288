#!/usr/bin/env python3
"""Counts the lines of the tracked sources by room, beside the budget in tools/lines.txt. `./marco lint --lines` calls this.

usage: lines.py [--write]     --write: the budget becomes today's figures, each rounded up to the next ten

product, emulators and lcm_tools are what users run: all *.cpp and *.hpp but those in a folder tests, examples or python.
Exit code 1: a room is above its budget, or has none. Settings, headers with one user, and functions of more than 60 lines
are printed beside their budgets, and do not fail.
"""
import collections
import os
import re
import subprocess
import sys

BUDGET = "tools/lines.txt"
BY_SECOND_FOLDER = ("common", "drivers", "slam", "tools")
NO_PRODUCT = re.compile(r"(^|/)(tests|examples|python)/")
LONGEST_FUNCTION = 60  # as .clang-tidy has it
SETTINGS, ONE_USER, LONG_FUNCTIONS = "settings", "headers_with_one_user", "functions_over_60_lines"

EMULATOR = re.compile(r"^simulator/devices/")


def tracked(*patterns):
    names = subprocess.run(["git", "ls-files", *patterns], capture_output=True, text=True, check=True).stdout.split()
    return [name for name in names if os.path.exists(name)]


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def room_of(path):
    """Where a C++ file is counted: (kind, room); the room of what is no product is its kind."""
    beside = NO_PRODUCT.search(path)
    if beside:
        return beside[2], beside[2]
    if path.startswith("lcm_tools/"):
        return "lcm_tools", "lcm_tools"
    if EMULATOR.match(path):
        return "emulators", "emulators"
    folders = path.split("/")[:-1]
    return "product", "/".join(folders[:2] if folders[0] in BY_SECOND_FOLDER else folders[:1])


def counted_lines():
    """Lines by kind and by room, and those of `total`: product, emulators and lcm_tools together."""
    kinds, rooms = collections.Counter(), collections.Counter()
    for path in tracked("*.cpp", "*.hpp"):
        kind, room = room_of(path)
        count = text_of(path).count("\n")
        kinds[kind] += count
        rooms[room] += count
    kinds["page"] = rooms["page"] = sum(text_of(path).count("\n") for path in tracked("web/*.js", "web/*.html", "web/*.css"))
    kinds["total"] = rooms["total"] = kinds["product"] + kinds["emulators"] + kinds["lcm_tools"]
    return kinds, rooms


def counted_settings():
    """A setting is a line `key = value`; the page's first one is an example."""
    return max(0, len(re.findall(r"^ +[a-z0-9_]+ = ", text_of("docs/settings.md"), re.M)) - 1)


def headers_with_one_user(product):
    """Headers that one other file of the product includes, a header's own source left out."""
    users = {path: set() for path in product if path.endswith(".hpp")}
    for path in product:
        for name in re.findall(r'^#include ["<]([^">]+)[">]', text_of(path), re.M):
            if name in users and path != name[:-3] + "cpp":
                users[name].add(path)
    return sorted(name for name, those in users.items() if len(those) == 1)


def blanked(code):
    """`code` with comments, strings and characters as spaces, so that each brace left is one; line ends stay."""
    parts = r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'|^#(?:\\\n|[^\n])*'
    return re.sub(parts, lambda found: re.sub(r"[^\n]", " ", found[0]), code, flags=re.S | re.M)


def is_function(head):
    """`head`: what stands before a brace, from the end of the statement before it."""
    head = re.sub(r"\[\[.*?\]\]|\balignas\(\w+\)", "", head).strip()
    if re.match(r"(template\b.*?>\s*)?(inline )?(namespace|class|struct|union|enum|extern)\b", head, re.S):
        return bool(re.search(r"\)( const| noexcept| override| final)*$", head))
    return "(" in head and not re.search(r"(=|\breturn|,)$", head)


def kind_of_brace(before, head):
    """`before`: the character before the brace. A brace that follows a name at once holds a value."""
    if before not in " \n":
        return "value"
    return "function" if is_function(head) else "scope"


def functions_of(code):
    """(first line, last line) of each function of what clang-format laid out; lambdas belong to the function around them."""
    code = blanked(code)
    found, open_braces, function, statement = [], [], None, 0  # `function`, `statement`: where they begin
    for match in re.finditer(r"[{};]", code):
        at = match.start()
        if match[0] == "{":
            head = code[statement:at]
            kind = "body" if function is not None else kind_of_brace(code[at - 1:at], head)
            if kind == "function":
                function = at - len(head.lstrip())
            open_braces.append(kind)
        else:
            kind = open_braces.pop() if match[0] == "}" and open_braces else None
            if kind == "function":
                found.append((code.count("\n", 0, function) + 1, code.count("\n", 0, at) + 1))
                function = None
        if kind not in ("body", "value"):
            statement = at + 1
    return found


def long_functions(product):
    return [f"{path}:{first} ({last - first + 1} lines)" for path in product for first, last in functions_of(text_of(path))
            if last - first + 1 > LONGEST_FUNCTION]


def read_budget():
    rows = (line.split() for line in text_of(BUDGET).splitlines() if line and not line.startswith("#"))
    return {name: int(lines) for name, lines in rows}


def write_budget(rooms, beside):
    head = "".join(line for line in text_of(BUDGET).splitlines(True) if line.startswith("#"))
    rows = [f"{name} {-(-count // 10) * 10}\n" for name, count in sorted(rooms.items())]
    rows += [f"{name} {len(found)}\n" for name, found in beside.items()]
    with open(BUDGET, "w", encoding="utf-8") as file:
        file.write(head + "".join(rows))


def judge(rooms, budget):
    """What is above the budget, a line each."""
    for room, count in sorted(rooms.items()):
        if room not in budget:
            yield f"{room}: {count} lines, and no budget in {BUDGET}"
        elif count > budget[room]:
            yield f"{room}: {count} lines, {count - budget[room]} more than the budget in {BUDGET} allows"


def main():
    kinds, rooms = counted_lines()
    product = [path for path in tracked("*.cpp", "*.hpp") if not NO_PRODUCT.search(path)]
    beside = {SETTINGS: range(counted_settings()), ONE_USER: headers_with_one_user(product),
              LONG_FUNCTIONS: long_functions(product)}
    if sys.argv[1:] == ["--write"]:
        write_budget(rooms, beside)
        return 0
    budget = read_budget()
    print(f"{'':26} {'lines':>7} {'allowed':>7}")
    for kind, count in kinds.items():
        print(f"{kind:26} {count:7} {budget.get(kind, ''):>7}")
    for room in sorted(set(rooms) - set(kinds)):
        print(f"  {room:24} {rooms[room]:7} {budget.get(room, ''):>7}")
    for name, found in beside.items():
        above = len(found) - budget.get(name, len(found))
        print(f"{name:26} {len(found):7} {budget.get(name, ''):>7}{f'  {above} more than allowed' if above > 0 else ''}")
    for function in beside[LONG_FUNCTIONS]:
        print(f"  {function}")
    above = list(judge(rooms, budget))
    print("\n".join(above), end="\n" if above else "")
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
