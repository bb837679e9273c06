"""What the runs of an estimator say together, and what two estimators say beside each other, in a comparison: `estimators` and
`pairs` of pooled.json, from the runs of compare.json.

Runs are paired where they were judged against the same sequence, in their order; a run that diverged or failed loses, and runs
with poses of shares of the frames that differ by more than a tenth are no pair.
"""
from __future__ import annotations

import itertools
import math

from ..judge.paired import paired
from .cell import POOLED
from .cell import pooled as pooled_metric
from .frames import CAMERA, FrameStatistics, RunFrames
from .json_files import number
from .study import correct_pairs

FORMAT = "slammot-pooled-1"
APART = 0.1  # in coverage


def pooled(comparison: dict) -> dict:
    """Of what compare.json holds."""
    error_key = "position_rmse_m" if comparison["sequence"]["exact_truth"] else "ate_sim3_m"
    by_name = {}
    for entry in comparison["runs"]:
        by_name.setdefault(entry["pooled"], []).append(_Run(entry, comparison, error_key))
    pairs = [_pair(a, b, by_name, error_key) for a, b in itertools.combinations(by_name, 2)]
    correct_pairs(pairs)
    return {"format": FORMAT, "estimators": [_estimator(name, runs) for name, runs in by_name.items()], "pairs": pairs}


class _Run:
    def __init__(self, entry: dict, comparison: dict, error_key: str):
        self.metrics = entry["metrics"]
        self.judged = self.metrics["smoothed" if entry["kind"] == "batch" else "filtered"] or {}
        self.sequence = (entry.get("sequence") or comparison["sequence"])["sha256"]
        self.diverged = self.metrics["divergence"] is not None
        self.table = comparison["metrics"]
        self.frames = RunFrames(entry["frames"])
        self.timestamps = dict(zip(entry["frames"]["frame"], entry["frames"]["timestamp"]))
        accuracy = self.judged.get("accuracy") or {}
        self.coverage = number(accuracy.get("coverage"))
        error = number(accuracy.get(error_key))
        failed = self.metrics["failed_at"] is not None
        self.error = math.inf if self.diverged or failed or math.isnan(error) else error

    @property
    def warned(self) -> bool:
        return self.diverged or bool(self.metrics["warnings"])

    def value(self, metric: dict) -> float:
        tree = self.judged if metric["of"] == "trajectory" else self.metrics
        for key in metric["path"].split("."):
            tree = tree.get(key) if isinstance(tree, dict) else None
        return number(tree)

    def has_nees(self, part: str) -> bool:
        return bool(((self.judged.get("nees") or {}).get(part) or {}).get("used"))


def _values(runs: list[_Run]) -> dict:
    """A run of a foreign trajectory and one of this program may know different metrics of a table."""
    values = {}
    for metric in runs[0].table:
        if metric["pooled"] not in POOLED:
            continue
        samples = [v for run in runs if not run.diverged and not math.isnan(v := run.value(metric))]
        if samples:
            values[metric["key"]] = pooled_metric(metric, samples).json()
    return values


def _estimator(name: str, runs: list[_Run]) -> dict:
    json = {"name": name, "runs": len(runs), "diverged": sum(run.diverged for run in runs),
            "failed": sum(run.metrics["failed_at"] is not None for run in runs), "warned": sum(run.warned for run in runs),
            "values": _values(runs), "anees": {}, "per_frame": None}
    statistics = FrameStatistics([run.frames for run in runs])
    if statistics.empty:
        return json
    anees, per_frame = statistics.summary()
    json["anees"] = {part: anees[part] for part in CAMERA if part in anees and all(run.has_nees(part) for run in runs)}
    if notes := [a["note"] for run in runs if (a := run.metrics.get("alignment")) and not a["verdict"]]:
        for part in json["anees"].values():
            part["no_verdict"] = notes[0]  # of a fit to the truth
    timestamps = {frame: t for run in reversed(runs) for frame, t in run.timestamps.items()}
    json["per_frame"] = {key: values for key, values in per_frame.items() if not key.startswith("anees_") or key.split("_")[1] in json["anees"]}
    json["per_frame"]["timestamp"] = [timestamps[frame] for frame in statistics.frames.tolist()]
    return json


def _pair(a: str, b: str, by_name: dict, error_key: str) -> dict:
    of_b, matched = {}, []
    for run in by_name[b]:
        of_b.setdefault(run.sequence, []).append(run)
    taken = {}
    for run in by_name[a]:
        place = taken[run.sequence] = taken.get(run.sequence, -1) + 1
        others = of_b.get(run.sequence, [])
        if place < len(others) and not _over_other_frames(run, others[place]):
            matched.append((run.error, others[place].error))
    return {"a": a, "b": b, "metric": error_key} | paired(*zip(*matched) if matched else ((), ())).json()


def _over_other_frames(a: _Run, b: _Run) -> bool:
    """Errors over some of the frames do not compare with errors over others; a run that diverged loses."""
    return not (a.diverged or b.diverged) and abs(a.coverage - b.coverage) > APART
