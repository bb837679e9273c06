"""The tables of the page: texts of cells, with the best of a column marked where there is a best."""
from dataclasses import dataclass

from . import metrics
from . import verdict
from .metrics import UNDEFINED
from ..judge.intervals import FEW
from .pooled_verdict import anees_class, is_tested


@dataclass
class Cell:
    text: str
    best: bool = False
    note: str = ""  # small, after the number


def shown(value, digits=3):
    """A number with so many significant digits, without exponent where it is legible without."""
    if value is None:
        return UNDEFINED
    if isinstance(value, int) or (abs(value) >= 10 ** digits and abs(value) < 1e6):
        return f"{value:.0f}"
    text = f"{value:#.{digits}g}" if value else "0"
    return text.rstrip(".")


def percent(ratio):
    return UNDEFINED if ratio is None else f"{100 * ratio:.0f}%"


# Of a trajectory, in their order where the truth is measured: what a single camera can be judged by comes first.
ALIGNED_FIRST = ("coverage", "ate_sim3_m", "sim3_scale", "ate_se3_m", "rpe_1s_position_rmse_m", "rpe_1s_rotation_rmse_deg")

def columns(comparison, of):
    # Where truth is exact an error at another scale tells nothing that the one beside it does not.
    shown_ones = [metric for metric in comparison.table.values()
                  if metric.of == of and metric.on_page and (comparison.aligned or metric.key != "rpe_1s_scaled_position_rmse_m")]
    if comparison.aligned:
        shown_ones.sort(key=lambda m: ALIGNED_FIRST.index(m.key) if m.key in ALIGNED_FIRST else len(ALIGNED_FIRST))
    defined = [m for m in shown_ones if any(run.value(m.key, which) is not None or is_infinite(run, m)
                                            for run in comparison.runs for which in ("filtered", "smoothed"))]
    return defined or (shown_ones if of == "trajectory" else [])


def frames(run):
    """How many frames the run has done, of how many where it ended before the last."""
    done, offered = (run.metric("coverage", name) for name in ("frames_done", "frames_offered"))
    return Cell(shown(done), note=f"of {offered}" if offered is not None and done != offered else "")


def expected(comparison, metric):
    """What a consistent run has: a number of the runs themselves, if it is the same for all."""
    values = {run.value(metric.expected) for run in comparison.runs} - {None} if metric.expected else set()
    return values.pop() if len(values) == 1 else None


def summary_head(comparison):
    """(name, unit or expected value, caption) of each column."""
    head = []
    for metric in columns(comparison, "trajectory") + columns(comparison, "run"):
        value = expected(comparison, metric)
        head.append((metric.name, metric.unit if value is None else f"{shown(value)} expected", metric.caption))
    return head + [("frames", "", "frames done")]


def is_infinite(run, metric):
    """A mean NEES, of which a covariance was not positive definite."""
    if not metric.key.startswith("nees.") or not metric.key.endswith(".mean") or run.value(metric.key) is not None:
        return False
    counter = metric.key.replace(".mean", ".covariances_not_positive_definite")
    return counter in run.table and bool(run.value(counter))


OTHERS = (("last_scale", "in the last scale"), ("smoothed", "smoothed"))


def summary(comparison):
    """A row per run: (run, cells, (name, cells) of its other trajectories, columns that these leave empty)."""
    of_trajectory, of_run = columns(comparison, "trajectory"), columns(comparison, "run")
    competing = [run for run in comparison.runs if run.competes]
    best = {m.key: metrics.best(m, [run.value(m.key) for run in competing], expected(comparison, m)) if metrics.is_ranked(m, comparison.aligned) else None
            for m in of_trajectory + of_run}
    apart = verdict.apart([run.metric(run.judged, "accuracy", "coverage") for run in competing])
    several = comparison.sequence.get("count", 1) > 1  # what is best of one is not of another
    rows = []
    for run in comparison.runs:
        cells = []
        for m in of_trajectory + of_run:
            value = run.value(m.key)
            wins = not several and run.competes and metrics.equal(value, best[m.key]) and not (apart and m.of == "trajectory")
            cells.append(Cell("∞" if is_infinite(run, m) else metrics.text(m, value), wins))
        others = [(name, [Cell(metrics.text(m, run.value(m.key, which))) for m in of_trajectory])
                  for which, name in OTHERS if run.metric(which) and run.judged != which]
        rows.append((run, cells + [frames(run)], others, len(of_run) + 1))
    return rows


