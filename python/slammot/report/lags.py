"""Poses at a lag: what is known of a pose when it is so many frames old, by what estimators that keep past poses report of it."""
from dataclasses import dataclass

from . import metrics

QUANTITIES = (("position_rmse_m", "position RMSE [m]"), ("rotation_rmse_deg", "rotation RMSE [deg]"), ("nees_pose", "pose NEES"))
# Of each run: its value at the lag over that of the same run as filtered. Pooled values hide what all runs gain behind a few bad ones.
RATIOS = (("position_rmse_ratio", "position RMSE"), ("rotation_rmse_ratio", "rotation RMSE"), ("nees_pose_ratio", "pose NEES"))
EXPLAINED = ("Error and NEES of each pose when it is so many frames old; 0: as it was filtered. All lags are judged over the same frames, without the last 39. "
             "The gain of the EKF (ekf.lag) is what later measurements buy; what a window gains beyond it is relinearisation.")
OVER_FILTERED = "Over filtered: the value of a run over that of the same run as filtered, mean over the runs."


@dataclass
class Line:
    """Estimates {value, lower, upper} of one quantity, in the order of the lags."""
    lags: list
    estimates: list

    def values(self, which="value"):
        return [e[which] for e in self.estimates]

    def of_lag(self, lag):
        return dict(zip(self.lags, self.estimates)).get(lag)


def is_of_lag(key):
    return key.startswith("lag.")


def known_lags(table):
    return sorted({int(key.split(".")[1]) for key in table if is_of_lag(key)})


def line(table, quantity, value_of):
    """`value_of` gives the estimate of a key, or None; None where the estimator has no lags."""
    found = [(lag, value_of(f"lag.{lag}.{quantity}")) for lag in known_lags(table)]
    found = [(lag, e) for lag, e in found if e and e["value"] is not None]
    return Line(*map(list, zip(*found))) if found else None


def lines(table, aligned, value_of):
    """By quantity and ratio; none on measured truth, where errors without alignment are those of frame and scale."""
    found = {} if aligned else {quantity: line(table, quantity, value_of) for quantity, _ in QUANTITIES + RATIOS}
    return {quantity: line for quantity, line in found.items() if line}


def summary_lines(summary, cell):
    """Of a study's cell."""
    return lines(metrics.read_table(summary["metrics"]), cell.get("aligned"), cell.get)


def estimator_lines(comparison, estimator):
    """Of an estimator of a comparison: over its runs, with an interval where there are several."""
    return lines(comparison.table, comparison.aligned, estimator.values.get)


def places(lags):
    """Where lags stand on a logarithmic axis: at the number of frames that the pose has then been seen in."""
    return [lag + 1 for lag in lags]
