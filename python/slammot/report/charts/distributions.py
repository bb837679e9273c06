"""How the runs of each estimator of a study lie: boxes of their errors and NEES, with every run as a point."""
import math

import numpy

from .. import study_axes
from ..comparison import RUN_COLOURS, number
from ..study_tables import error_name, estimators_of, is_batch, is_ideal

FEWEST = 3  # runs that make a box
GOLDEN = 0.618034  # multiples of it, less their whole parts, lie evenly and never upon each other


def key_of(cell, quantity):
    """The column of runs.csv by which an estimator is judged, as everywhere on the page."""
    which = "smoothed" if is_batch(cell) else "filtered"
    error = "ate_sim3_m" if cell.get("aligned") else "position_rmse_m"
    return f"{which}_{error if quantity == 'error' else 'nees_pose'}"


def values_of(rows, group, cell, quantity):
    """(value, failed) of the runs of a cell that did not diverge."""
    key = key_of(cell, quantity)
    found = [(number(row.get(key)), row["failed"] == "1") for row in rows
             if row["group"] == group["name"] and row["label"] == cell["label"] and row["diverged"] != "1"]
    return [(value, failed) for value, failed in found if value is not None]


def box(axis, place, values, colour):
    """Quartiles and median, whiskers at 5% and 95%."""
    low, first, middle, third, high = numpy.quantile(values, (0.05, 0.25, 0.5, 0.75, 0.95))
    line = {"color": colour, "linewidth": 1.0}
    axis.bxp([{"whislo": low, "q1": first, "med": middle, "q3": third, "whishi": high, "fliers": []}], positions=[place], widths=0.62, vert=False,
             showfliers=False, manage_ticks=False, boxprops=line, whiskerprops=line, capprops=line, medianprops={"color": colour, "linewidth": 1.8})


def points(axis, place, runs, colour):
    """A dot for each run, a cross for one that failed; up and down a little, so that equal ones are seen."""
    for failed, marker, name in ((False, ".", "a run"), (True, "x", "a failed run")):
        shown = [(value, place + 0.5 * math.modf(GOLDEN * i)[0] - 0.25) for i, (value, lost) in enumerate(runs) if lost == failed]
        if shown:
            axis.plot(*zip(*shown), marker, color=colour, markersize=5, alpha=0.75)
            axis.plot([], [], marker, color="#555555", label=name)


def scale_of(values):
    """Positive values over more than a factor of ten are drawn on a logarithmic scale."""
    return {"xscale": "log"} if values and min(values) > 0 and max(values) > 10 * min(values) else {}


def panel(axis, cells, colour, names):
    """An estimator a line, from the top; `cells` are (cell, its runs)."""
    for i, (cell, runs) in enumerate(cells):
        if len(runs) >= FEWEST:
            box(axis, -i, [value for value, _ in runs], colour[cell["label"]])
        points(axis, -i, runs, colour[cell["label"]])
    axis.set(yticks=[-i for i in range(len(cells))], ylim=(0.6 - len(cells), 0.6))
    axis.set_yticklabels([cell["label"] for cell, _ in cells] if names else [])
    axis.grid(axis="y", visible=False)


def shown_groups(summary, rows):
    """(group, its estimators) where any has several runs."""
    groups = [(group, [cell for cell in group["cells"] if not is_ideal(cell)]) for group in summary["groups"]]
    return [(group, cells) for group, cells in groups if any(len(values_of(rows, group, cell, "error")) > 1 for cell in cells)]


def draw(plt, summary, rows):
    """None where there is one run of each."""
    groups = shown_groups(summary, rows)
    if not groups:
        return None
    labels = dict.fromkeys(cell["label"] for _, cell in estimators_of(summary))
    colour = {label: RUN_COLOURS[i % len(RUN_COLOURS)] for i, label in enumerate(labels)}
    heights = [0.9 + 0.34 * len(cells) for _, cells in groups]
    figure, axes = plt.subplots(len(groups), 2, figsize=(9.6, sum(heights)), squeeze=False, height_ratios=heights)
    for (errors, nees), (group, cells) in zip(axes, groups):
        for axis, quantity, name in ((errors, "error", f"{error_name(group)} [m]"), (nees, "nees", "mean NEES of the pose (dashed: expected)")):
            of_cells = [(cell, values_of(rows, group, cell, quantity)) for cell in cells]
            panel(axis, of_cells, colour, names=quantity == "error")
            values = [value for _, runs in of_cells for value, _ in runs]
            if quantity == "nees" and values:
                axis.axvline(6, color="black", linewidth=0.8, linestyle="--")
            if not values:
                axis.text(0.5, 0.5, "not judged", transform=axis.transAxes, ha="center")
            axis.locator_params(axis="x", nbins=6)
            study_axes.explain(axis, title=group["name"], xlabel=name, **scale_of(values))
    return figure, ("Distribution over the runs", "Each run's error and mean NEES over its frames: a point. Boxes, from three runs on: median and quartiles, whiskers at the 5% and 95% "
                    "quantiles. Diverged runs are left out. Of a batch, smoothed.")
