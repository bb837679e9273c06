"""The runs of one cell of a study, taken one by one, and what they say together: an entry of `cells` in summary.json."""
from __future__ import annotations

import numpy as np

from ..judge import intervals
from ..judge.consistency import run_nees
from .frames import FrameStatistics, RunFrames
from .json_files import count, number
from .landmarks import LandmarkAges, RecordedTracks

COUNTS = ("static", "moving", "static_often_seen", "moving_often_seen", "standing_by_frame", "moving_by_frame")
WORST = 3  # runs that are named
POOLED = ("mean", "rms")


def pooled(metric: dict, samples: list[float]) -> intervals.Estimate:
    """The runs' values of a metric put together, as its row says."""
    if metric["pooled"] == "rms":
        return intervals.root_mean_square(samples)
    if metric["form"] == "ratio" and 0.0 in samples and set(samples) <= {0.0, 1.0}:
        return intervals.share(samples)  # of yes and no, such as whether a run warns
    return intervals.mean(samples, positive=all(x > 0.0 for x in samples))


def trajectories_of(run: dict) -> tuple[str, ...]:
    """Those that a run is judged by or has beside them; one in the last scale only where the scale is not known."""
    return ("filtered", "smoothed") + (("last_scale",) if "last_scale" in run else ())


def warnings_of(run: dict) -> list[dict]:
    found = run.get("warnings", [])
    for warning in found:
        if warning["frame"] is not None:
            count(warning["frame"])
        if not isinstance(warning["reason"], str):
            raise ValueError("a warning without a reason")
    return found


class InForce:
    """Mechanisms beyond the thesis over the runs that state them: a seed may decide, as where the sequence states what a
    mechanism asks for."""

    def __init__(self):
        self.runs = 0
        self.mechanisms = {}  # by name, in the order stated

    def add(self, stated: list[dict]) -> None:
        self.runs += 1
        for m in stated:
            acting = self.mechanisms.setdefault(m["name"], {"name": m["name"], "key": m["key"], "on": 0, "runs": 0, "because": "", "acted": 0})
            acting["because"] = m["because"] or acting["because"]
            acting["on"] += m["state"] == "on"
            acting["acted"] += count(m["acted"])

    def json(self) -> list[dict]:
        return [m | {"runs": self.runs} for m in self.mechanisms.values()]


