"""JSON as the program writes it: null is what is not defined (NaN) or, of a NEES, infinite."""
from __future__ import annotations

import json
import math

import numpy as np


def number(value) -> float:
    """null is NaN."""
    if value is None:
        return math.nan
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError("not a number")
    return float(value)


def numbers(values: list) -> np.ndarray:
    return np.array(values, float).reshape(len(values))


def nees_numbers(values) -> np.ndarray:
    """null was infinite: a covariance was not positive definite."""
    found = numbers(values)
    if (found < 0.0).any():
        raise ValueError("a NEES is negative")
    return np.where(np.isnan(found), np.inf, found)


def count(value) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
        raise ValueError("not a count")
    return value


def plain(value):
    """What json.dumps takes: no numpy, and null for what is not finite."""
    if isinstance(value, dict):
        return {key: plain(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else None
    return value


def dumped(value) -> str:
    return json.dumps(plain(value), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
