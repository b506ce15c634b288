"""The pages below docs/ that are printed: settings, gates, messages and options from the code (each is a text by hand, a mark, and
the print), verification from tests/verification/figures.csv."""
import glob
import os
import re
import subprocess
import sys

FOREIGN = ("ros_", "mbot_", "maebot_")


def output_of(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def settings(programs, _root):
    printed = output_of(f"{programs}/marco-map", "--print-config", "--advanced")
    return "".join("    " + line if line.strip() else line for line in printed.splitlines(keepends=True))


def defaults(programs):
    """slam.loops.min_score -> 0.5"""
    values, section = {}, ""
    for program in ("marco-map", "marco-slam"):
        for line in output_of(f"{programs}/{program}", "--print-config", "--advanced").splitlines():
            if begin := re.match(r"\s*\[([\w.]+)\]", line):
                section = begin[1]
            elif setting := re.match(r"\s*(\w+) = (\S+)", line):
                values[f"{section}.{setting[1]}"] = setting[2]
    return values


def gates(programs, _root):
    printed, known = output_of(f"{programs}/gate_table").lstrip("\n"), defaults(programs)
    for threshold, setting in re.findall(r"\| (\S+) \| [^|]* \| ([a-z_]+\.[a-z_.]+\w)", printed):
        if setting not in known or float(known[setting]) != float(threshold):
            sys.exit(f"FAILED: a gate says {setting} = {threshold}, the settings {known.get(setting, 'know none')}")
    return printed


def channels_of(root):
    """The channels of each type: by what channels.hpp says of them, else by their names."""
    channels = {}
    for path in (f"{root}/lcmtypes/channels.hpp", f"{root}/lcm_tools/lcmtypes/channels.hpp"):
        with open(path, encoding="utf-8") as file:
            for name, said in re.findall(r'= *\n? *"([A-Z_]+)"; *(?:///< ((?:\w+\.)?\w+_t)\b)?', file.read()):
                channels.setdefault(said.split(".")[-1] if said else name.lower() + "_t", []).append(name)
    return channels


def cell(text):
    return text.strip().replace("|", "\\|")


def message(path, channels):
    """A heading, what the message is, and a row a field or constant."""
    with open(path, encoding="utf-8") as file:
        package, rest = re.match(r"package (\w+);(.*)", file.read(), re.S).groups()
    head, name, body = re.match(r"(.*?)struct (\w+)\s*\{(.*)\}", rest, re.S).groups()
    text = f"### {package}.{name}\n"
    if name in channels:
        text += "\nOn " + ", ".join(f"`{channel}`" for channel in channels[name]) + ".\n"
    about = " ".join(line.strip().lstrip("/").strip() for line in head.splitlines() if line.strip())
    text += f"\n{about}\n" if about else ""
    text += "\n| field | type | meaning |\n|---|---|---|\n"
    before = []
    for line in body.splitlines():
        declared, _, comment = line.partition("//")
        declared = " ".join(declared.split())
        if not declared:
            before += [comment.strip()] if comment else []
            continue
        meaning, before = cell(" ".join(before + [comment.strip()])), []
        for part in filter(None, (part.strip() for part in declared.split(";"))):
            constant = re.match(r"const (\S+) (.*)", part)
            kind, field = constant.groups() if constant else part.split(" ", 1)
            text += f"| `{field}` | {kind} | {meaning} |\n"
    return text


def messages(_programs, root):
    channels = channels_of(root)
    paths = sorted(glob.glob(f"{root}/lcmtypes/*/*.lcm") + glob.glob(f"{root}/lcm_tools/lcmtypes/*/*.lcm"), key=os.path.basename)
    ours = [path for path in paths if not os.path.basename(path).startswith(FOREIGN)]
    others = [path for path in paths if path not in ours]
    return ("## Marco's\n\n" + "\n".join(message(path, channels) for path in ours) +
            "\n## Fields of other systems' messages\n\n" + "\n".join(message(path, {}) for path in others))


def options(programs, root):
    environment = dict(os.environ, MARCO_BIN=programs)
    ask = lambda *words: subprocess.run([f"{root}/marco", *words], capture_output=True, text=True, check=True, env=environment).stdout
    named = re.findall(r"^  \./marco ([a-z-]+(?: --many)?)", ask("help"), re.M)
    pages = []
    for command in dict.fromkeys(named):
        shown = ask(*command.split(), "--help").rstrip().splitlines()
        pages.append(f"## {command}\n\n" + "\n".join(("    " + line).rstrip() for line in shown) + "\n")
    return "\n".join(pages)


# Where the print begins in each page.
PAGES = {
    "settings.md": ("    [input]\n", settings),
    "gates.md": ("## ", gates),
    "messages.md": ("## ", messages),
    "options.md": ("## ", options),
}


def check(programs, root, write, fail):
    """@param write  renews the pages; else what is stale fails"""
    for name, (mark, printed_by) in PAGES.items():
        with open(f"{root}/docs/{name}", encoding="utf-8") as page:
            intro, _, shown = page.read().partition("\n" + mark)
        printed = printed_by(programs, root)
        if write:
            with open(f"{root}/docs/{name}", "w", encoding="utf-8") as page:
                page.write(f"{intro}\n{printed}")
        elif mark + shown != printed:
            fail(f"docs/{name}", "is not what the code says: renew it by readme_test.py --write")
    figures = subprocess.run([sys.executable, f"{root}/tests/verification/print.py", *(["--write"] if write else [])], capture_output=True, text=True)
    if figures.returncode != 0:
        fail("docs/verification.md", figures.stderr.strip())
