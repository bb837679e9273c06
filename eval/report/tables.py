"""The tables of the page: texts of cells, with the best of a column marked where there is a best."""
from dataclasses import dataclass

UNDEFINED = "–"


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


def right_ratio(run, kind):
    counts = run.metric("classification", kind) or {}
    total = sum(counts.get(name) or 0 for name in ("right", "wrong", "undecided"))
    return counts["right"] / total if total else None


def trajectory_columns(run, which):
    get = lambda *path: run.metric(which, *path)
    inside = get("nees", "pose", "fraction_inside")
    return [
        (get("accuracy", "position_rmse_m"), shown, ""),
        (get("accuracy", "position_final_m"), shown, ""),
        (get("accuracy", "rotation_rmse_deg"), shown, ""),
        (get("nees", "pose", "mean"), shown, "" if inside is None else f"{percent(inside)} inside"),
        (get("nees", "position", "mean"), shown, ""),
    ]


def run_columns(run):
    p95 = run.metric("runtime", "frame_p95_ms")
    done, offered = (run.metric("coverage", name) for name in ("frames_done", "frames_offered"))
    of = f"of {offered}" if offered is not None and done != offered else ""
    return [
        (run.metric("nis", "mean"), shown, ""),
        (right_ratio(run, "static"), percent, ""),
        (right_ratio(run, "moving"), percent, ""),
        (run.metric("runtime", "frame_median_ms"), shown, "" if p95 is None else f"p95 {shown(p95)}"),
        (run.metric("runtime", "state_size_median"), shown, ""),
        (done, shown, of),
    ]


# name, unit or expectation, and how the best of the column is found among the runs that finished.
SUMMARY_HEAD = [
    ("position RMSE", "m", min), ("final error", "m", min), ("rotation RMSE", "deg", min),
    ("pose NEES", "6 expected", lambda values: min(values, key=lambda v: abs(v - 6.0))),
    ("position NEES", "3 expected", lambda values: min(values, key=lambda v: abs(v - 3.0))),
    ("NIS", "", None), ("static right", "", max), ("moving right", "", max),
    ("time a frame", "ms", min), ("state size", "", None), ("frames", "", None),
]


def summary_head(comparison):
    head = [[name, unit] for name, unit, _ in SUMMARY_HEAD]
    for run in comparison.runs:
        expected = run.metric("nis", "expected_mean")
        if expected is not None:
            head[5][1] = f"{shown(expected)} expected"
    return head


def summary(comparison):
    """A row per run: (run, cells, smoothed cells or None)."""
    columns = [trajectory_columns(run, "filtered") + run_columns(run) for run in comparison.runs]
    competing = [row for run, row in zip(comparison.runs, columns) if run.divergence is None]
    best = []
    for i, (_, _, pick) in enumerate(SUMMARY_HEAD):
        values = [row[i][0] for row in competing if row[i][0] is not None]
        best.append(pick(values) if pick and len(set(values)) > 1 else None)
    rows = []
    for run, row in zip(comparison.runs, columns):
        cells = [Cell(form(value), run.divergence is None and value is not None and value == best[i],
                      note) for i, (value, form, note) in enumerate(row)]
        smoothed = None
        if run.metric("smoothed"):
            smoothed = [Cell(form(value), note=note)
                        for value, form, note in trajectory_columns(run, "smoothed")]
        rows.append((run, cells, smoothed))
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
