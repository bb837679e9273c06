"""What the runs of a study and of a comparison say together, on made-up runs whose answers are known."""
import copy
import csv
import json
import math
import pathlib
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
from slammot.pooling import estimators, study  # noqa: E402
from slammot.pooling.frames import FrameStatistics, RunFrames  # noqa: E402
from slammot.pooling.json_files import plain  # noqa: E402

RUNS, FRAMES = 50, 100
STATED = (0.1, 0.05, 0.08)  # of an error of 0.1 m a component: honest, overconfident, ideal_covariance
LABELS = ("honest", "overconfident", "ideal_covariance")
METRICS = [{"key": "position_rmse_m", "of": "trajectory", "pooled": "rms", "form": "real", "path": "accuracy.position_rmse_m"},
           {"key": "nis_mean", "of": "run", "pooled": "mean", "form": "real", "path": "nis.mean"},
           {"key": "warned", "of": "run", "pooled": "mean", "form": "ratio", "path": "warned"},
           {"key": "frame_median_ms", "of": "run", "pooled": "timing", "form": "real", "path": "runtime.frame_median_ms"}]
COUNTS = {"static": [8, 1, 1], "moving": [5, 0, 2], "static_often_seen": [8, 0, 0], "moving_often_seen": [5, 0, 0],
          "standing_by_frame": [0, 0, 0], "moving_by_frame": [50, 10, 20]}


def plan():
    cells = [{"label": label, "estimator": label if label == "ideal_covariance" else "ekf", "oracle": False, "configuration": {},
              "kind": "ideal_covariance" if label == "ideal_covariance" else "filter"} for label in LABELS]
    return {"format": "slammot-plan-1", "name": "made", "runs": RUNS, "first_seed": 1, "metrics": METRICS, "figures": [],
            "groups": [{"name": "g", "scenario": "made", "sequence": None, "seeds": "simulations", "scene": {}, "sweep": {"k": "1"}, "cells": cells}]}


def landmark_nees(rng):
    """Of twenty landmarks whose errors have half their variance in common: their mean is 3, and scatters from run to run far
    more than that of sixty independent numbers."""
    common, own = rng.normal(size=(3, 1)), rng.normal(size=(3, 20))
    return float(np.mean(np.sum(0.5 * (common + own) ** 2, axis=0)))


def made_run(cell, seed):
    """Run 7 of the overconfident estimator diverges; it is worse by a centimetre in every run."""
    rng, sigma = np.random.default_rng(seed), STATED[cell]
    position, rotation = (np.sum((0.1 * rng.normal(size=(FRAMES, 3))) ** 2, axis=1) for _ in range(2))
    frames = {"frame": list(range(1, FRAMES + 1)), "position_error_m": np.sqrt(position), "rotation_error_deg": np.sqrt(rotation),
              "nees_pose": (position + rotation) / sigma**2, "nees_position": position / sigma**2, "nees_rotation": rotation / sigma**2,
              "position_sigma_m": [math.sqrt(3.0) * sigma] * FRAMES, "nees_landmark_position": [landmark_nees(rng) for _ in range(FRAMES)],
              "landmark_position_count": [20] * FRAMES, "nees_landmark_velocity": [None] * FRAMES, "landmark_velocity_count": [0] * FRAMES}
    landmarks = [{"observations": 5, "static_position_m": [0.1, 0.2, 0.3], "moving_position_m": [], "moving_velocity_m_s": [],
                  "nees_position_mean": 2.0 + seed % 2, "nees_position_count": 4, "nees_velocity_mean": None, "nees_velocity_count": 0}]
    diverged = {"frame": 100, "reason": "not a number"} if (cell, seed) == (1, 7) else None
    rmse = math.sqrt(position.mean()) + (0.01 if cell == 1 else 0.0)
    return plain({"cell": cell, "seed": seed, "diverged": diverged, "lost_at": None, "filtered": {"position_rmse_m": rmse}, "smoothed": None,
                  "nis_mean": 1.0, "warned": float(seed <= 10), **COUNTS, "coverage": {"offered": 10}, "frames": frames, "landmarks": landmarks, "tracks": []})


