"""What the runs of a study say together: summary.json and runs.csv, whose fields docs/formats.md gives, from what the program
left: plan.json (the cells and the table of metrics), results.jsonl and timing.jsonl (a line per run, sorted by cell).

Diverged runs are never dropped silently: they are listed with their seeds, their frames count until they end, and in a paired
comparison they lose. An accuracy over whole runs is over those that finished, and says how many.
"""
from __future__ import annotations

import itertools
import json
import pathlib

import numpy as np

from ..judge import intervals
from ..judge.paired import paired
from .cell import Cell
from .runs_table import RunsTable

FORMAT = "slammot-summary-2"
MALFORMED = (KeyError, TypeError, ValueError, AttributeError, IndexError, RecursionError)


class BadLine(ValueError):
    """One line: file, line and reason."""


class Lines:
    """The lines of both files, run by run."""

    def __init__(self, folder: pathlib.Path):
        self.files = [folder / "results.jsonl", folder / "timing.jsonl"]

    def __iter__(self):
        with self.files[0].open(encoding="utf-8") as results, self.files[1].open(encoding="utf-8") as timings:
            for number, lines in enumerate(itertools.zip_longest(results, timings), 1):
                yield number, [self.parsed(file, number, line) for file, line in zip(self.files, lines)]

    @staticmethod
    def parsed(file, number, line):
        try:
            content = json.loads(line)
        except (*MALFORMED, json.JSONDecodeError) as error:
            raise BadLine(f"{file}:{number}: is not a line of JSON") from error
        if not isinstance(content, dict) or not isinstance(content.get("cell"), int):
            raise BadLine(f"{file}:{number}: is no run of this study")
        return content


def summarise(plan: dict, folder: pathlib.Path) -> tuple[dict, str]:
    """summary.json and the text of runs.csv."""
    abouts = [cell for group in plan["groups"] for cell in group["cells"]]
    cells = [Cell(about, plan["metrics"]) for about in abouts]
    table = RunsTable(plan)
    for number, (result, timing) in Lines(folder):
        _add(cells, table, folder, number, result, timing)
    heading = {key: value for key, value in plan.items() if key not in ("format", "groups")}
    groups, left = [], iter(cells)
    for group in plan["groups"]:
        groups.append(_group(group, list(itertools.islice(left, len(group["cells"])))))
    correct_pairs(pair for group in groups for pair in group["pairs"])
    return {"format": FORMAT} | heading | {"groups": groups}, table.csv()


def _add(cells, table, folder, number, result, timing) -> None:
    if not 0 <= result["cell"] < len(cells) or timing["cell"] != result["cell"]:
        raise BadLine(f"{folder / 'results.jsonl'}:{number}: is no run of this study")
    cell = cells[result["cell"]]
    for file, add, of in (("results.jsonl", cell.add, result), ("timing.jsonl", cell.add_timing, timing)):
        try:
            add(of)
        except MALFORMED as error:
            raise BadLine(f"{folder / file}:{number}: is not the line of a finished run") from error
    table.add(result, timing)


def _pair(a: Cell, b: Cell) -> dict:
    """Position RMSE of a - b by seed, where both ran."""
    seeds = [seed for seed in a.error if seed in b.error]
    pair = paired([a.error[s] for s in seeds], [b.error[s] for s in seeds]).json()
    return {"a": a.about["label"], "b": b.about["label"], "pairs": pair["pairs"], "wins_a": pair["wins_a"], "wins_b": pair["wins_b"],
            "position_rmse_difference_m": pair["difference"], "p": pair["p"]}


def correct_pairs(pairs) -> None:
    """`p_holm` of all pairs that stand on one page."""
    pairs = list(pairs)
    for pair, p in zip(pairs, intervals.holm([pair["p"] for pair in pairs])):
        pair["p_holm"] = float(p)


def _rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else np.nan


def _over_ideal(cell: Cell, ideal: Cell) -> dict:
    """The RMSE of each run over the ideal sigma for its seed. A few failed runs can dominate the RMSE of all runs; the median
    describes a typical one."""
    seeds = [s for s in cell.error if s in ideal.stated_sigma and np.isfinite(cell.error[s])]
    runs = [{"seed": s, "position_rmse_m": cell.error[s], "ideal_sigma_m": ideal.stated_sigma[s],
             "nees_pose": cell.run_nees[s][0].mean if s in cell.run_nees else np.nan} for s in seeds]
    errors, sigmas = ([run[key] for run in runs] for key in ("position_rmse_m", "ideal_sigma_m"))
    with np.errstate(all="ignore"):
        ratios = np.divide(errors, sigmas)
        return {"runs": runs, "position": float(np.divide(_rms(errors), _rms(sigmas))), "median": intervals.median(ratios).json()}


def _group(about: dict, cells: list[Cell]) -> dict:
    competing = [cell for cell in cells if not cell.is_ideal]
    found = [cell.json() for cell in cells]
    for ideal in (cell for cell, json_ in zip(cells, found) if cell.is_ideal and "per_frame" in json_):
        for cell, json_ in zip(cells, found):
            # Not a batch's, which has smoothed: this covariance is a filter's.
            if not cell.is_ideal and "per_frame" in json_ and cell.about["kind"] != "batch":
                json_["rmse_over_ideal"] = _over_ideal(cell, ideal)
    return about | {"cells": found, "pairs": [_pair(a, b) for a, b in itertools.combinations(competing, 2)]}
