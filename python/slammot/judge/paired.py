"""Two estimators in runs that belong together: who has the smaller error, by how much, and is that chance?"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

from .intervals import FEWEST, Estimate, holm, mean

ROUNDING = 1e-9  # relative: rounding can have one sign in all pairs
LEVEL = 0.05


@dataclass(frozen=True)
class Paired:
    """`difference` is a - b with its interval, `p` that of Student's paired t test (1 with fewer than five runs)."""
    pairs: int
    wins_a: int
    wins_b: int
    difference: Estimate
    p: float

    def better(self, p: float | None = None, level: float = LEVEL) -> str | None:
        """"a", "b", or None where that is not decided; `p` is corrected for the number of pairs (intervals.holm). A diverged
        run has no difference, but it has lost: where some are, wins must agree."""
        return better(self.json(), self.p if p is None else p, level)

    def json(self) -> dict:
        return {"pairs": self.pairs, "wins_a": self.wins_a, "wins_b": self.wins_b, "difference": self.difference.json(), "p": self.p}


def better(pair: dict, p: float, level: float = LEVEL) -> str | None:
    """As Paired.better, of what Paired.json gives."""
    difference = pair["difference"]
    if not p < level or not difference["value"]:
        return None
    winner, loser = "ab" if difference["value"] < 0.0 else "ba"
    agree = difference["runs"] == pair["pairs"] or pair[f"wins_{winner}"] > pair[f"wins_{loser}"]
    return winner if agree else None


def paired(a: ArrayLike, b: ArrayLike) -> Paired:
    """Errors (n,) of the same runs by two estimators. A diverged run's is infinite: it loses, and the pair has no
    difference. Errors that differ by less than a billionth of the larger are equal."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    with np.errstate(invalid="ignore"):
        equal = np.where(np.isfinite(a) & np.isfinite(b), np.abs(a - b) <= ROUNDING * np.maximum(np.abs(a), np.abs(b)), a == b)
        differences = np.where(equal, 0.0, a - b)[np.isfinite(a) & np.isfinite(b)]
    return Paired(len(a), int((~equal & (a < b)).sum()), int((~equal & (b < a)).sum()), mean(differences), _p(differences))


def _p(differences: np.ndarray) -> float:
    if len(differences) < FEWEST or not differences.any():
        return 1.0
    if np.ptp(differences) == 0.0:
        return 0.0
    return float(stats.ttest_1samp(differences, 0.0).pvalue)


def compare(a: ArrayLike | pd.Series | pd.DataFrame, b: ArrayLike | pd.Series | pd.DataFrame) -> Paired | pd.DataFrame:
    """The errors of two estimators, run by run: smaller is better.

    a, b: (n,) errors in one order; or pandas series, paired by their index (the seed, or group and seed). Of data frames
    with such an index, a row for each column that both have: value, lower, upper (95%, a - b), runs, pairs, wins_a, wins_b,
    p (Holm's, corrected for the number of columns) and better (a, b or None).
    """
    if isinstance(a, pd.DataFrame) and isinstance(b, pd.DataFrame):
        numbers = [c for c in a.columns if c in b.columns and pd.api.types.is_numeric_dtype(a[c])]
        found = {c: compare(a[c], b[c]) for c in numbers}
        corrected = holm([pair.p for pair in found.values()])
        return pd.DataFrame([{**pair.difference.json(), "pairs": pair.pairs, "wins_a": pair.wins_a, "wins_b": pair.wins_b,
                              "p": p, "better": pair.better(p)} for pair, p in zip(found.values(), corrected)], index=list(found))
    if isinstance(a, pd.Series) and isinstance(b, pd.Series):
        if not (a.index.is_unique and b.index.is_unique):
            raise ValueError("an index names a run twice: set it to what tells runs apart, such as group and seed")
        shared = a.index.intersection(b.index)
        a, b = a[shared], b[shared]
    if len(np.asarray(a)) != len(np.asarray(b)):
        raise ValueError(f"{len(a)} and {len(b)} runs are no pairs")
    a, b = np.asarray(a, float), np.asarray(b, float)
    known = ~(np.isnan(a) | np.isnan(b))
    return paired(a[known], b[known])
