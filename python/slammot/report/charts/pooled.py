"""How the runs of each estimator of a comparison lie, as Plotly takes it."""
from ..figures import INK, NEES_DOF, axis, clean, layout, log_ticks


def box(estimator, runs, values, number):
    """An estimator's runs as a box of quartiles, with each as a point beside it; whiskers as far as 1.5 times the box."""
    known = [(run, value) for run, value in zip(runs, values) if value is not None]
    failed = [not run.competes for run, _ in known]
    return {"type": "box", "orientation": "h", "name": estimator.name, "x": [value for _, value in known], "y": [estimator.name] * len(known),
            "boxpoints": "all", "jitter": 0.6, "pointpos": 0, "fillcolor": "rgba(0,0,0,0)", "line": {"color": estimator.colour, "width": 1.5},
            "marker": {"color": estimator.colour, "size": 5, "opacity": 0.75}, "hoveron": "points", "hovertemplate": "%{text}: %{x:.4g}<extra></extra>",
            "text": [f"{' '.join(filter(None, (run.name, run.sequence)))}{', failed' if lost else ''}" for (run, _), lost in zip(known, failed)],
            "showlegend": False, "xaxis": f"x{number}", "yaxis": "y"}


def scale(values):
    """Of positive values over more than a factor of ten, logarithmic."""
    known = clean(values)
    return {"type": "log", **log_ticks(known)} if known and min(known) > 0 and max(known) > 10 * min(known) else {}


def distribution(comparison):
    """Errors and mean NEES of the pose of the single runs that did not diverge; None where no estimator has several."""
    if not any(estimator.runs > 1 for estimator in comparison.estimators) or not comparison.has_truth:
        return None
    metric = comparison.table[comparison.error_key]
    quantities = ((lambda run: run.value(comparison.error_key), f"{metric.name} [{metric.unit}]"),
                  (lambda run: run.metric(run.judged, "nees", "pose", "mean"), "mean NEES of the pose"))
    traces, axes = [], {}
    for i, (value, name) in enumerate(quantities):
        number = "" if i == 0 else str(i + 1)
        everything = []
        for estimator in comparison.estimators:
            runs = [run for run in comparison.runs if run.pooled == estimator.name and run.divergence is None]
            values = [value(run) for run in runs]
            everything += values
            traces.append(box(estimator, runs, values, number))
        axes[f"xaxis{number}"] = axis(name, domain=[0.54 * i, 0.54 * i + 0.46], anchor="y", **scale(everything))
    expected = {"type": "line", "xref": f"x{number}", "yref": "paper", "x0": NEES_DOF, "x1": NEES_DOF, "y0": 0, "y1": 1, "line": {"color": INK, "width": 1.2, "dash": "dash"}}
    return {"data": traces, "layout": layout(120 + 54 * len(comparison.estimators), shapes=[expected] if clean(everything) else [],
                                             yaxis=axis("", autorange="reversed", ticks=""), **axes)}
