"""The configurations of a study in an order: how far from the truth, and how sure of it, over all scenarios.

A run's error is so many times the Cramér-Rao bound's, its ANEES so many times its degrees of freedom, and the root of
that is by how much the stated sigma is wrong. A scenario costs the product of the two, a configuration the geometric
mean over scenarios: twice as far and twice as sure as it should be count alike, and no scenario outweighs another.
"""
import math
from dataclasses import dataclass, field

import numpy
from study_tables import BOUND, Table, number, percent

POSE = 6  # degrees of freedom
DRAWINGS = 2000
FEWEST = 10  # runs from which an interval is given; a percentile bootstrap then holds 89% for its 95%
SMOOTHER, BATCH = "window", "batch"


def knows_the_truth(cell):
    """Told its labels or its Jacobians: a yardstick, not a recommendation."""
    settings = cell["configuration"]
    own = "window.linearisation" if cell["estimator"] == SMOOTHER else "ekf.linearisation"
    return cell["estimator"] in (BOUND, "true_labels") or settings["classifier"] == "truth" or settings[own] == "ideal"


def camera(cell):
    """Error over the bound's, and by how much the stated sigma is wrong; infinite where no run has a number."""
    far = cell.get("rmse_over_bound", {}).get("position")
    pose = cell.get("anees", {}).get("pose", {})
    mean_nees = pose.get("mean")
    if not far or not mean_nees or pose.get("infinite"):
        return math.inf, math.inf
    return far, math.sqrt(max(mean_nees / POSE, POSE / mean_nees))


@dataclass
class Ranked:
    label: str
    kind: str
    told: bool
    diverged: int
    lost: int
    runs: int
    far: float  # geometric means over the scenarios
    sure: float
    inside: float
    misclassified: float
    frame_ms: float
    cells: list = field(repr=False, compare=False)

    @property
    def cost(self):
        return self.far * self.sure


def mean(values):
    return sum(values) / len(values)


def geometric(values):
    return math.exp(mean([math.log(v) for v in values]))


def ranked(label, cells):
    """Of one configuration in every scenario."""
    measured = [camera(cell) for cell in cells]
    often = [cell.get(f"{kind}_often_seen", [0, 0, 0]) for cell in cells for kind in ("static", "moving")]
    seen = sum(map(sum, often))
    return Ranked(label, "smoother" if cells[0]["estimator"] == SMOOTHER else "filter",
                  knows_the_truth(cells[0]), sum(len(c["diverged"]) for c in cells), sum(len(c["lost"]) for c in cells),
                  sum(c["runs"] for c in cells),
                  geometric([far for far, _ in measured]),
                  geometric([sure for _, sure in measured]),
                  mean([c.get("anees", {}).get("pose", {}).get("inside") or 0.0 for c in cells]),
                  sum(wrong + undecided for _, wrong, undecided in often) / seen if seen else 0.0,
                  mean([c.get("timing", {}).get("frame_median_ms", math.nan) for c in cells]), cells)


def drawn_cost(cells, seeds, drawn):
    """The cost with the runs drawn again: `drawn` has a row of places in `seeds` for each drawing."""
    logarithm = numpy.zeros(len(drawn))
    for cell in cells:
        runs = {r["seed"]: (r["position_rmse_m"] ** 2, r["bound_m"] ** 2, r["nees_pose"]) for r in cell["rmse_over_bound"]["runs"]}
        error, bound, nees = numpy.array([runs[seed] for seed in seeds])[drawn].mean(axis=1).T
        logarithm += 0.5 * numpy.log(error / bound) + 0.5 * numpy.abs(numpy.log(nees / POSE))
    return numpy.exp(logarithm / len(cells))


def over(row, best):
    """The cost of one over that of another: 95% of the drawings of the seeds, the same for both. Nothing where a run
    diverged, which no cost contains, and with so few runs that such an interval would be far too narrow."""
    runs = [cell.get("rmse_over_bound", {}).get("runs", []) for cell in row.cells + best.cells]
    seeds = sorted({r["seed"] for of_cell in runs for r in of_cell})
    if row is best or len(seeds) < FEWEST or any(len(of_cell) < len(seeds) for of_cell in runs):
        return None
    drawn = numpy.random.default_rng(1).integers(len(seeds), size=(DRAWINGS, len(seeds)))
    ratio = drawn_cost(row.cells, seeds, drawn) / drawn_cost(best.cells, seeds, drawn)
    return numpy.quantile(ratio, [0.025, 0.975])


def swept_settings(group):
    """Those of the estimators; swept parameters of a scenario make scenarios."""
    return "".join(f", {key} = {value}" for key, value in group["sweep"].items() if not key.startswith("scenario."))


def configurations(summary):
    """label and swept settings to its cells, one for each scenario. A batch has none: the bound is a filter's."""
    found = {}
    for group in summary["groups"]:
        for cell in group["cells"]:
            if cell["estimator"] not in (BOUND, BATCH):
                found.setdefault(cell["label"] + swept_settings(group), []).append(cell)
    return found


def ranking(summary):
    """Best first. Empty without a bound in every group, or where there is nothing to choose from."""
    if not all(any(cell["estimator"] == BOUND for cell in group["cells"]) for group in summary["groups"]):
        return []
    rows = sorted((ranked(label, cells) for label, cells in configurations(summary).items()),
                  key=lambda r: (r.diverged / r.runs, r.cost))
    return rows if sum(not r.told for r in rows) > 1 else []


def recommended(rows):
    """kind to the best configuration of that kind that is told nothing."""
    best = {}
    for row in rows:
        if not row.told:
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
    rank = "recommended" if row is best else "told the truth" if row.told else ""
    return [rank, row.label, row.kind, f"{row.diverged} + {row.lost} of {row.runs}", factor(row.cost), interval(over(row, best) if best else None),
            factor(row.far), factor(row.sure), percent(row.inside, 1), percent(row.misclassified, 1), factor(row.frame_ms)]


def table(summary):
    rows = ranking(summary)
    best = recommended(rows)
    runs = summary.get("runs", 0)
    return Table(
        "Ranking",
        f"{sentence(rows)} Fewest diverged runs first, then the smallest cost: position RMSE over the Cramér-Rao bound's, over the runs that did not diverge, "
        "times the factor by which the stated sigma is wrong, the root of ANEES / 6 or of its inverse; geometric means over the scenarios. Over the "
        "recommended: the cost over that of the recommended of its kind, 95% of 2000 drawings of the seeds, from ten runs on and where none diverged; where 1 is "
        "inside, these runs do not tell the two apart, and the recommended is the luckiest of many. Inside: frames whose pose "
        f"ANEES is in its 95% interval for {runs} runs: not to be compared with other numbers of runs. Misclassified: wrong or undecided, of landmarks measured "
        "ten times or more. What is told the truth is a yardstick.",
        ["", "configuration", "kind", "diverged + lost", "cost", "over the recommended", "error over bound", "sigma off by", "inside", "misclassified", "frame [ms]"],
        [line(row, best.get(row.kind)) for row in rows])
