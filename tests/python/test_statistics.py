"""The judge's statistics on series with known answers: intervals cover what they say, in series that are correlated and skewed
as ours are; NEES of runs; paired differences."""
import itertools
import math
import pathlib
import sys
import unittest

import numpy as np
import pandas as pd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
import slammot  # noqa: E402
from slammot.judge import consistency, intervals, paired  # noqa: E402

COUNTS = (5, 10, 20, 50)  # of runs
SAMPLES = 100_000  # simulated runs, of which each count makes as many studies as it can: 20,000 of five, 2,000 of fifty
NAN, INF = math.nan, math.inf


def squares(rng, shape, correlation, dof):
    """Frame by frame the sum of dof squared numbers, each an AR(1): a NEES, or a squared error."""
    x = rng.standard_normal((*shape, dof))
    while True:
        yield np.sum(x**2, axis=-1)
        x = correlation * x + math.sqrt(1.0 - correlation**2) * rng.standard_normal(x.shape)


def means(rng, frames, correlation, dof):
    """Of each run. One that is often correlated to the end of the run is as skewed as those of our studies (0.5 to 1.6)."""
    return sum(itertools.islice(squares(rng, (SAMPLES,), correlation, dof), frames)) / frames


def series(frames, correlation, seed):
    return np.array(list(itertools.islice(squares(np.random.default_rng(seed), (), correlation, 6), frames)))


