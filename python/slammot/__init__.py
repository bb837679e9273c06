"""slammot from Python: runs, studies and sequences as tables and arrays, the judge of runs, and estimators written in Python.

What needs pandas is loaded when it is first used, so that an estimator's process starts fast.
"""
import importlib

from .estimator import (Camera, CameraEstimate, Diverged, Estimator, Frame, FrameReport, KnownLandmarks,
                        LandmarkEstimate, Setup)

__version__ = "0.2.0"  # of the program

_LATER = {"evaluate": "judge.accuracy", "Evaluation": "judge.accuracy", "errors": "judge.accuracy", "align": "judge.alignment", "expected_nees": "judge.alignment", "Alignment": "judge.alignment",
          "nees": "judge.consistency", "anees": "judge.consistency", "Anees": "judge.consistency", "compare": "judge.paired",
          "Paired": "judge.paired", "holm": "judge.intervals", "Estimate": "judge.intervals", "read_run": "reading", "read_study": "reading", "read_sequence": "reading", "Run": "reading",
          "Sequence": "reading", "program": "program", "slammot": "program", "simulate": "program", "run": "program"}

__all__ = ["Camera", "CameraEstimate", "Diverged", "Estimator", "Frame", "FrameReport", "KnownLandmarks",
           "LandmarkEstimate", "Setup", *_LATER]


def __getattr__(name):
    if name not in _LATER:
        raise AttributeError(f"module 'slammot' has no attribute '{name}'")
    return getattr(importlib.import_module("." + _LATER[name], __name__), name)
