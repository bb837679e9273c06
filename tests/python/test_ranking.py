"""The ranking of a study's configurations, on made-up summaries with known answers."""
import itertools
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
from slammot.report import ranking, study_verdict  # noqa: E402


def cell(label, error, anees, kind="filter", diverged=0, oracle=False):
    made = {"label": label, "estimator": "any", "kind": kind, "oracle": oracle, "runs": 10, "diverged": [{"seed": 1, "frame": 3}] * diverged, "lost": [],
            "configuration": {}, "timing": {"frame_median_ms": 1.0}}
    if error is not None:
        squares = [0.55 + 0.1 * i for i in range(10)]  # of a run's error over that of all; their mean is 1
        runs = [{"seed": i + 1, "position_rmse_m": 0.1 * error * s ** 0.5, "ideal_sigma_m": 0.1, "nees_pose": anees} for i, s in enumerate(squares)]
        made.update({"rmse_over_ideal": {"position": error, "runs": runs}, "anees": {"pose": {"mean": anees, "inside": 0.5}},
                     "static_often_seen": [8, 1, 1], "moving_often_seen": [10, 0, 0]})
    return made


def group(name, cells, **sweep):
    ideal = {**cell("ideal_covariance", None, None, "ideal_covariance"), "per_frame": {}}
    return {"name": name, "scenario": name, "sweep": {k.replace("scenario_", "scenario."): v for k, v in sweep.items()},
            "cells": cells + [ideal]}


def ranked(*groups):
    return ranking.ranking({"groups": list(groups)})


# A law; the groups of a study; its configurations from the best to the worst, with their costs; who is recommended.
LAWS = (
    ("error and sigma count alike, scenarios are factors",  # x: the root of 1 times 4; z: the stated sigma is half of the actual one
     [group("a", [cell("x", 1.0, 6.0), cell("y", 1.5, 6.0), cell("z", 1.0, 24.0)]),
      group("b", [cell("x", 4.0, 6.0), cell("y", 1.5, 6.0), cell("z", 1.0, 24.0)])],
     {"y": 1.5, "x": 2.0, "z": 2.0}, {"filter": "y"}),
    ("too careful is as wrong as too sure", [group("a", [cell("careful", 1.0, 3.0), cell("sure", 1.0, 12.0)])],
     {"careful": 1.414214, "sure": 1.414214}, {"filter": "careful"}),
    ("what diverged is last even without a number",
     [group("a", [cell("once", 1.0, 6.0, diverged=1), cell("never", 9.0, 600.0), cell("always", None, None, diverged=10)])],
     {"never": 90.0, "once": 1.0, "always": math.inf}, {"filter": "never"}),
    ("what failed in every run is not recommended",
     [group("a", [{**cell("lost", 1.0, 6.0), "lost": [{"seed": 1, "frame": 3}] * 10}, cell("kept", 2.0, 6.0)])],
     {"lost": 1.0, "kept": 2.0}, {"filter": "kept"}),
    ("an oracle is not recommended",
     [group("a", [cell("labels", 1.0, 6.0, oracle=True), cell("consistent", 2.0, 12.0), cell("worse", 4.0, 12.0),
                  cell("window", 2.5, 6.0, "smoother"), cell("window labels", 1.5, 6.0, "smoother", oracle=True)])],
     {"labels": 1.0, "window labels": 1.5, "window": 2.5, "consistent": 2.828427, "worse": 5.656854},
     {"smoother": "window", "filter": "consistent"}),
    ("a measured truth has no ideal covariance and is left out",
     [group("a", [cell("bad", 50.0, 600.0), cell("good", 1.2, 6.0)]),
      {**group("recorded", []), "cells": [cell("bad", None, None), cell("good", None, None), cell("ideal_covariance", None, None, "ideal_covariance")]}],
     {"good": 1.2, "bad": 500.0}, {"filter": "good"}),
    ("without an ideal covariance nothing is ranked", [{**group("a", []), "cells": [cell("x", 1.0, 6.0), cell("y", 2.0, 6.0)]}], {}, {}),
    ("without a finite cost nothing is recommended", [group("a", [cell("bad", None, None), cell("worse", None, None)])],
     {"bad": math.inf, "worse": math.inf}, {}),
    ("a smoother of any name is ranked as one, a batch is not",
     [group("a", [cell("x", 1.0, 6.0), cell("fixed_lag_of_tomorrow", 3.0, 6.0, "smoother"), cell("batch", 1.0, 6.0, "batch")])],
     {"x": 1.0, "fixed_lag_of_tomorrow": 3.0}, {"filter": "x", "smoother": "fixed_lag_of_tomorrow"}),
    ("swept settings make configurations and swept scenes make scenarios",
     [group(f"a{labels}{noise}", [cell("x", error, 6.0)], labels=labels, scenario_noise=noise) for labels, noise, error in (
         ("one_way", "1", 1.0), ("one_way", "2", 4.0), ("reversible", "1", 1.0), ("reversible", "2", 1.0))],
     {"x, labels = reversible": 1.0, "x, labels = one_way": 2.0}, {"filter": "x, labels = reversible"}))


