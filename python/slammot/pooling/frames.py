"""What runs say together at every frame.

The NEES of the camera has one sample a run: its mean over N runs is compared with the chi-square interval of N runs. Landmarks
of one run share its camera's error: the interval of their mean NEES is over the runs, lies around that mean, and should
contain 3.
"""
from __future__ import annotations

import numpy as np

from ..judge.consistency import nees_interval
from ..judge.intervals import ratio_of_sums
from .json_files import count, nees_numbers, numbers

CAMERA = {"pose": 6, "position": 3, "rotation": 3}  # part to its degrees of freedom
LANDMARKS = ("landmark_position", "landmark_velocity")
LANDMARK_DOF = 3
SAMPLED = ("position_error_m", "rotation_error_deg", "position_sigma_m")


class RunFrames:
    """`frames` or `smoothed_frames` of one run (docs/formats.md), as arrays. A part without covariances has no NEES."""

    def __init__(self, frames: dict):
        self.frame = np.array([count(f) for f in frames["frame"]], int)
        self.values = {key: numbers(frames[key]) for key in SAMPLED}
        self.nees = {part: nees_numbers(frames[f"nees_{part}"]) for part in CAMERA if frames.get(f"nees_{part}")}
        self.landmarks = {}  # part to (sums, counts)
        for part in LANDMARKS:
            if f"nees_{part}" in frames:
                counts = np.array([count(n) for n in frames[f"{part}_count"]], float)
                means = np.where(counts > 0, nees_numbers(frames[f"nees_{part}"]), 0.0)
                self.landmarks[part] = (means * counts, counts)
        arrays = [*self.values.values(), *self.nees.values(), *(a for pair in self.landmarks.values() for a in pair)]
        if any(len(array) != len(self.frame) for array in arrays):
            raise ValueError("arrays over the frames differ in length")

    def stated_sigma(self) -> float:
        """Root mean square over the frames; the first, a pin, counts as an RMSE counts it."""
        sigma = self.values["position_sigma_m"]
        return float(np.sqrt((sigma**2).sum() / (len(sigma) + 1))) if len(sigma) else np.nan


class FrameStatistics:
    """Over runs that may end early: a row a run, a column a frame, NaN where a run has no such frame."""

    def __init__(self, runs: list[RunFrames]):
        self.runs = runs
        self.frames = np.unique(np.concatenate([run.frame for run in runs])) if runs else np.zeros(0, int)

    @property
    def empty(self) -> bool:
        return len(self.frames) == 0

    def _table(self, array_of, missing=np.nan) -> np.ndarray:
        table = np.full((len(self.runs), len(self.frames)), missing)
        for row, run in zip(table, self.runs):
            values = array_of(run)
            if values is not None:
                row[np.searchsorted(self.frames, run.frame)] = values
        return table

    def _camera(self, part: str, dof: int) -> dict:
        nees = self._table(lambda run: run.nees.get(part))
        runs = (~np.isnan(nees)).sum(0)
        with np.errstate(all="ignore"):
            value = np.where(np.isnan(nees), 0.0, nees).sum(0) / runs
        lower, upper = nees_interval(dof, runs)
        sums = [run.nees[part] for run in self.runs if part in run.nees]
        mean, low, high = ratio_of_sums([s.sum() for s in sums], [len(s) for s in sums])
        return {"dof": dof, "value": value, "lower": lower, "upper": upper, "inside": _inside(lower, value, upper),
                "over_runs": {"mean": mean, "lower": low, "upper": high, "runs": len(sums)}}

    def _landmarks(self, part: str) -> dict:
        sums = self._table(lambda run: run.landmarks[part][0] if part in run.landmarks else None, 0.0)
        counts = self._table(lambda run: run.landmarks[part][1] if part in run.landmarks else None, 0.0)
        value, lower, upper = ratio_of_sums(sums.T, counts.T)
        return {"dof": LANDMARK_DOF, "value": value, "lower": lower, "upper": upper,
                "inside": _inside(lower, LANDMARK_DOF, upper), "over_runs": {}}

    def _parts(self) -> dict[str, dict]:
        parts = {part: self._camera(part, dof) for part, dof in CAMERA.items() if any(part in run.nees for run in self.runs)}
        return parts | {part: self._landmarks(part) for part in LANDMARKS if part in self.runs[0].landmarks}

    def summary(self) -> tuple[dict, dict]:
        """(anees, per_frame). Of each part: mean, of the camera's over all poses of all runs with its 95% interval over runs,
        of landmarks over the frames; largest of a frame, share of frames `inside`, of those that have an interval."""
        anees, per_frame = {}, self._errors()
        for name, part in self._parts().items():
            known, inside = part["value"][~np.isnan(part["value"])], part["inside"][~np.isnan(part["inside"])]
            anees[name] = {"dof": part["dof"], "mean": known.mean() if len(known) else np.nan,
                           "largest": known.max() if len(known) else np.nan, "inside": inside.mean() if len(inside) else np.nan,
                           "infinite": int(np.isinf(known).sum())} | part["over_runs"]
            per_frame |= {f"anees_{name}": part["value"], f"anees_{name}_lower": part["lower"], f"anees_{name}_upper": part["upper"]}
        return anees, per_frame

    def _errors(self) -> dict:
        position, rotation, sigma = (self._table(lambda run, key=key: run.values[key]) for key in SAMPLED)
        there = ~np.isnan(self._table(lambda run: np.zeros(len(run.frame))))

        def rms(table):
            return np.sqrt((np.where(there, table, 0.0) ** 2).sum(0) / there.sum(0))

        q25, median, q75, q95 = np.nanquantile(position, [0.25, 0.5, 0.75, 0.95], axis=0)
        return {"frame": self.frames, "runs": there.sum(0), "position_rmse_m": rms(position), "position_q25_m": q25,
                "position_median_m": median, "position_q75_m": q75, "position_q95_m": q95, "position_sigma_m": rms(sigma),
                "rotation_rmse_deg": rms(rotation)}


def _inside(lower, value, upper) -> np.ndarray:
    """1 or 0; NaN without an interval."""
    with np.errstate(invalid="ignore"):
        return np.where(np.isnan(lower), np.nan, (lower <= value) & (value <= upper))


def run_sum(mean, n) -> tuple[float, int]:
    """Sum and count of a mean NEES over n samples."""
    n = count(n)
    return (n * float(nees_numbers([mean])[0]), n) if n else (0.0, 0)


