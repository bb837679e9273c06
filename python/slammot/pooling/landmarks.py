"""What the runs of a cell say together of landmarks: by the number of their measurements, and of the recorded tracks in every
frame."""
from __future__ import annotations

import numpy as np

from ..judge.intervals import quantile, ratio_of_sums
from .frames import run_sum
from .json_files import count, number, numbers

ERRORS = ("static_position_m", "moving_position_m", "moving_velocity_m_s")
NEES = ("nees_position", "nees_velocity")
QUANTILES = {"q05": 0.05, "q25": 0.25, "median": 0.5, "q75": 0.75, "q95": 0.95}


class LandmarkAges:
    def __init__(self):
        self.ages = {}  # number of measurements to {error: samples, nees: [(sum, count) a run]}

    def add(self, landmarks: list[dict]) -> None:
        """Of one run."""
        for entry in landmarks:
            age = self.ages.setdefault(count(entry["observations"]), {key: [] for key in (*ERRORS, *NEES)})
            for key in ERRORS:
                age[key].extend(numbers(entry[key]))
            for key in NEES:
                age[key].append(run_sum(entry[f"{key}_mean"], entry[f"{key}_count"]))

    def json(self) -> list[dict]:
        return [{"observations": n} | {key: _quartiles(age[key]) for key in ERRORS} | {key: _nees(age[key]) for key in NEES}
                for n, age in sorted(self.ages.items())]


def _quartiles(samples: list[float]) -> dict:
    return {"count": len(samples)} | {name: quantile(samples, p) for name, p in QUANTILES.items()}


def _nees(runs: list[tuple[float, int]]) -> dict | None:
    sums, counts = zip(*runs)
    if not any(counts):
        return None
    mean, lower, upper = ratio_of_sums(sums, counts)
    return {"mean": mean, "count": sum(counts), "lower": lower, "upper": upper}


class RecordedTracks:
    def __init__(self):
        self.tracks = {}  # track to {frame: {"velocity" | "sigma" | "truth": [(3) a run]}}

    def add(self, tracks: list[dict]) -> None:
        """Of one run."""
        for entry in tracks:
            moments = self.tracks.setdefault(count(entry["track"]), {})
            for i, frame in enumerate(entry["frame"]):
                moment = moments.setdefault(count(frame), {"velocity": [], "sigma": [], "truth": []})
                for key, samples in moment.items():
                    value = entry[key][i]
                    samples.append([np.nan] * 3 if value is None else [number(value[axis]) for axis in range(3)])

    def json(self) -> list[dict]:
        return [{"track": track, "frame": sorted(moments)} | _medians([moments[f] for f in sorted(moments)])
                for track, moments in sorted(self.tracks.items())]


def _axes(samples: list[list[float]], p: float) -> list[float]:
    return [quantile(axis, p) for axis in zip(*samples)]


def _medians(moments: list[dict]) -> dict:
    return {"velocity": [_axes(m["velocity"], 0.5) for m in moments],
            "spread": [list(zip(_axes(m["velocity"], 0.05), _axes(m["velocity"], 0.95))) for m in moments],
            "sigma": [_axes(m["sigma"], 0.5) for m in moments], "truth": [_axes(m["truth"], 0.5) for m in moments]}