class Ranking(unittest.TestCase):
    def test_who_is_before_whom_and_recommended(self):
        for law, groups, costs, recommended in LAWS:
            with self.subTest(law):
                rows = ranked(*groups)
                self.assertEqual([(r.label, round(r.cost, 6)) for r in rows], list(costs.items()))
                self.assertEqual({kind: row.label for kind, row in ranking.recommended(rows).items()}, recommended)
                said = "Recommended " + "; ".join(f"{kind}: {label}" for kind, label in recommended.items()) + "."
                self.assertEqual(ranking.sentence(rows), said if recommended else "")

    def test_the_cost_of_all_runs_and_without_each(self):
        rows = ranked(group("a", [cell("x", 1.0, 9.0), cell("y", 2.0, 2.0)]), group("b", [cell("x", 3.0, 24.0), cell("y", 1.5, 6.0)]))
        for row in rows:
            whole, *without = ranking.log_costs(row.cells, list(range(1, 11)))
            self.assertAlmostEqual(math.exp(whole), row.cost)
            self.assertEqual(len(without), 10)
            self.assertGreater(without[0], whole)  # the first run has the smallest error

    def test_configurations_differ_where_all_runs_agree(self):
        best, worse = ranked(group("a", [cell("best", 1.0, 6.0), cell("worse", 1.3, 12.0)]))
        lower, upper = ranking.cost_ratio(worse, best)
        self.assertAlmostEqual(lower, 1.3 * 2 ** 0.5)  # the same in every run
        self.assertAlmostEqual(upper, 1.3 * 2 ** 0.5)
        self.assertIsNone(ranking.cost_ratio(best, best))

    def test_runs_in_which_now_one_and_now_the_other_is_better_do_not_tell(self):
        best, other = ranked(group("a", [cell("best", 1.0, 6.0), cell("other", 1.01, 6.0)]))
        runs = other.cells[0]["rmse_over_ideal"]["runs"]
        for seed, run in zip(range(10, 0, -1), runs):
            run["seed"] = seed
        lower, upper = ranking.cost_ratio(other, best)
        self.assertLess(lower, 1.0)
        self.assertGreater(upper, 1.0)

    def test_no_interval_with_few_runs_or_one_that_diverged_or_is_infinite(self):
        best, other = ranked(group("a", [cell("best", 1.0, 6.0), cell("other", 1.3, 6.0)]))
        runs, of_best = (row.cells[0]["rmse_over_ideal"]["runs"] for row in (other, best))
        runs.pop()
        self.assertIsNone(ranking.cost_ratio(other, best))
        of_best.pop()
        self.assertIsNotNone(ranking.cost_ratio(other, best))
        of_best[4]["nees_pose"] = None  # infinite
        self.assertIsNone(ranking.cost_ratio(other, best))
        del runs[4:], of_best[4:]
        self.assertIsNone(ranking.cost_ratio(other, best))


def judged(label, low, high, runs, kind="filter"):
    pose = {"dof": 6, "mean": (low + high) / 2, "lower": low, "upper": high, "runs": runs, "inside": 0.5, "infinite": 0}
    return {**cell(label, None, None, kind), "anees": {"pose": pose}}


class Verdict(unittest.TestCase):
    def of(self, *cells):
        return study_verdict.consistency_of({"groups": [{"cells": [c]} for c in cells]}, "x")

    def test_a_few_runs_call_nobody_overconfident(self):
        few = judged("x", 7.0, 9.0, 4)
        few["anees"]["pose"].update(lower=None, upper=None)
        self.assertIn("fewer than five runs decide nothing", self.of(few))
        self.assertIn("x is overconfident:", self.of(judged("x", 7.0, 9.0, 5)))

    def test_conservative_scenarios_are_not_hidden_by_an_overconfident_one(self):
        text = self.of(judged("x", 7.0, 9.0, 10), judged("x", 3.0, 5.0, 10), judged("x", 3.0, 5.0, 10))
        self.assertIn("overconfident in 1 of 3 scenarios and conservative in 2 of 3 scenarios", text)

    def test_who_diverges_is_not_more_accurate(self):
        difference = {"value": -0.01, "lower": -0.02, "upper": -0.001, "runs": 12}
        pair = {"a": "x", "b": "y", "pairs": 50, "wins_a": 12, "wins_b": 38, "p": 0.01, "p_holm": 0.01, "position_rmse_difference_m": difference}
        self.assertIn("No difference is decided", study_verdict.pairs({"groups": [{"pairs": [pair]}]})[0][1][0])
        pair["wins_a"], pair["wins_b"] = 22, 28
        difference["runs"] = 50  # all have finished
        self.assertIn("More accurate (paired t tests, 5%): x than y.", study_verdict.pairs({"groups": [{"pairs": [pair]}]})[0][1][0])

    def test_every_decided_pair_is_named_in_one_sentence(self):
        names = [f"e{i}" for i in range(5)]
        difference = {"value": -0.01, "lower": -0.02, "upper": -0.001, "runs": 12}
        pairs = [{"a": a, "b": b, "pairs": 12, "wins_a": 12, "wins_b": 0, "p_holm": 0.01 if (a, b) != ("e3", "e4") else 0.06,
                  "position_rmse_difference_m": difference} for a, b in itertools.combinations(names, 2)]
        sentence, = study_verdict.pairs({"groups": [{"pairs": pairs}]})[0][1]
        self.assertEqual(sentence, "More accurate (paired t tests, 5% over all 10 pairs by Holm's correction): "
                                   "e0 than e1, e2, e3, e4; e1 than e2, e3, e4; e2 than e3, e4.")


if __name__ == "__main__":
    unittest.main()
