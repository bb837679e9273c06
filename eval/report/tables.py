"""The tables of the page: texts of cells, with the best of a column marked where there is a best."""
from dataclasses import dataclass

import metrics
from metrics import UNDEFINED


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


def columns(comparison, of):
    return [metric for metric in comparison.table.values() if metric.of == of and metric.on_page]


def frames(run):
    """How many frames the run has done, of how many where it ended before the last."""
    done, offered = (run.metric("coverage", name) for name in ("frames_done", "frames_offered"))
    return Cell(shown(done), note=f"of {offered}" if offered is not None and done != offered else "")


def expected(comparison, metric):
    """What a consistent run has: a number of the runs themselves."""
    values = [run.value(metric.expected) for run in comparison.runs] if metric.expected else []
    return next((value for value in values if value is not None), None)


def summary_head(comparison):
    """(name, unit or expected value, caption) of each column."""
    head = []
    for metric in columns(comparison, "trajectory") + columns(comparison, "run"):
        value = expected(comparison, metric)
        head.append((metric.name, metric.unit if value is None else f"{shown(value)} expected", metric.caption))
    return head + [("frames", "", "frames done")]


def summary(comparison):
    """A row per run: (run, cells, cells of the smoothed trajectory or None, columns that it leaves empty)."""
    of_trajectory, of_run = columns(comparison, "trajectory"), columns(comparison, "run")
    competing = [run for run in comparison.runs if run.divergence is None]
    best = {m.key: metrics.best(m, [run.value(m.key) for run in competing], expected(comparison, m))
            for m in of_trajectory + of_run}
    rows = []
    for run in comparison.runs:
        cells = []
        for m in of_trajectory + of_run:
            value = run.value(m.key)
            wins = run.divergence is None and value is not None and value == best[m.key]
            cells.append(Cell(metrics.text(m, value), wins))
        smoothed = None
        if run.metric("smoothed"):
            smoothed = [Cell(metrics.text(m, run.value(m.key, "smoothed"))) for m in of_trajectory]
        rows.append((run, cells + [frames(run)], smoothed, len(of_run) + 1))
    return rows


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


def configuration(runs):
    """(keys all runs share, keys that differ): lists of (key, values); one value where shared."""
    keys = list(dict.fromkeys(key for run in runs for key in run.configuration))
    rows = [(key, [str(run.configuration.get(key, UNDEFINED)) for run in runs]) for key in keys]
    shared = [(key, values[0]) for key, values in rows if len(set(values)) == 1]
    return shared, [(key, values) for key, values in rows if len(set(values)) > 1]
