"""runs.csv of a study's folder: a row per run, for pandas, R and spreadsheets."""
from __future__ import annotations

import csv
import io
import json
import math

from .cell import trajectories_of
from .json_files import nees_numbers

PARTS = ("nees_pose", "nees_position", "nees_rotation")
VERDICTS = ("right", "wrong", "undecided")


def text(value) -> str:
    """Shortest that reads back; nothing where it is not defined."""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return json.dumps(value) if math.isfinite(value) else ""
    return "" if value is None else str(value)


class RunsTable:
    def __init__(self, plan: dict):
        cells = [cell for group in plan["groups"] for cell in group["cells"]]
        self.cells = [(group, cell) for group in plan["groups"] for cell in group["cells"]]
        self.swept = list(self.cells[0][0]["sweep"]) if cells else []
        self.metrics = [m for m in plan["metrics"] if m["pooled"] != "not"]
        self.rows = []

    def add(self, result: dict, timing: dict) -> None:
        group, cell = self.cells[result["cell"]]
        row = {"scenario": group["sequence"] or group["scenario"], "group": group["name"], "estimator": cell["estimator"], "label": cell["label"]}
        row |= {key: group["sweep"][key] for key in self.swept}
        diverged, lost = result["diverged"], result.get("lost_at")
        row |= {"seed": result["seed"], "diverged": diverged is not None, "diverged_frame": (diverged or {}).get("frame"),
                "failed": lost is not None, "failed_frame": lost}
        row |= self._metrics(result, timing) | _nees(result) | _labels(result) | {"seconds": timing.get("seconds")}
        self.rows.append({key: text(value) for key, value in row.items()})

    def _metrics(self, result: dict, timing: dict) -> dict:
        row, trajectories = {}, trajectories_of(result)
        for metric in self.metrics:
            key = metric["key"]
            if metric["pooled"] == "timing":
                row[key] = timing.get(key)
            elif metric["of"] == "run":
                row[key] = result.get(key)
            else:
                row |= {f"{which}_{key}": (result.get(which) or {}).get(key) for which in trajectories}
        return row

    def csv(self) -> str:
        """Runs have a trajectory in the last scale or not; the columns are those of all."""
        file = io.StringIO()
        if self.rows:
            writer = csv.DictWriter(file, max(self.rows, key=len), lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows)
        return file.getvalue()


def _nees(result: dict) -> dict:
    """Means over the frames of a run; a covariance that is not positive definite makes them undefined."""
    row = {}
    for prefix, block in (("filtered", "frames"), ("smoothed", "smoothed_frames")):
        for part in PARTS:
            values = (result.get(block) or {}).get(part)
            row[f"{prefix}_{part}"] = float(nees_numbers(values).mean()) if values else None
    return row


def _labels(result: dict) -> dict:
    return {f"{truth}_{verdict}": (result.get(truth) or [None] * 3)[i] for truth in ("static", "moving") for i, verdict in enumerate(VERDICTS)}
