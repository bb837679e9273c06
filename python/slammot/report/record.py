"""What a study leaves for the pages of docs/: table.md and a short summary.json in results/NAME (`slammot study --record`).

table.md has what a reader asks first: errors and consistency of each estimator, which differences are decided, and of how many
runs with which seeds on which processor. summary.json says which commit and command made it, what it cost, and has every number
over the runs, without the series over frames.
"""
from ..judge.intervals import FEW, FEWEST
from ..pooling.json_files import dumped
from . import study_verdict
from .comparison import BadInput
from .page import write_aside

FORMAT = "slammot-results-1"
SERIES = ("per_frame", "by_age", "tracks", "axes", "warnings", "configuration", "in_force")
HEADING = ("version", "name", "title", "runs", "first_seed", "provenance")
OF_GROUP = ("name", "scenario", "sequence", "seeds", "scene", "sweep", "pairs")
COLUMNS = ("runs", "failed", "diverged", "failed, not warned", "ATE Sim(3) [m]", "scale", "position RMSE [m]", "ANEES pose (6)",
           "ANEES position (3)", "frames inside", "scale, largest", "RMSE over ideal sigma", "time per frame [ms]")
NEVER = ("–", "0", "0.0%")  # a column of these says nothing
MAY_BE_ABSENT = ("failed", "diverged", "failed, not warned", "scale, largest")
TABLES = ("ranking", "classification")


def core_hours(summary):
    """Every run has one thread."""
    return sum(cell["timing"]["total_seconds"] for group in summary["groups"] for cell in group["cells"] if "timing" in cell) / 3600


def short(cell):
    kept = {key: value for key, value in cell.items() if key not in SERIES}
    if "rmse_over_ideal" in kept:
        kept["rmse_over_ideal"] = {key: value for key, value in kept["rmse_over_ideal"].items() if key != "runs"}
    return kept


def recorded(summary, command):
    groups = [{key: group[key] for key in OF_GROUP} | {"cells": [short(cell) for cell in group["cells"]]} for group in summary["groups"]]
    return {"format": FORMAT, "command": command, "core_hours": round(core_hours(summary), 4)} | {key: summary[key] for key in HEADING} | {"groups": groups}


def cell_text(text):
    return text.replace("|", "\\|").replace("\n", " ")


def markdown(head, rows):
    lines = ["| " + " | ".join(map(cell_text, row)) + " |" for row in (head, *rows)]
    lines.insert(1, "|" + "---|" * len(head))
    return "\n".join(lines)


def summary_markdown(table):
    """The columns that say something, without the scenario where there is one."""
    places = [i for i, head in enumerate(table.head)
              if i < 2 or (head in COLUMNS and not (head in MAY_BE_ABSENT and all(row[i] in NEVER for row in table.rows)))]
    if len({row[0] for row in table.rows}) == 1:
        places = places[1:]
    return markdown([table.head[i] for i in places], [[row[i] for i in places] for row in table.rows])


def made_by(summary):
    runs, first = study_verdict.most_runs(summary), summary["first_seed"]
    seeds = f"seed {first}" if runs == 1 else f"seeds {first} to {first + runs - 1}"
    p = summary["provenance"]
    brackets = " Brackets: 95% intervals over runs." if runs >= FEWEST else f" No intervals: {FEW}."
    return f"{runs} run{'' if runs == 1 else 's'} of each, {seeds}; {p['cpu']}, {p['jobs'] or 'any number of'} at a time.{brackets}"


def table_markdown(summary, tables):
    blocks = [summary_markdown(tables["summary"])] + [markdown(tables[name].head, tables[name].rows) for name in TABLES if name in tables and name in summary["figures"]]
    sentences = [sentence for _, found in study_verdict.pairs(summary) for sentence in found]
    return "\n\n".join([*blocks, *sentences, made_by(summary)]) + "\n"


def write(folder, command, summary, tables):
    """`folder` is results/NAME."""
    if folder.exists() and not (folder / "summary.json").exists() and any(folder.iterdir()):
        raise BadInput(f"{folder}: holds files that are no results of this program")
    folder.mkdir(parents=True, exist_ok=True)
    write_aside(folder / "table.md", table_markdown(summary, tables))
    write_aside(folder / "summary.json", dumped(recorded(summary, command)))