def with_interval(estimate, digits=3):
    """value and, small, its interval over the runs."""
    if not estimate or estimate["value"] is None:
        return Cell(UNDEFINED)
    low, high = estimate["lower"], estimate["upper"]
    return Cell(shown(estimate["value"], digits), note="" if low is None else f"{shown(low, digits)} to {shown(high, digits)}")


def anees_cell(estimator, part):
    a = estimator.anees.get(part)
    if not a:
        return Cell(UNDEFINED), ""
    if a["infinite"] or a["mean"] is None:
        return Cell("∞"), ""
    return with_interval({"value": a["mean"], "lower": a["lower"], "upper": a["upper"]}), anees_class(a)


POOLED = ("ate_sim3_m", "sim3_scale", "position_rmse_m", "ate_se3_m", "rpe_1s_position_rmse_m", "rotation_rmse_deg")


def pooled_metrics(comparison):
    keys = POOLED if comparison.aligned else ("position_rmse_m", *(k for k in POOLED if k != "position_rmse_m"))
    return [comparison.table[key] for key in keys
            if key in comparison.table and any(key in e.values for e in comparison.estimators)]


ANEES = (("pose", 6), ("position", 3), ("rotation", 3))


def pooled_head(comparison):
    """(name, unit or expected value, caption) of each column; the error first, then consistency."""
    first, *others = [(m.name, m.unit, m.caption) for m in pooled_metrics(comparison)] or [("error", "", "")]
    return [("runs", "", ""), ("coverage", "", "poses judged, of the frames of the sequence"), ("failed", "", "runs"), ("diverged", "", "runs"), ("warned", "", "runs that warn or diverged"), first,
            *((f"ANEES {part}", f"{dof} expected", "NEES over runs and frames") for part, dof in ANEES), ("frames inside", "", ""), *others]


def pooled(comparison):
    """A row per estimator: (estimator, [(cell, class)])."""
    rows = []
    for e in comparison.estimators:
        coverage = e.values.get("coverage") or {"value": None}
        pose = e.anees.get("pose") or {"infinite": 0}
        inside = None if pose["infinite"] else pose.get("inside")
        cells = [(Cell(str(e.runs)), ""), (Cell(percent(coverage["value"])), ""),
                 (Cell(str(e.failed)), "over" if e.failed else ""), (Cell(str(e.diverged)), "over" if e.diverged else ""),
                 (Cell(shown(e.warned)), "")]
        first, *others = [(with_interval(e.values.get(m.key)), "") for m in pooled_metrics(comparison)] or [(Cell(UNDEFINED), "")]
        consistent = [anees_cell(e, part) for part, _ in ANEES]
        rows.append((e, [*cells, first, *consistent, (Cell(percent(inside)), ""), *others]))
    return rows


def probability(pair):
    """p of the paired t test, corrected."""
    return f"{pair['p_holm']:.2g}" if is_tested(pair) and "p_holm" in pair else UNDEFINED


def on_terminal(estimate, decimals):
    if not estimate or estimate["value"] is None:
        return "-"
    low, high = estimate["lower"], estimate["upper"]
    return f"{estimate['value']:.{decimals}f}" + ("" if low is None else f" [{low:.{decimals}f}, {high:.{decimals}f}]")