def summarised(runs, timing):
    """The one group of summary.json, and runs.csv."""
    with tempfile.TemporaryDirectory() as folder:
        for name, rows in (("results.jsonl", runs), ("timing.jsonl", timing)):
            pathlib.Path(folder, name).write_text("".join(json.dumps(row) + "\n" for row in rows))
        summary, table = study.summarise(plan(), pathlib.Path(folder))
        return plain(summary)["groups"][0], table


class Study(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.runs = [made_run(cell, seed) for cell in range(3) for seed in range(1, RUNS + 1)]
        cls.timing = [{"cell": run["cell"], "seed": run["seed"], "seconds": 1.0, "frame_median_ms": 2.0} for run in cls.runs]
        cls.group, cls.table = summarised(cls.runs, cls.timing)

    def test_what_the_runs_say(self):
        honest, sure, _ = self.group["cells"]
        self.assertAlmostEqual(honest["anees"]["pose"]["mean"], 6.0, delta=0.15)
        self.assertAlmostEqual(honest["anees"]["position"]["mean"], 3.0, delta=0.1)
        self.assertGreaterEqual(honest["anees"]["pose"]["inside"], 0.88)
        self.assertAlmostEqual(sure["anees"]["pose"]["mean"], 24.0, delta=0.6)
        self.assertEqual(sure["anees"]["pose"]["inside"], 0.0)
        self.assertEqual(honest["static"], [400, 50, 50])
        self.assertAlmostEqual(honest["filtered_position_rmse_m"]["value"], math.sqrt(0.03), delta=0.003)
        self.assertAlmostEqual(honest["rmse_over_ideal"]["position"], 0.1 / 0.08, delta=0.02)
        self.assertAlmostEqual(np.mean([run["nees_pose"] for run in honest["rmse_over_ideal"]["runs"]]), honest["anees"]["pose"]["mean"])
        age, = honest["by_age"]
        self.assertEqual((age["static_position_m"]["median"], age["nees_position"]["mean"], age["nees_velocity"]), (0.2, 2.5, None))
        self.assertEqual((honest["timing"]["frame_median_ms"], honest["timing"]["total_seconds"]), (2.0, RUNS))
        self.assertEqual(honest["nees_by_run"]["runs"], RUNS)
        self.assertEqual((honest["warned"]["value"], round(honest["warned"]["lower"], 3), round(honest["warned"]["upper"], 3)), (0.2, 0.112, 0.33))  # Wilson's
        self.assertEqual(sure["nees_by_run"]["exceeding"], RUNS)

    def test_an_interval_of_landmarks_counts_runs_not_landmarks(self):
        cell = self.group["cells"][0]
        anees = cell["anees"]["landmark_position"]
        self.assertAlmostEqual(anees["mean"], 3.0, delta=0.1)
        self.assertTrue(0.85 <= anees["inside"] <= 0.99)  # were all landmarks independent: about a half
        self.assertIsNone(cell["anees"]["landmark_velocity"]["mean"])
        self.assertEqual(len(cell["per_frame"]["anees_landmark_position_lower"]), FRAMES)

    def test_each_part_has_the_interval_of_its_degrees_of_freedom(self):
        f = self.group["cells"][0]["per_frame"]
        self.assertAlmostEqual(f["anees_pose_upper"][0], 7.0, delta=0.1)       # chi2inv(.975, 300) / 50
        self.assertAlmostEqual(f["anees_position_upper"][0], 3.72, delta=0.1)  # chi2inv(.975, 150) / 50
        self.assertEqual(f["anees_rotation_upper"], f["anees_position_upper"])

    def test_a_diverged_run_is_named_and_loses(self):
        cells = self.group["cells"]
        self.assertEqual([[lost["seed"] for lost in cell["diverged"]] for cell in cells], [[], [7], []])
        self.assertEqual(cells[1]["filtered_position_rmse_m"]["runs"], RUNS - 1)
        pair, = self.group["pairs"]  # the ideal covariance takes part in none
        self.assertEqual((pair["wins_a"], pair["wins_b"], pair["position_rmse_difference_m"]["runs"]), (RUNS, 0, RUNS - 1))
        self.assertAlmostEqual(pair["position_rmse_difference_m"]["value"], -0.01)
        self.assertLess(pair["p_holm"], 1e-6)

    def test_a_row_for_each_run(self):
        lines = self.table.splitlines()
        self.assertEqual(len(lines), 1 + 3 * RUNS)
        self.assertTrue(lines[0].startswith("scenario,group,estimator,label,k,seed,diverged,diverged_frame,failed,failed_frame,filtered_position_rmse_m"))
        self.assertTrue(lines[RUNS + 7].startswith("made,g,ekf,overconfident,1,7,1,100,0,,"))

    def test_where_the_scale_is_not_known_a_cell_has_the_shape_in_the_last_one(self):
        runs = [{**run, "last_scale": {"position_rmse_m": 0.5}} if run["cell"] == 1 else run for run in self.runs]
        group, table = summarised(runs, self.timing)
        self.assertEqual([cell.get("last_scale_position_rmse_m", {}).get("value") for cell in group["cells"]], [None, 0.5, None])
        rows = list(csv.DictReader(table.splitlines()))
        self.assertEqual([row["last_scale_position_rmse_m"] for row in rows[::RUNS]], ["", "0.5", ""])
        column = list(rows[0]).index("last_scale_position_rmse_m")
        others = [",".join(list(row.values())[:column] + list(row.values())[column + 1:]) for row in rows]
        self.assertEqual(others, self.table.splitlines()[1:])

    def test_what_is_no_line_of_a_run_is_refused(self):
        run = self.runs[0]
        frames = run["frames"]
        for bad in ({"cell": 0, "seed": 1}, {**run, "diverged": 3}, {**run, "static": [1]}, {**run, "cell": 7}, {**run, "lost_at": []},
                    {**run, "warnings": [{"frame": -1, "reason": "x"}]}, {**run, "frames": {**frames, "nees_pose": [-1.0] * FRAMES}},
                    {**run, "frames": {**frames, "frame": [1]}}, {**run, "coverage": {"offered": "x"}}):
            with self.assertRaisesRegex(study.BadLine, r"results\.jsonl:1: is no"):
                summarised([bad], self.timing[:1])
        for timing, reason in (([{"cell": 0, "seed": 1}, *self.timing[1:]], "1: is not the line"), (self.timing[:-1], "150: is not a line of JSON")):
            with self.assertRaisesRegex(study.BadLine, rf"timing\.jsonl:{reason}"):
                summarised(self.runs, timing)


class Frames(unittest.TestCase):
    def run_of(self, count, nees, **more):
        same = [0.1] * count
        return RunFrames({"frame": list(range(1, count + 1)), "position_error_m": same, "rotation_error_deg": same, "position_sigma_m": same,
                          "nees_pose": [nees] * count, **more})

    def test_the_mean_of_runs_that_end_early_lies_in_its_own_interval(self):
        pose = FrameStatistics([self.run_of(600, 6.0)] * 47 + [self.run_of(60, 500.0)] * 3).summary()[0]["pose"]
        self.assertAlmostEqual(pose["mean"], (47 * 600 * 6.0 + 3 * 60 * 500.0) / (47 * 600 + 3 * 60))
        self.assertTrue(pose["lower"] < pose["mean"] < pose["upper"])
        self.assertEqual(pose["runs"], 50)

    def test_without_an_interval_no_frame_is_outside_it(self):
        landmarks = {"nees_landmark_position": [3.0] * 20, "landmark_position_count": [5] * 20}
        anees, per_frame = FrameStatistics([self.run_of(20, 6.0, **landmarks)]).summary()
        self.assertTrue(math.isnan(anees["landmark_position"]["inside"]))
        self.assertEqual(anees["pose"]["inside"], 1.0)
        self.assertTrue(np.isnan(per_frame["anees_landmark_position_lower"]).all())

    def test_a_covariance_that_is_not_positive_definite_is_infinite(self):
        anees, _ = FrameStatistics([self.run_of(20, None), self.run_of(20, 6.0)]).summary()
        self.assertEqual((anees["pose"]["mean"], anees["pose"]["infinite"]), (math.inf, 20))


class Comparison(unittest.TestCase):
    def entry(self, name, error, sequence="s", coverage=1.0, kind="filter"):
        frames = {"frame": [1, 2], "timestamp": [0.1, 0.2], "position_error_m": [error] * 2, "rotation_error_deg": [1.0] * 2,
                  "position_sigma_m": [1.0] * 2, "nees_pose": [6.0, 7.0]}
        judged = {"accuracy": {"position_rmse_m": error, "coverage": coverage}, "nees": {"pose": {"used": 2}}}
        lost = {"accuracy": {"position_rmse_m": 100.0, "coverage": coverage}, "nees": None}
        of_run = {"filtered": lost, "smoothed": judged} if kind == "batch" else {"filtered": judged, "smoothed": None}
        return {"pooled": name, "kind": kind, "sequence": {"sha256": sequence}, "frames": frames,
                "metrics": {"divergence": None, "warnings": [], "failed_at": None, "nis": {"mean": 2.0}, **of_run}}

    def pooled(self, *runs):
        return plain(estimators.pooled({"sequence": {"exact_truth": True, "sha256": "s"}, "metrics": METRICS, "runs": list(runs)}))

    def test_runs_of_one_name_are_one_estimator(self):
        found = self.pooled(*(self.entry("a", 0.1 * i) for i in range(1, 7)), self.entry("b", 0.5))
        a, b = found["estimators"]
        self.assertEqual((a["runs"], b["runs"], a["anees"]["pose"]["mean"]), (6, 1, 6.5))
        self.assertAlmostEqual(a["values"]["position_rmse_m"]["value"], math.sqrt(np.mean(np.square(np.arange(1, 7) / 10))))
        self.assertEqual(a["per_frame"]["timestamp"], [0.1, 0.2])
        self.assertEqual([p["pairs"] for p in found["pairs"]], [1])

    def test_a_batch_is_judged_by_what_it_smooths(self):
        batch, = self.pooled(self.entry("batch", 0.25, kind="batch"))["estimators"]
        self.assertEqual(batch["values"]["position_rmse_m"]["value"], 0.25)

    def test_pairs_are_of_one_sequence_in_order_over_the_same_frames(self):
        runs = [self.entry("a", 0.1, "s1"), self.entry("a", 0.3, "s2"), self.entry("a", 0.5, "s2"),
                self.entry("b", 0.2, "s2"), self.entry("b", 0.6, "s2"), self.entry("b", 0.7, "s2"), self.entry("b", 0.1, "s1", coverage=0.8)]
        pair, = self.pooled(*runs)["pairs"]
        self.assertEqual((pair["pairs"], pair["wins_a"], pair["wins_b"]), (2, 1, 1))

    def test_a_diverged_run_loses_and_has_no_values(self):
        lost = copy.deepcopy(self.entry("a", 0.1))
        lost["metrics"]["divergence"] = {"frame": 2, "reason": "lost"}
        found = self.pooled(lost, self.entry("b", 9.0))
        self.assertEqual((found["estimators"][0]["diverged"], found["estimators"][0]["warned"], found["estimators"][0]["values"]), (1, 1, {}))
        self.assertEqual(found["pairs"][0]["wins_b"], 1)


if __name__ == "__main__":
    unittest.main()
