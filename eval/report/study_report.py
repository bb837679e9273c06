#!/usr/bin/python3
"""study_report.py OUTPUT: figures (PDF, PNG), tables (LaTeX, CSV) and OUTPUT/report.html from OUTPUT/summary.json.

Silent on success; one line on stderr and exit 2 for bad input, 1 for a missing package or a file that cannot be written.
"""
import base64
import sys

import ranking
import study_figures
import study_tables
import study_verdict
from comparison import read_json
from page import rendered, run_report, write_aside

FORMAT = "slammot-summary-2"


def tables_of(summary):
    tables = {"ranking": ranking.table(summary)} if "ranking" in summary["figures"] else {}
    tables |= {"summary": study_tables.summary_table(summary), "warnings": study_tables.warnings_table(summary),
              "consistency": study_tables.consistency_table(summary),
              "nees_by_run": study_tables.nees_by_run_table(summary), "classification": study_tables.classification_table(summary),
              "pairs": study_tables.pairs_table(summary), "lags": study_tables.lags_table(summary), "metrics": study_tables.metrics_table(summary),
              "coverage": study_tables.measurements_table(summary)}
    return {name: table for name, table in tables.items() if table.rows}


def write_tables(tables, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in tables.items():
        write_aside(folder / f"{name}.csv", table.csv())
        write_aside(folder / f"{name}.tex", table.latex())


def inline(png):
    return "data:image/png;base64," + base64.b64encode(png.read_bytes()).decode("ascii")


def page(output):
    """The page; its figures and tables are written to folders beside it."""
    summary = read_json(output / "summary.json", FORMAT)
    view = read_json(output / "view.json") if (output / "view.json").is_file() else None
    tables = tables_of(summary)
    write_tables(tables, output / "tables")
    if summary.get("latex"):
        write_aside(output / "tables" / "paper.tex", study_tables.paper_table(summary))
    figures = study_figures.draw_all(summary, output / "figures")
    return rendered(
        "study.html", "view.js", view if view and view["runs"] else None,
        summary=summary, tables=tables, study_verdict=study_verdict, study_tables=study_tables,
        figures=[(f.title, f.caption, inline(f.png)) for f in figures])


if __name__ == "__main__":
    sys.exit(run_report("study_report", page, "summary.json"))
