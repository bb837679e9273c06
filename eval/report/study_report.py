#!/usr/bin/python3
"""study_report.py OUTPUT: figures (PDF, PNG), tables (LaTeX, CSV) and OUTPUT/report.html from OUTPUT/summary.json.

Silent on success; exit 2 and one line on stderr for bad input, a missing package or a file that cannot be written.
"""
import base64
import json
import pathlib
import sys

import study_figures
import study_tables
from comparison import BadInput
from page import rendered

FORMAT = "slammot-summary-1"


def read_json(path, required=True):
    if not path.is_file():
        if required:
            raise BadInput(f"{path}: not found")
        return None
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        raise BadInput(f"{path}:{error.lineno}: {error.msg}") from error


def write_tables(summary, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in study_tables.all_tables(summary).items():
        (folder / f"{name}.csv").write_text(table.csv(), encoding="utf-8")
        (folder / f"{name}.tex").write_text(table.latex(), encoding="utf-8")


def inline(png):
    return "data:image/png;base64," + base64.b64encode(png.read_bytes()).decode("ascii")


def write_report(output):
    summary = read_json(output / "summary.json")
    if summary.get("format") != FORMAT:
        raise BadInput(f"{output / 'summary.json'}: format is not {FORMAT}")
    view = read_json(output / "view.json", required=False)
    write_tables(summary, output / "tables")
    figures = study_figures.draw_all(summary, output / "figures")
    page = rendered(
        "study.html", "view.js", view if view and view["runs"] else None,
        summary=summary, tables=study_tables.all_tables(summary),
        figures=[(f.title, f.caption, inline(f.png)) for f in figures])
    (output / "report.html").write_text(page, encoding="utf-8")


def main(arguments):
    if len(arguments) != 1:
        print("usage: study_report.py OUTPUT", file=sys.stderr)
        return 2
    try:
        write_report(pathlib.Path(arguments[0]))
    except (BadInput, OSError) as error:
        print(f"study_report: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
