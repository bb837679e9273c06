"""Poses at a lag: what is known of a pose when it is so many frames old, by what estimators that keep past poses report of it."""
from dataclasses import dataclass

import metrics

QUANTITIES = (("position_rmse_m", "position RMSE [m]"), ("rotation_rmse_deg", "rotation RMSE [deg]"), ("nees_pose", "pose NEES"))
NEES_DOF = 6
EXPLAINED = ("Error and NEES of each pose when it is so many frames old; 0: as it was filtered. All lags are judged over the same frames, without the last 39. "
             "The gain of the EKF (ekf.lag) is what later measurements buy; what a window gains beyond it is relinearisation.")


@dataclass
class Line:
    """Estimates {value, lower, upper} of one quantity, in the order of the lags."""
    lags: list
    estimates: list

    def values(self, which="value"):
        return [e[which] for e in self.estimates]


def is_of_lag(key):
    return key.startswith("lag.")


def known_lags(table):
    return sorted({int(key.split(".")[1]) for key in table if is_of_lag(key)})


def line(table, quantity, value_of):
    """`value_of` gives the estimate of a key, or None; None where the estimator has no lags."""
    found = [(lag, value_of(f"lag.{lag}.{quantity}")) for lag in known_lags(table)]
    found = [(lag, e) for lag, e in found if e and e["value"] is not None]
    return Line(*map(list, zip(*found))) if found else None


def summary_lines(summary, cell):
    """By quantity, of a study's cell; none on measured truth, where errors without alignment are those of frame and scale."""
    if cell.get("aligned"):
        return {}
    table = metrics.read_table(summary["metrics"])
    lines = {quantity: line(table, quantity, cell.get) for quantity, _ in QUANTITIES}
    return {quantity: found for quantity, found in lines.items() if found}


def estimator_lines(comparison, estimator):
    """By quantity, of an estimator of a comparison: over its runs, with an interval where there are several; none on measured truth."""
    if comparison.aligned:
        return {}
    lines = {quantity: line(comparison.table, quantity, estimator.values.get) for quantity, _ in QUANTITIES}
    return {quantity: found for quantity, found in lines.items() if found}


def places(lags):
    """Where lags stand on a logarithmic axis: at the number of frames that the pose has then been seen in."""
    return [lag + 1 for lag in lags]
