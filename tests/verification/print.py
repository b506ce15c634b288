#!/usr/bin/env python3
"""Prints docs/verification.md from figures.csv and head.md, which stand beside this script.

Usage: print.py [--write]     --write: renews the page; else exit code 1 where the page is not what the file says

figures.csv: a row is one figure. An empty subject, claim, check or date is that of the row above. `goal` and `before` (the
figure of an earlier version) have the unit of `figure`. `remark` becomes a footnote. head.md names figures by their `key`.
"""
import csv
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
PAGE = os.path.join(HERE, "../../docs/verification.md")
FIELDS = ["key", "subject", "claim", "check", "date", "case", "figure", "unit", "goal", "before", "missed", "remark"]
INHERITED = ("subject", "claim", "check", "date")
LONGEST_CELL = 120  # [characters]
COLUMNS = "| claim | case | figure | goal | before | checked by | date |\n|---|---|---|---|---|---|---|\n"


def read_rows(path):
    """@throws ValueError naming the line of a row that cannot be printed"""
    with open(path, encoding="utf-8", newline="") as file:
        lines = csv.DictReader(file, strict=True)
        if lines.fieldnames != FIELDS:
            raise ValueError(f"{path}: expected the columns {','.join(FIELDS)}")
        rows = []
        for row in lines:
            where = f"{path}:{lines.line_num}"
            if None in row or None in row.values():
                raise ValueError(f"{where}: expected {len(FIELDS)} fields")
            if not row["figure"] or (not rows and not all(row[name] for name in INHERITED)):
                raise ValueError(f"{where}: a row needs a figure, and the first one a subject, claim, check and date")
            if row["claim"] and not (row["check"] and row["date"]):
                raise ValueError(f"{where}: a claim needs a check and a date")
            if row["missed"] not in ("", "missed"):
                raise ValueError(f"{where}: missed is empty or 'missed', not '{row['missed']}'")
            for name in FIELDS[:-1]:
                if len(row[name]) > LONGEST_CELL:
                    raise ValueError(f"{where}: {name} has more than {LONGEST_CELL} characters; use remark")
            rows.append(row)
    return rows


def value(row):
    return (row["figure"] + ("" if row["unit"] == "°" else " ") + row["unit"]).strip()


def head(rows):
    with open(os.path.join(HERE, "head.md"), encoding="utf-8") as file:
        text = file.read()
    named = {row["key"]: value(row) for row in rows if row["key"]}
    missed = sum(row["missed"] != "" for row in rows)
    return text.format(missed=missed, figures=len(rows), **named)


def table(rows, first_note):
    """@returns the rows of one subject with their footnotes, and the number of the next footnote"""
    text, notes = COLUMNS, ""
    for row in rows:
        figure = value(row) + (" **missed**" if row["missed"] else "")
        if row["remark"]:
            figure += f"[^{first_note}]"
            notes += f"[^{first_note}]: {row['remark']}\n"
            first_note += 1
        cells = [row["claim"], row["case"], figure, row["goal"], row["before"], row["check"], row["date"]]
        text += "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"
    return text + ("\n" + notes if notes else ""), first_note


def printed(rows):
    text, next_note = head(rows), 1
    begins = [index for index, row in enumerate(rows) if row["subject"]] + [len(rows)]
    for begin, end in zip(begins, begins[1:]):
        shown, next_note = table(rows[begin:end], next_note)
        text += f"\n## {rows[begin]['subject']}\n\n{shown}"
    return text


def main():
    if sys.argv[1:] not in ([], ["--write"]):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        text = printed(read_rows(os.path.join(HERE, "figures.csv")))
    except (ValueError, KeyError, csv.Error) as fault:
        print(f"verification: {fault}", file=sys.stderr)
        return 1
    if sys.argv[1:]:
        with open(PAGE, "w", encoding="utf-8") as page:
            page.write(text)
        return 0
    with open(PAGE, encoding="utf-8") as page:
        if page.read() == text:
            return 0
    print("docs/verification.md is not what tests/verification/figures.csv says: tests/verification/print.py --write", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
