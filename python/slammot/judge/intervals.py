"""Intervals over runs. Runs are independent; frames and landmarks of one run are not, so a run is one sample.

Errors and NEES are positive and skewed, so their interval is Student's t of the logarithm of the mean (delta method), which
simulations of our series confirm at 5 to 50 runs (tests/python/test_statistics.py). Differences have both signs: plain t. Where a
few lost runs carry most of a mean (skewness above 3) no interval of so few runs is right, and this one covers 88 to 93%.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

FEWEST = 5  # runs from which there is an interval
FEW = "fewer than five runs"
LEVEL = 0.95


@dataclass(frozen=True)
class Estimate:
    """A number over runs with its two-sided 95% interval, which is NaN where there is none (fewer than five runs)."""
    value: float
    lower: float = np.nan
    upper: float = np.nan
    runs: int = 0

    def json(self) -> dict:
        return {"value": self.value, "lower": self.lower, "upper": self.upper, "runs": self.runs}


def ratio_of_sums(sums: ArrayLike, counts: ArrayLike) -> tuple[NDArray, NDArray, NDArray]:
    """Mean over all samples of all runs, and its interval: (value, lower, upper), each of shape (...).

    sums, counts: (..., runs), what each run adds; a run without samples (count 0) says nothing. The standard error is that
    of a ratio estimator (Cochran, Sampling Techniques, 1977, eq. 2.46), the interval is on the logarithmic scale.
    """
    sums, counts = np.asarray(sums, float), np.asarray(counts, float)
    with np.errstate(all="ignore"):
        total, runs = counts.sum(-1), (counts > 0).sum(-1)
        value = sums.sum(-1) / total
        residuals = np.where(counts > 0, sums - value[..., None] * counts, 0.0)
        error = np.sqrt(runs / (runs - 1) * (residuals**2).sum(-1)) / total
        half = stats.t.ppf(0.5 + LEVEL / 2, runs - 1) * np.where(value == 0.0, 0.0, error / value)
        enough = runs >= FEWEST
        return value, np.where(enough, value * np.exp(-half), np.nan), np.where(enough, value * np.exp(half), np.nan)


def mean(samples: ArrayLike, positive: bool = False) -> Estimate:
    """The mean of one sample a run. `positive` says that they can have one sign only, as an error or a NEES."""
    samples = np.asarray(samples, float)
    runs = len(samples)
    if positive and np.isfinite(samples).all():
        return Estimate(*map(float, ratio_of_sums(samples, np.ones(runs))), runs)
    value = float(np.mean(samples)) if runs else np.nan
    if runs < FEWEST or not np.isfinite(samples).all():
        return Estimate(value, runs=runs)
    half = float(stats.t.ppf(0.5 + LEVEL / 2, runs - 1) * np.std(samples, ddof=1) / np.sqrt(runs))
    return Estimate(value, value - half, value + half, runs)


def share(samples: ArrayLike) -> Estimate:
    """The share of the runs that are 1 and not 0, with Wilson's (1927) interval."""
    samples = np.asarray(samples, float)
    value, runs = float(samples.mean()), len(samples)
    if runs < FEWEST:
        return Estimate(value, runs=runs)
    interval = stats.binomtest(round(samples.sum()), runs).proportion_ci(LEVEL, method="wilson")
    return Estimate(value, float(interval.low), float(interval.high), runs)


def root_mean_square(samples: ArrayLike) -> Estimate:
    """Of one RMSE a run: the interval is that of the mean square."""
    square = mean(np.asarray(samples, float) ** 2, positive=True)
    return Estimate(*(float(np.sqrt(x)) for x in (square.value, square.lower, square.upper)), square.runs)


def median(samples: ArrayLike) -> Estimate:
    """With the interval between order statistics, which covers at least 95% for any distribution (Conover 1999, 3.2); it
    needs six runs."""
    ordered = np.sort(np.asarray(samples, float))
    runs = len(ordered)
    below = int(stats.binom.ppf(0.5 - LEVEL / 2, runs, 0.5)) if runs else 0  # order statistics left out on each side, plus one
    limits = (float(ordered[below - 1]), float(ordered[runs - below])) if below > 0 else (np.nan, np.nan)
    return Estimate(quantile(ordered, 0.5), *limits, runs)


def jackknife(values_without: ArrayLike, value: float) -> Estimate:
    """Student's t interval of a statistic of n runs from the n values that it has without each of them (Tukey 1958)."""
    values = np.asarray(values_without, float)
    pseudo = len(values) * value - (len(values) - 1) * values
    around = mean(pseudo)
    return Estimate(value, value - (around.value - around.lower), value + (around.upper - around.value), len(values))


def quantile(samples: ArrayLike, p: float) -> float:
    """Linear between order statistics; infinite samples are legal, no samples are NaN."""
    ordered = np.sort(np.asarray(samples, float))
    if len(ordered) == 0:
        return np.nan
    place = p * (len(ordered) - 1)
    below, above = ordered[int(np.floor(place))], ordered[int(np.ceil(place))]
    return float(below if below == above else below + (place - np.floor(place)) * (above - below))


def holm(p: ArrayLike) -> NDArray:
    """Holm's (1979) adjusted p values: the chance of any false decision among all of them is at most the level."""
    p = np.asarray(p, float)
    order = np.argsort(p, kind="stable")
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)), 1.0)
    return adjusted