class Cell:
    def __init__(self, about: dict, metrics: list[dict]):
        self.about = about  # of the plan: label, estimator, kind, oracle, configuration
        self.metrics = metrics
        self.runs, self.aligned, self.began, self.axes = 0, False, False, None
        self.diverged, self.lost, self.warnings = [], [], []
        self.in_force = InForce()
        # By seed: position RMSE over the run (ATE Sim(3) where the truth is measured), infinite of a run that diverged; what is
        # stated of it; the mean NEES of its poses.
        self.error, self.stated_sigma, self.run_nees = {}, {}, {}
        self.frames, self.scalars, self.coverage = [], {}, {}
        self.counts = {what: np.zeros(3, int) for what in COUNTS}
        self.ages, self.tracks = LandmarkAges(), RecordedTracks()
        self.times, self.stages = {}, {}

    @property
    def is_ideal(self) -> bool:
        return self.about["kind"] == "ideal_covariance"

    @property
    def judged(self) -> str:
        """A batch is judged by what it is for: its filtered trajectory is its front window's."""
        return "smoothed" if self.about["kind"] == "batch" else "filtered"

    def add(self, run: dict) -> None:
        """A line of results.jsonl."""
        self.runs += 1
        seed, diverged = run["seed"], run["diverged"]
        self.error[seed] = np.inf
        if diverged is not None:
            self.diverged.append({"seed": seed, "frame": diverged.get("frame"), "reason": diverged["reason"]})
        if "frames" not in run:
            return  # it never began
        self.began = True
        self._add_statements(seed, run)
        frames = run.get("smoothed_frames" if self.judged == "smoothed" else "frames")
        if frames is not None:
            self._add_frames(seed, RunFrames(frames))
        self._add_counts(run)
        self._add_values("run", run, "", diverged)
        if diverged is None:
            self._add_judged(seed, run)

    def _add_statements(self, seed: int, run: dict) -> None:
        """What the run says of itself, and where it was lost."""
        if run["lost_at"] is not None:
            self.lost.append({"seed": seed, "frame": count(run["lost_at"])})
        if found := warnings_of(run):
            self.warnings.append({"seed": seed, "warnings": found})
        if "in_force" in run:
            self.in_force.add(run["in_force"])

    def _add_frames(self, seed: int, frames: RunFrames) -> None:
        self.frames.append(frames)
        if len(frames.frame) == 0:
            return
        self.stated_sigma[seed] = frames.stated_sigma()
        if "pose" in frames.nees:
            of_run = run_nees(frames.nees["pose"])
            self.run_nees[seed] = (of_run, None if of_run.began is None else frames.frame[of_run.began])

    def _add_counts(self, run: dict) -> None:
        self.axes = run.get("axes", self.axes)
        self.ages.add(run["landmarks"])
        self.tracks.add(run["tracks"])
        for what, total in self.counts.items():
            right, wrong, undecided = run[what]
            total += [count(right), count(wrong), count(undecided)]
        for key, value in run["coverage"].items():
            self.coverage[key] = self.coverage.get(key, 0.0) + number(value)

    def _add_judged(self, seed: int, run: dict) -> None:
        self.aligned = run.get("aligned", False)
        if run[self.judged] is None:
            return  # a batch that was not solved
        error = number(run[self.judged].get("ate_sim3_m" if self.aligned else "position_rmse_m"))
        self.error[seed] = error
        for which in trajectories_of(run):
            self._add_values("trajectory", run[which], f"{which}_", None)

    def _add_values(self, scope: str, values: dict | None, prefix: str, diverged: dict | None) -> None:
        """One that is not defined (no landmark was ever decided) is no sample. Nor are poses at a lag of a run that diverged,
        whose RMSE is not counted either."""
        for metric in self.metrics if values is not None else []:
            key = metric["key"]
            if metric["of"] != scope or metric["pooled"] not in POOLED or (key.startswith("lag.") and diverged is not None):
                continue
            if values.get(key) is not None:
                self.scalars.setdefault(prefix + key, (metric, []))[1].append(number(values[key]))

    def add_timing(self, timing: dict) -> None:
        """A line of timing.jsonl."""
        timed = ["seconds"] + [m["key"] for m in self.metrics if m["pooled"] == "timing" and m["key"] in timing]
        for key in timed:
            self.times.setdefault(key, []).append(number(timing[key]))
        for stage, ms in timing.get("stages_ms", {}).items():
            self.stages[stage] = self.stages.get(stage, 0.0) + number(ms)

    def _nees_by_run(self) -> dict:
        """Of each run's mean pose NEES: quantiles, how many are more than chance allows, and the worst."""
        means = [run.mean for run, _ in self.run_nees.values() if not np.isnan(run.mean)]
        exceeding = sorted((seed for seed, (run, _) in self.run_nees.items() if run.exceeds), key=lambda seed: (-self.run_nees[seed][0].mean, seed))
        worst = [{"seed": seed, "mean": self.run_nees[seed][0].mean, "began": self.run_nees[seed][1]} for seed in exceeding[:WORST]]
        return {"runs": len(means), "exceeding": len(exceeding), "quantiles": [intervals.quantile(means, p) for p in (0.1, 0.5, 0.9)], "worst": worst}

    def json(self) -> dict:
        about = self.about
        json = {"label": about["label"], "estimator": about["estimator"], "kind": about["kind"], "oracle": about["oracle"], "runs": self.runs,
                "aligned": self.aligned, "diverged": self.diverged, "lost": self.lost, "warnings": self.warnings, "configuration": about["configuration"]}
        if self.in_force.runs:
            json["in_force"] = self.in_force.json()
        if not self.began:
            return json
        json |= {key: pooled(metric, samples).json() for key, (metric, samples) in sorted(self.scalars.items())}
        if self.run_nees:
            json["nees_by_run"] = self._nees_by_run()
        json |= self.counts | {"coverage": self.coverage, "timing": {key: intervals.quantile(s, 0.5) for key, s in self.times.items()}}
        json["timing"] |= {"stages_ms": self.stages, "total_seconds": sum(self.times.get("seconds", []))}
        statistics = FrameStatistics(self.frames)
        if not statistics.empty:
            json["anees"], json["per_frame"] = statistics.summary()
        if self.axes is not None:
            json["axes"] = self.axes
        return json | {"by_age": self.ages.json(), "tracks": self.tracks.json()}
