"""python3 -m slammot.report study OUTPUT: summary.json and runs.csv from what the program left in the folder of a study
(plan.json and the runs), then figures (PDF, SVG, PNG), tables (LaTeX, CSV) and report.html from summary.json.
"""
import pathlib

from . import ranking, record, study_figures, study_tables, study_verdict
from ..pooling import study
from ..pooling.json_files import dumped
from .comparison import BadInput, read_json, rows_of
from .page import embedded_picture, rendered, run_report, write_aside

PLAN, FORMAT = "slammot-plan-1", study.FORMAT


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


def summarise_folder(output):
    try:
        summary, runs = study.summarise(read_json(output / "plan.json", PLAN), output)
    except study.BadLine as error:
        raise BadInput(error) from error
    write_aside(output / "runs.csv", runs)
    write_aside(output / "summary.json", dumped(summary))


def page(output, given):
    """The page; its figures and tables are written to folders beside it."""
    if (output / "plan.json").is_file():
        summarise_folder(output)
    summary = read_json(output / "summary.json", FORMAT)
    view = read_json(output / "view.json") if (output / "view.json").is_file() else None
    tables = tables_of(summary)
    write_tables(tables, output / "tables")
    if summary.get("latex"):
        write_aside(output / "tables" / "paper.tex", study_tables.paper_table(summary))
    figures = study_figures.draw_all(summary, output / "figures", rows_of(output / "runs.csv"))
    if given.record:
        record.write(given.record, given.command, summary, tables)
    return rendered(
        "study.html", "view.js", view if view and view["runs"] else None,
        summary=summary, tables=tables, study_verdict=study_verdict, study_tables=study_tables,
        figures=[(f.title, f.caption, embedded_picture(f.svg)) for f in figures])


def main():
    return run_report("study_report", page, "summary.json", record={"type": pathlib.Path, "metavar": "DIR"}, command={"default": ""})
