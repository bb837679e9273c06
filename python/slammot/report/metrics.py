"""The table of metrics as the program writes it into compare.json and summary.json: what each number is."""
import math
from dataclasses import dataclass

UNDEFINED = "–"


@dataclass(frozen=True)
class Metric:
    key: str
    path: str       # in metrics.json, dotted; below `filtered` and `smoothed` where `of` is trajectory
    of: str         # trajectory | run
    name: str
    unit: str
    caption: str
    form: str       # real | count | ratio
    decimals: int
    better: str     # smaller | larger | expected | neither
    expected: str   # the key of the metric that says what a consistent run has
    on_page: bool
    pooled: str     # over the runs of a study: mean | rms | timing | not


def read_table(rows):
    """Of the list in a file, by key. Keys that this version does not know are passed over."""
    known = Metric.__dataclass_fields__
    return {row["key"]: Metric(**{name: row[name] for name in known}) for row in rows}


# Of a trajectory on measured truth: the others depend on the frame and the scale, which nothing tells.
RANKED_ALIGNED = ("ate_sim3_m", "rpe_1s_scaled_position_rmse_m", "rpe_1s_rotation_rmse_deg", "rpe_tenth_scaled_percent", "rpe_tenth_rotation_deg_per_m",
                  "rpe_kitti_scaled_percent", "rpe_kitti_rotation_deg_per_m")


def is_ranked(metric, aligned):
    """Whether one run may be called the best by this metric."""
    return metric.of == "run" or not aligned or metric.key in RANKED_ALIGNED


def heading(metric):
    return f"{metric.name} [{metric.unit}]" if metric.unit else metric.name


def text(metric, value):
    if value is None:
        return UNDEFINED
    if metric.form == "ratio":
        return f"{100 * value:.1f}%"
    if value and abs(value) < 0.5 * 10.0 ** -metric.decimals and metric.form == "real":
        return f"{value:.2g}"
    return f"{value:.{0 if metric.form == 'count' else metric.decimals}f}"


def equal(a, b):
    """Whether two values differ by no more than rounding."""
    return a is not None and b is not None and math.isclose(a, b, rel_tol=1e-9)


def best(metric, values, expected):
    """The best of these values, or None where the metric has none or all are equal."""
    values = [value for value in values if value is not None]
    if metric.better == "neither" or not values or equal(min(values), max(values)):
        return None
    if metric.better == "expected":
        return min(values, key=lambda value: abs(value - expected)) if expected is not None else None
    return min(values) if metric.better == "smaller" else max(values)
