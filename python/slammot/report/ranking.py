"""The configurations of a study ranked by accuracy and consistency over all scenarios.

Error ratio: position RMSE over the ideal sigma. Sigma ratio: the square root of ANEES over its degrees of freedom,
or its inverse where that is larger than 1: by what factor the stated standard deviation is wrong. The cost in a scenario
is the product of the two, that of a configuration the geometric mean over the scenarios. A factor of two in the error and
one in the stated standard deviation therefore cost the same, and no scenario outweighs another.
"""
import math
from dataclasses import dataclass, field

import numpy
from ..judge.intervals import FEWEST, jackknife
from .study_tables import Table, is_ideal, number, percent

POSE = 6  # degrees of freedom
RANKED = ("filter", "smoother")  # a batch is not: the ideal covariance is a filter's


def ratios(cell):
    """Error ratio and sigma ratio; infinite where no run has a number."""
    error = cell.get("rmse_over_ideal", {}).get("position")
    pose = cell.get("anees", {}).get("pose", {})
    mean_nees = pose.get("mean")
    if not error or not mean_nees or pose.get("infinite"):
        return math.inf, math.inf
    return error, math.sqrt(max(mean_nees / POSE, POSE / mean_nees))


@dataclass
class Ranked:
    label: str
    kind: str
    oracle: bool
    diverged: int
    failed: int
    runs: int
    error_ratio: float  # geometric means over the scenarios
    sigma_ratio: float
    interval_coverage: float
    misclassified: float
    frame_ms: float
    cells: list = field(repr=False, compare=False)

    @property
    def cost(self):
        return self.error_ratio * self.sigma_ratio


def mean(values):
    return sum(values) / len(values)


def geometric(values):
    return math.exp(mean([math.log(v) for v in values]))


def ranked(label, cells):
    """Of one configuration in every scenario."""
    measured = [ratios(cell) for cell in cells]
    counts = [cell.get(f"{kind}_often_seen", [0, 0, 0]) for cell in cells for kind in ("static", "moving")]
    landmarks = sum(map(sum, counts))
    return Ranked(label, cells[0]["kind"], cells[0]["oracle"], sum(len(c["diverged"]) for c in cells), sum(len(c["lost"]) for c in cells),
                  sum(c["runs"] for c in cells),
                  geometric([error for error, _ in measured]),
                  geometric([sigma for _, sigma in measured]),
                  mean([c.get("anees", {}).get("pose", {}).get("inside") or 0.0 for c in cells]),
                  sum(wrong + undecided for _, wrong, undecided in counts) / landmarks if landmarks else 0.0,
                  mean([c.get("timing", {}).get("frame_median_ms", math.nan) for c in cells]), cells)


def log_costs(cells, seeds):
    """Logarithm of the cost: of all runs first, then without each of them."""
    logarithm = numpy.zeros(1 + len(seeds))
    for cell in cells:
        runs = {r["seed"]: (r["position_rmse_m"] ** 2, r["ideal_sigma_m"] ** 2, r["nees_pose"]) for r in cell["rmse_over_ideal"]["runs"]}
        table = numpy.array([runs[seed] for seed in seeds])
        without = (table.sum(axis=0) - table) / (len(seeds) - 1)
        error, ideal, nees = numpy.vstack([table.mean(axis=0), without]).T
        logarithm += 0.5 * numpy.log(error / ideal) + 0.5 * numpy.abs(numpy.log(nees / POSE))
    return logarithm / len(cells)


def cost_ratio(row, best):
    """95% jackknife interval of the cost of one over that of another, over the seeds, which are the same for both. None where
    a run diverged, which the cost does not contain, or with too few runs for an interval."""
    runs = [cell.get("rmse_over_ideal", {}).get("runs", []) for cell in row.cells + best.cells]
    seeds = sorted({r["seed"] for of_cell in runs for r in of_cell})
    infinite = any(r["nees_pose"] is None for of_cell in runs for r in of_cell)
    if row is best or infinite or len(seeds) < FEWEST or any(len(of_cell) < len(seeds) for of_cell in runs):
        return None
    whole, *without = log_costs(row.cells, seeds) - log_costs(best.cells, seeds)
    ratio = jackknife(without, whole)
    return math.exp(ratio.lower), math.exp(ratio.upper)