def grouped(samples, count):
    """As studies of so many runs: (studies, runs)."""
    return samples[:len(samples) // count * count].reshape(-1, count)


class Coverage(unittest.TestCase):
    """By simulation: of how many studies the 95% interval contains the truth, in percent. A percentile bootstrap does of fewer
    than 88% of those of five strongly correlated runs."""

    @classmethod
    def setUpClass(cls):
        rng = np.random.default_rng(3)
        cls.nees = {"weakly": means(rng, 60, 0.9, 6), "strongly": means(rng, 30, 0.985, 6)}
        cls.square = {"weakly": means(rng, 60, 0.9, 3), "strongly": means(rng, 40, 0.97, 3)}
        cls.other = means(rng, 40, 0.97, 3)

    def covered(self, what, limits_of, truth):
        for count in COUNTS:
            lower, upper = limits_of(count)
            share = 100 * np.mean((lower <= truth) & (truth <= upper))
            self.assertTrue(93.0 <= share <= 97.0, f"{what}: {share:.1f}% at {count} runs")

    def test_anees(self):
        for how, of_runs in self.nees.items():
            self.covered(f"ANEES, {how} correlated", lambda n: intervals.ratio_of_sums(grouped(of_runs, n), np.ones((SAMPLES // n, n)))[1:], 6.0)

    def test_anees_of_runs_of_different_length(self):
        counts = np.random.default_rng(4).integers(40, 80, self.nees["weakly"].shape)
        sums = self.nees["weakly"] * counts
        self.covered("ANEES, lengths differ", lambda n: intervals.ratio_of_sums(grouped(sums, n), grouped(counts, n))[1:], 6.0)

    def test_rmse(self):
        for how, square in self.square.items():
            one, (_, lower, upper) = intervals.root_mean_square(np.sqrt(square[:9])), intervals.ratio_of_sums(square[:9], np.ones(9))
            self.assertTrue(np.allclose([one.lower**2, one.upper**2], [lower, upper]))  # as for all studies at once below

            def limits(n, square=square):
                return np.sqrt(intervals.ratio_of_sums(grouped(square, n), np.ones((SAMPLES // n, n)))[1:])
            self.covered(f"RMSE, {how} correlated", limits, math.sqrt(3.0))

    def test_paired_differences(self):
        """Of the RMSEs of two estimators that share half of their error."""
        a, b = (np.sqrt(0.5 * self.square["strongly"] + 0.5 * x) for x in (self.other, self.other[::-1]))

        def limits(n):
            estimates = [intervals.mean(row) for row in grouped(a - b, n)[:2000]]
            return np.array([[e.lower, e.upper] for e in estimates]).T
        self.covered("difference of RMSEs", limits, 0.0)

    def test_the_median_covers_at_least(self):
        estimates = [intervals.median(row) for row in grouped(self.nees["weakly"], 20)[:1000]]
        truth = np.median(self.nees["weakly"])
        self.assertGreater(np.mean([e.lower <= truth <= e.upper for e in estimates]), 0.94)


class Intervals(unittest.TestCase):
    def test_fewer_than_five_runs_or_an_infinite_one_have_none(self):
        for estimate in (intervals.mean([1.0, 2, 3, 4]), intervals.mean([1.0, 2, 3, 4], positive=True), intervals.root_mean_square([1.0, 2]),
                         intervals.median([1.0, 2, 3, 4, 5]), intervals.mean([]), intervals.mean([1.0, 2, 3, 4, INF], positive=True)):
            self.assertTrue(math.isnan(estimate.lower) and math.isnan(estimate.upper), estimate)
        self.assertEqual(intervals.mean([1.0, 3.0]).value, 2.0)
        self.assertEqual(intervals.mean([1.0, 2, 3, 4, INF], positive=True).value, INF)

    def test_of_normal_samples_it_is_students_jackknifed_or_not(self):
        estimate, half = intervals.mean([1.0, 2, 3, 4, 5]), 2.7764451051977987 * math.sqrt(2.5 / 5)  # t(0.975, 4)
        self.assertAlmostEqual(estimate.upper, 3.0 + half)
        self.assertAlmostEqual(estimate.lower, 3.0 - half)
        x = np.array([1.0, 2, 4, 8, 16, 3])
        estimate = intervals.jackknife((x.sum() - x) / (len(x) - 1), x.mean())
        self.assertAlmostEqual(estimate.lower, intervals.mean(x).lower)

    def test_equal_samples_have_a_point(self):
        self.assertEqual(intervals.root_mean_square([2.0] * 6).json(), {"value": 2.0, "lower": 2.0, "upper": 2.0, "runs": 6})
        self.assertEqual(intervals.root_mean_square([0.0] * 6).upper, 0.0)

    def test_holm(self):
        self.assertEqual(intervals.holm([0.01, 0.04, 0.03]).tolist(), [0.03, 0.06, 0.06])
        self.assertEqual(intervals.holm([0.5, 0.9]).tolist(), [1.0, 1.0])

    def test_quantiles_are_numpys_and_may_be_infinite(self):
        x = [3.0, 1.0, 2.0, 10.0]
        self.assertEqual(intervals.quantile(x, 0.3), np.quantile(x, 0.3))
        self.assertEqual(intervals.quantile([1.0, INF, INF], 0.75), INF)
        self.assertTrue(math.isnan(intervals.quantile([], 0.5)))


class Nees(unittest.TestCase):
    def test_of_a_known_gaussian_is_its_dimension(self):
        rng = np.random.default_rng(1)
        A = rng.normal(size=(6, 6))
        P = A @ A.T + np.eye(6)
        errors = rng.multivariate_normal(np.zeros(6), P, size=4000)
        self.assertAlmostEqual(slammot.nees(errors, np.array([P] * 4000)).mean(), 6.0, delta=0.2)

    def test_a_broken_covariance_is_infinite_and_an_unstated_one_nan(self):
        values = slammot.nees(np.ones((3, 2)), [np.eye(2), -np.eye(2), np.full((2, 2), NAN)])
        self.assertEqual(values[:2].tolist(), [2.0, INF])
        self.assertTrue(math.isnan(values[2]))
        with self.assertRaisesRegex(ValueError, "n x d"):
            slammot.nees(np.ones((3, 2)), np.eye(2))

    def test_interval_of_the_literature(self):
        lower, upper = consistency.nees_interval(6, 50)
        self.assertAlmostEqual(float(lower), 5.0783, delta=1e-3)  # chi-square of 300 over 50
        self.assertAlmostEqual(float(upper), 6.9976, delta=1e-3)

    def test_anees_of_runs_that_end_early(self):
        runs = [series(60 - i, 0.9, i) for i in range(30)]
        anees = slammot.anees(runs)
        self.assertAlmostEqual(anees.estimate.value, np.concatenate(runs).mean())
        self.assertEqual(len(anees.per_frame), 60)
        self.assertEqual(anees.verdict, "not decided")
        self.assertGreater(anees.inside, 0.85)
        self.assertEqual(slammot.anees([4 * run for run in runs]).verdict, "overconfident")
        self.assertEqual(slammot.anees([run / 4 for run in runs]).verdict, "conservative")
        self.assertEqual(slammot.anees([4 * run for run in runs[:4]]).verdict, "not decided")  # fewer than five

    def test_anees_of_a_data_frame(self):
        table = pd.DataFrame(np.arange(12.0).reshape(6, 2))
        self.assertEqual(slammot.anees(table, dof=3).estimate.value, 5.5)

    def test_effective_samples_are_those_of_theory(self):
        self.assertAlmostEqual(consistency.effective_samples(series(10000, 0.0, 1)) / 10000, 1.0, delta=0.1)
        r = 0.9 * 0.9  # the square of an AR(1) has the correlation squared
        self.assertAlmostEqual(consistency.effective_samples(series(10000, 0.9, 2)) / 10000, (1 - r) / (1 + r), delta=0.03)
        self.assertEqual(consistency.effective_samples([1.0, -1.0, 1.0, -1.0]), 4.0)
        self.assertEqual(consistency.effective_samples([11.3, 1e300, 4.4]), 3.0)

    def test_a_consistent_run_is_allowed(self):
        exceeding = sum(consistency.run_nees(series(300, 0.9, seed)).exceeds for seed in range(200))
        self.assertLessEqual(exceeding, 9)  # one in a hundred by name; estimating the correlation costs a few

    def test_where_a_run_began_to_be_too_large(self):
        nees = series(600, 0.9, 5)
        nees[200:] *= 4.0
        self.assertAlmostEqual(consistency.run_nees(nees).began, 200, delta=15)
        infinite = consistency.run_nees([5.0, NAN, INF, 7.0])
        self.assertEqual((infinite.mean, infinite.exceeds, infinite.began), (INF, True, 2))
        self.assertFalse(consistency.run_nees([NAN]).exceeds)


class Paired(unittest.TestCase):
    def test_rounding_is_a_tie_and_a_diverged_run_loses(self):
        pair = paired.paired([0.5, INF, 0.5, INF], [0.5 * (1 + 1e-12), INF, 0.5 * (1 + 1e-6), 0.5])
        self.assertEqual((pair.pairs, pair.wins_a, pair.wins_b, pair.difference.runs), (4, 1, 1, 2))
        rounded = paired.paired([0.5] * 6, [0.5 * (1 + 1e-12)] * 6)
        self.assertEqual((rounded.p, rounded.difference.json()), (1.0, {"value": 0.0, "lower": 0.0, "upper": 0.0, "runs": 6}))

    def test_who_is_better(self):
        rng = np.random.default_rng(2)
        a, noise = rng.uniform(1, 2, 20), rng.normal(0, 0.05, 20)
        self.assertEqual(slammot.compare(a, a + 0.1 + noise).better(), "a")
        self.assertIsNone(slammot.compare(a, a + noise - noise.mean()).better())
        self.assertIsNone(slammot.compare(a[:4], a[:4] + 1.0 + noise[:4]).better())  # fewer than five
        lost = a.copy()
        lost[:15] = INF
        self.assertIsNone(slammot.compare(lost, a + 0.1 + noise).better())  # better where it finished, but it lost more

    def test_series_are_paired_by_their_index(self):
        a = pd.Series([1.0, 2, 3, 4, 5, 6], index=range(1, 7))
        b = pd.Series([6.5, 5.5, 4.5, 3.5, 2.5, 9.0], index=[6, 5, 4, 3, 2, 70])
        pair = slammot.compare(a, b)
        self.assertEqual((pair.pairs, pair.difference.value, pair.wins_a), (5, -0.5, 5))
        with self.assertRaisesRegex(ValueError, "twice"):
            slammot.compare(pd.concat([a, a]), b)

    def test_columns_of_data_frames_are_corrected(self):
        rng = np.random.default_rng(8)
        a = pd.DataFrame(rng.normal(size=(20, 12)), columns=[f"m{i}" for i in range(12)]).assign(label="ekf")
        b = a.assign(label="window", m0=a["m0"] + 1.0 + 0.1 * rng.normal(size=20), m1=a["m1"] + 0.02 + 0.04 * rng.normal(size=20))
        table = slammot.compare(a, b)
        self.assertEqual(table.loc["m0", "better"], "a")
        self.assertNotIn("label", table.index)
        self.assertGreaterEqual(table.loc["m1", "p"], slammot.compare(a["m1"], b["m1"]).p)
        with self.assertRaisesRegex(ValueError, "no pairs"):
            slammot.compare([1.0], [1.0, 2.0])


if __name__ == "__main__":
    unittest.main()
