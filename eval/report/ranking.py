"""The configurations of a study in an order: how far from the truth, and how sure of it, over all scenarios.

A run's error is so many times the Cramér-Rao bound's, its ANEES so many times its degrees of freedom, and the root of
that is by how much the stated sigma is wrong. A scenario costs the product of the two, a configuration the geometric
mean over scenarios: twice as far and twice as sure as it should be count alike, and no scenario outweighs another.
"""
import math
from dataclasses import dataclass

from study_tables import BOUND, Table, number, percent

POSE = 6  # degrees of freedom
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
                  mean([c.get("timing", {}).get("frame_median_ms", math.nan) for c in cells]))


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


def table(summary):
    rows = ranking(summary)
    best = recommended(rows).values()
    lines = [["recommended" if r in best else "told the truth" if r.told else "", r.label, r.kind, f"{r.diverged} + {r.lost} of {r.runs}",
              factor(r.cost), factor(r.far), factor(r.sure), percent(r.inside, 1), percent(r.misclassified, 1), factor(r.frame_ms)]
             for r in rows]
    return Table(
        "Ranking",
        f"{sentence(rows)} Fewest diverged runs first, then the smallest cost: position RMSE over the Cramér-Rao bound's, over the runs that did not diverge, "
        "times the factor by which the stated sigma is wrong, the root of ANEES / 6 or of its inverse; geometric means over the scenarios. Inside: frames whose pose "
        "ANEES is in its 95% interval. Misclassified: wrong or undecided, of landmarks measured ten times or more. What is told the truth is a yardstick.",
        ["", "configuration", "kind", "diverged + lost", "cost", "error over bound", "sigma off by", "inside", "misclassified", "frame [ms]"], lines)
