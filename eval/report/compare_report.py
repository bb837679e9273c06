#!/usr/bin/python3
"""compare_report.py OUTPUT: writes OUTPUT/report.html from OUTPUT/compare.json and its run folders.

The page needs nothing but itself: Plotly is carried inside. Silent on success; exit 2 and one line on
stderr for bad input, a missing package or a page that cannot be written.
"""
import pathlib
import sys

import figures
import tables
import verdict
from comparison import BadInput, read_comparison
from page import rendered


def page(comparison):
    charts = {name: figure for name, figure in (
        ("trajectory", figures.trajectory(comparison)),
        ("position_error", figures.position_error(comparison)),
        ("nees", figures.nees(comparison)),
        ("runtime", figures.runtime(comparison))) if figure}
    return rendered("compare.html", "page.js", charts, charts=charts, comparison=comparison,
                    findings=verdict.findings(comparison), verdict=verdict, tables=tables)


def main(arguments):
    if len(arguments) != 1:
        print("usage: compare_report.py OUTPUT", file=sys.stderr)
        return 2
    output = pathlib.Path(arguments[0])
    try:
        (output / "report.html").write_text(page(read_comparison(output)), encoding="utf-8")
    except (BadInput, OSError) as error:
        print(f"compare_report: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