def swept_settings(group):
    """Those of the estimators; swept parameters of a scenario make scenarios."""
    return "".join(f", {key} = {value}" for key, value in group["sweep"].items() if not key.startswith("scenario."))


def is_ranked(group):
    """Whether an ideal covariance ran: with a measured truth there is none."""
    return any(is_ideal(cell) and "per_frame" in cell for cell in group["cells"])


def configurations(summary):
    """label and swept settings to its cells, one for each scenario."""
    found = {}
    for group in summary["groups"]:
        if not is_ranked(group):
            continue
        for cell in group["cells"]:
            if cell["kind"] in RANKED:
                found.setdefault(cell["label"] + swept_settings(group), []).append(cell)
    return found


def ranking(summary):
    """Best first. Empty without an ideal covariance, or where there is nothing to choose from."""
    rows = sorted((ranked(label, cells) for label, cells in configurations(summary).items()),
                  key=lambda r: (r.diverged / r.runs, r.cost))
    return rows if sum(not r.oracle for r in rows) > 1 else []


def recommended(rows):
    """kind to the best configuration of that kind that is no oracle."""
    best = {}
    for row in rows:
        if not row.oracle and math.isfinite(row.cost) and row.diverged + row.failed < row.runs:
            best.setdefault(row.kind, row)
    return best


def sentence(rows):
    named = [f"{kind}: {row.label}" for kind, row in recommended(rows).items()]
    return "Recommended " + "; ".join(named) + "." if named else ""


def factor(value):
    return "–" if math.isnan(value) else "∞" if math.isinf(value) else number(value)


def interval(limits):
    return "–" if limits is None else f"{number(limits[0])} to {number(limits[1])}"


def line(row, best):
    rank = "recommended" if row is best else "oracle" if row.oracle else ""
    return [rank, row.label, row.kind, f"{row.diverged} + {row.failed} of {row.runs}", factor(row.cost), interval(cost_ratio(row, best) if best else None),
            factor(row.error_ratio), factor(row.sigma_ratio), percent(row.interval_coverage, 1), percent(row.misclassified, 1), factor(row.frame_ms)]


def table(summary):
    rows = ranking(summary)
    best = recommended(rows)
    runs = summary.get("runs", 0)
    left_out = [group["name"] for group in summary["groups"] if not is_ranked(group)]
    return Table(
        "Ranking",
        f"{sentence(rows)} Ordered by the share of diverged runs, then by cost. Cost: error ratio times sigma ratio, geometric mean over the scenarios. "
        "Error ratio: position RMSE over the ideal sigma, over the runs that did not diverge. Sigma ratio: √(ANEES/6) or its inverse, whichever "
        "is larger than 1. Cost ratio: to the recommended configuration of the same kind, 95% jackknife interval over the seeds, for at least "
        "five runs of which none diverged. An interval that contains 1 does not separate the two. The recommended configuration was chosen "
        "after the fact among all of a kind, so its own cost is biased low. Interval coverage: frames whose pose ANEES lies in its 95% interval for "
        f"{runs} runs; it depends on the number of runs. Misclassified: wrong or undecided, of the landmarks observed at least ten times. An oracle is given "
        "part of the ground truth and is for reference only." + (f" Left out, without an ideal covariance: {', '.join(left_out)}." if left_out else ""),
        ["", "configuration", "kind", "diverged + failed", "cost", "cost ratio, 95% interval", "error ratio", "sigma ratio", "interval coverage", "misclassified", "time per frame [ms]"],
        [line(row, best.get(row.kind)) for row in rows])
