"""NEES and ANEES: does an estimator state the error that it has (Bar-Shalom, Li and Kirubarajan 2001, section 5.4)?"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from .intervals import Estimate, ratio_of_sums


def nees(errors: ArrayLike, covariances: ArrayLike) -> NDArray:
    """The normalised estimation error squared e' P^-1 e of each sample (Bar-Shalom et al. 2001, eq. 5.4.2-1); of a
    consistent estimator its mean is d.

    errors: (n, d), true less estimated; of a pose (d = 6) [dr (W, m), dtheta (C, rad)] with
        R_true = R_estimated Exp(dtheta). covariances: (n, d, d) of these errors.
    Returns (n,). Infinite where P is not positive definite, NaN where an error or a covariance is not stated (NaN).
    """
    errors, covariances = np.asarray(errors, float), np.asarray(covariances, float)
    if errors.ndim != 2 or covariances.shape != (*errors.shape, errors.shape[1]):
        raise ValueError(f"errors must be n x d and covariances n x d x d, not {errors.shape} and {covariances.shape}")
    return np.array([_nees(e, P) for e, P in zip(errors, covariances)])


def _nees(error: NDArray, covariance: NDArray) -> float:
    if np.isnan(error).any() or np.isnan(covariance).any():
        return np.nan
    if not np.isfinite(covariance).all() or not np.isfinite(error).all():
        return np.inf
    try:
        root = np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        return np.inf
    value = float(np.sum(np.linalg.solve(root, error) ** 2))
    return value if np.isfinite(value) else np.inf


def nees_interval(dof: int, runs: ArrayLike = 1, level: float = 0.95) -> tuple[NDArray, NDArray]:
    """Where the mean NEES of so many independent samples of a consistent estimator lies: chi-square quantiles of
    dof * runs over runs (Bar-Shalom et al. 2001, eq. 5.4.2-8). NaN for no run."""
    runs = np.asarray(runs, float)
    with np.errstate(all="ignore"):
        return tuple(stats.chi2.ppf(p, dof * runs) / runs for p in ((1 - level) / 2, (1 + level) / 2))


@dataclass(frozen=True)
class Anees:
    """The NEES averaged over the samples of all runs, with its 95% interval over runs."""
    dof: int
    estimate: Estimate
    per_frame: NDArray  # (frames,): mean over the runs that have the frame
    lower: NDArray      # (frames,): the 95% interval of a consistent estimator
    upper: NDArray
    inside: float       # share of the frames whose mean is in it

    @property
    def verdict(self) -> str:
        """overconfident, conservative, or not decided: with fewer than five runs nothing is."""
        if np.isinf(self.estimate.value) or self.estimate.lower > self.dof:
            return "overconfident"
        return "conservative" if self.estimate.upper < self.dof else "not decided"


def anees(runs: Sequence[ArrayLike] | ArrayLike, dof: int = 6) -> Anees:
    """The ANEES of Monte-Carlo runs (Bar-Shalom et al. 2001, eq. 5.4.2-6), over time too.

    runs: one NEES series (frames,) a run, or (runs, frames), or a pandas data frame with a row a run. Runs may end early.
        Leave out the first frame where its covariance is a pin. dof: 6 for a pose, 3 for a position or a rotation.
    """
    table = _rectangular([np.asarray(run, float) for run in np.asarray(runs)] if hasattr(runs, "to_numpy") else runs)
    there = ~np.isnan(table)
    value, low, high = ratio_of_sums(np.where(there, table, 0.0).sum(1), there.sum(1))
    count = there.sum(0)
    with np.errstate(all="ignore"):
        per_frame = np.where(there, table, 0.0).sum(0) / count
    lower, upper = nees_interval(dof, count)
    known = count > 0
    inside = float(np.mean((lower <= per_frame)[known] & (per_frame <= upper)[known])) if known.any() else np.nan
    return Anees(dof, Estimate(float(value), float(low), float(high), int((there.sum(1) > 0).sum())), per_frame, lower, upper,
                 inside)


def _rectangular(runs: Sequence[ArrayLike] | ArrayLike) -> NDArray:
    """Runs that end early have NaN for the rest."""
    series = [np.asarray(run, float).ravel() for run in runs]
    table = np.full((len(series), max(map(len, series), default=0)), np.nan)
    for row, one in zip(table, series):
        row[:len(one)] = one
    return table


def effective_samples(series: ArrayLike) -> float:
    """How many independent samples say as much about their mean as these correlated ones: n / (1 + 2 sum of
    autocorrelations), summed in pairs as long as a pair is positive (Geyer 1992). At least 1, at most n."""
    x = np.asarray(series, float)
    n, largest = len(x), np.max(np.abs(x), initial=0.0)
    x = x / largest if largest > 0.0 else x  # their squares shall not overflow
    x = x - x.mean() if n else x
    covariance = np.correlate(x, x, "full")[n - 1:] if n else np.zeros(1)
    if not covariance[0] > 0.0:
        return float(n)
    correlations = covariance / covariance[0]
    pairs = correlations[0:n - 1:2] + correlations[1:n:2]
    ended = np.flatnonzero(pairs <= 0.0)
    total = pairs[:ended[0] if len(ended) else len(pairs)].sum() - 0.5
    return max(n / max(2.0 * total, 1.0), 1.0)  # those that alternate are not worth more than independent ones


@dataclass(frozen=True)
class RunNees:
    """The mean NEES of one run over its frames; where it is more than a consistent run is allowed, `began` is the sample
    from which it is too large."""
    mean: float
    allowed: float
    began: int | None

    @property
    def exceeds(self) -> bool:
        return self.mean > self.allowed


def run_nees(series: ArrayLike, dof: int = 6, probability: float = 0.99) -> RunNees:
    """Is the mean of one run's NEES more than chance allows, given its own correlation from frame to frame?

    It began after the sample at which the sum of (NEES - 2 dof) last was zero before its maximum (Page's CUSUM, 1954). One
    infinite sample makes the mean infinite, from that sample on. NaN samples are left out.
    """
    series = np.asarray(series, float)
    if np.isinf(series).any():
        return RunNees(np.inf, float(dof), int(np.flatnonzero(np.isinf(series))[0]))
    at = np.flatnonzero(np.isfinite(series))
    finite = series[at]
    if len(finite) == 0:
        return RunNees(np.nan, np.nan, None)
    samples = effective_samples(finite)
    value, allowed = float(finite.mean()), float(stats.chi2.ppf(probability, dof * samples) / samples)
    return RunNees(value, allowed, int(at[_cusum_start(finite - 2.0 * dof)]) if value > allowed else None)


def _cusum_start(steps: NDArray) -> int:
    total = largest = 0.0
    zero = began = 0
    for i, step in enumerate(steps):
        total += step
        if total <= 0.0:
            total, zero = 0.0, i + 1
        if total > largest:
            largest, began = total, zero
    return began