def terminal_row(e):
    coverage, pose = e.values.get("coverage"), e.anees.get("pose")
    anees = [on_terminal({"value": a["mean"], **a} if a else None, 3) for a in map(e.anees.get, ("pose", "position"))]
    return [e.name, str(e.runs), f"{100 * coverage['value']:.1f}%" if coverage else "-", str(e.failed), str(e.diverged), str(e.warned),
            on_terminal(e.values.get("position_rmse_m"), 4), on_terminal(e.values.get("ate_sim3_m"), 4), *anees,
            f"{100 * pose['inside']:.0f}%" if pose and not pose["infinite"] else "-"]


def terminal(comparison):
    """A row for each estimator, its runs put together, for the terminal."""
    rows = [["estimator", "runs", "coverage", "failed", "diverged", "warned", "position RMSE m", "ATE Sim(3) m", "ANEES pose (6)",
             "ANEES position (3)", "frames inside"], *map(terminal_row, comparison.estimators)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = ["  ".join(cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths))).rstrip() for row in rows]
    return "\n".join(lines) + (f"\nErrors: root mean square over the runs that did not diverge. In brackets: 95% interval over runs ({FEW} have no interval).\n"
                               "Frames inside: those whose NEES, averaged over the runs, lies in the 95% interval of a consistent estimator.")


def pairs(comparison):
    """(names, cells) of each pair of estimators with several runs on the same sequences: one says no more than the summary."""
    rows = []
    names = {run.label: run.name for run in comparison.runs}
    for pair in comparison.pairs:
        if pair["pairs"] > 1:
            rows.append((" − ".join(names.get(pair[which], pair[which]) for which in "ab"),
                         [Cell(str(pair["pairs"])), Cell(str(pair["wins_a"])), Cell(str(pair["wins_b"])),
                          Cell(str(pair["pairs"] - pair["wins_a"] - pair["wins_b"])), with_interval(pair["difference"]),
                          *([Cell(probability(pair))] if comparison.pooled else [])]))
    return rows


def labels(run):
    """(label, count) of the landmarks that had to be classified; none without classification.csv."""
    return [(name, run.labels.get(name, 0)) for name in ("static", "moving", "unknown")] if run.labels else []


def classification(run):
    """Two rows (truly static, truly moving) of (count, share of the row) per label, or None."""
    table = []
    for kind in ("static", "moving"):
        counts = run.metric("classification", kind) or {}
        right, wrong, undecided = (counts.get(name) or 0 for name in ("right", "wrong", "undecided"))
        row = (right, wrong, undecided) if kind == "static" else (wrong, right, undecided)
        total = sum(row)
        table.append((kind, [(n, n / total if total else 0.0) for n in row],
                      percent(counts.get("misclassified")) if total else UNDEFINED))
    return table if any(n for _, row, _ in table for n, _ in row) else None


def labelled(runs):
    return [run for run in runs if run.labels or classification(run)]


@dataclass
class Acting:
    """What became of a mechanism beyond the thesis in a run."""
    text: str
    because: str = ""


def acting(run, name):
    stated = run.metrics["in_force"]
    found = next((m for m in stated if m["name"] == name), None)
    if found is None:
        return Acting(UNDEFINED if stated else "states nothing")
    return Acting(f"on, {found['acted']}") if found["state"] == "on" else Acting("off", found["because"])


def in_force(runs):
    """(runs that state what is in force, rows of (name, key, an Acting for each)); runs made elsewhere state nothing."""
    stating = [run for run in runs if run.metrics.get("in_force") is not None]
    keys = {m["name"]: m["key"] for run in stating for m in run.metrics["in_force"]}
    return stating, [(name, key, [acting(run, name) for run in stating]) for name, key in keys.items()]


def configured(runs):
    """Not those made elsewhere, of which nothing is known."""
    return [run for run in runs if run.configuration]


def configuration(runs):
    """(keys all runs share, keys that differ): lists of (key, values); one value where shared."""
    keys = list(dict.fromkeys(key for run in runs for key in run.configuration))
    rows = [(key, [str(run.configuration.get(key, UNDEFINED)) for run in runs]) for key in keys]
    shared = [(key, values[0]) for key, values in rows if len(set(values)) == 1]
    return shared, [(key, values) for key, values in rows if len(set(values)) > 1]
