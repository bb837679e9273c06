"""Errors of single runs as Plotly takes them: of each axis against what is stated, and along the path."""
from .. import figures
from ..figures import axis, clean, layout, line, seconds, sound, start_of
from .failures import failures

AXES = ("x", "y", "z")
MOST_PATHS = 8  # panels


# --- of each axis ------------------------------------------------------------------------------------

def errors_by_axis(run, truth):
    """True less estimated position at each pose, [x, y, z]; None where no truth is of its time."""
    found = []
    for t, position in zip(run.series.get("timestamp", []), run.series.get("position", [])):
        true = truth.get(round(t, 6))
        found.append(None if true is None else [a - b for a, b in zip(true, position)])
    return found


def of_truth(comparison):
    """Positions by their time."""
    return {round(t, 6): p for t, p in zip(comparison.truth.get("timestamp", []), comparison.truth.get("position", []))}


def drawn_runs(comparison):
    """Those drawn one by one, as far as they are of the sequence whose truth is known here."""
    return [run for run in figures.representatives(comparison) if run.truth_is_here]


def both_sides(name, times, sigma, colour, **more):
    """Three standard deviations above and below zero, as one line."""
    above = [None if s is None else 3 * s for s in sigma]
    below = [None if s is None else -3 * s for s in sigma]
    return line(name, [*times, None, *times], [*above, None, *below], colour, dash="dot", width=1.3, showlegend=False, hoverinfo="skip", **more)


def limit(errors, bounds):
    """As far as the errors go, and the bounds unless they are much wider."""
    largest = max(map(abs, errors), default=0.0)
    return 1.08 * max(largest, min(max(bounds, default=0.0), 2.5 * largest)) or 1.0


def axis_traces(run, errors, k, times, place):
    """The error of one axis, with what the run states of it."""
    traces = [line(run.name, times, [e and e[k] for e in errors], run.colour, legendgroup=run.label, showlegend=k == 0, width=1.5, **place)]
    sigma = run.axis_sigma(k)
    return traces + ([both_sides(f"{run.name}: 3σ", times, sigma, run.colour, legendgroup=run.label, **place)] if clean(sigma) else [])


def rotation_traces(run, times, place):
    traces = [line(run.name, times, run.series.get("rotation_error_deg", []), run.colour, legendgroup=run.label, showlegend=False, width=1.5, **place)]
    stated = [None if s is None else 3 * s for s in run.rotation_sigma_deg()]
    if clean(stated):
        traces.append(line(f"{run.name}: 3σ", times, stated, run.colour, dash="dot", width=1.3, legendgroup=run.label, showlegend=False,
                           hoverinfo="skip", **place))
    return traces


def axis_scale(shown, k):
    """Limits of the panel of an axis, about zero, by the runs that did not fail."""
    good = [(run, errors) for run, errors in shown if run in sound([run for run, _ in shown])]
    top = limit([e[k] for _, errors in good for e in clean(errors)], [3 * s for run, _ in good for s in clean(run.axis_sigma(k))])
    return [-top, top]


def rotation_scale(shown):
    good = sound([run for run, _ in shown])
    top = limit([e for run in good for e in clean(run.series.get("rotation_error_deg", []))], [3 * s for run in good for s in clean(run.rotation_sigma_deg())])
    return [0.0, top]


def axis_errors(comparison):
    """Four panels under each other: x, y, z and the rotation; None without truth."""
    truth, start = of_truth(comparison), start_of(comparison)
    shown = [(run, errors_by_axis(run, truth)) for run in drawn_runs(comparison)]
    shown = [(run, errors) for run, errors in shown if any(errors)]
    if not shown:
        return None
    traces, axes = [], {}
    for k in range(4):
        number = "" if k == 0 else str(k + 1)
        place = {"xaxis": "x", "yaxis": f"y{number}"}
        for run, errors in shown:
            times = seconds(run.series, start)
            traces += axis_traces(run, errors, k, times, place) if k < 3 else rotation_traces(run, times, place)
        domain = [0.26 * (3 - k), 0.26 * (3 - k) + 0.22]
        axes[f"yaxis{number}"] = axis(f"{AXES[k]} [m]" if k < 3 else "rotation [deg]", domain=domain,
                                      range=axis_scale(shown, k) if k < 3 else rotation_scale(shown), **({"zeroline": True, "zerolinecolor": "#9aa1aa"} if k < 3 else {}))
    return {"data": traces, "layout": layout(760, xaxis=axis("time [s]", anchor="y4"), **axes, **failures([run for run, _ in shown], start))}


# --- along the path ----------------------------------------------------------------------------------

def path_limits(comparison, runs):
    """Of x and z, for all panels the same."""
    framed = comparison.truth.get("position", []) + [p for run in sound(runs) for p in run.series["position"]]
    return figures.around(framed, 0, 2), figures.around(framed, 2, 0)


def panel(number, count):
    """Domains of a panel, two in a row; from the top."""
    rows = (count + 1) // 2
    height = 1.0 / rows
    top = 1.0 - (number // 2) * height
    return [0.54 * (number % 2), 0.54 * (number % 2) + 0.42], [top - height * 0.78, top - height * 0.07]


def error_path(comparison):
    """The path of each run from above, coloured by its position error, with one scale of colours; None without truth."""
    runs = [run for run in drawn_runs(comparison) if clean(run.series.get("position_error_m", []))][:MOST_PATHS]
    if not runs or not comparison.has_truth:
        return None
    top = max((e for run in sound(runs) for e in clean(run.series["position_error_m"])), default=1.0) or 1.0
    across, along = path_limits(comparison, runs)
    truth = comparison.truth["position"]
    traces, axes, titles = [], {}, []
    for i, run in enumerate(runs):
        number = "" if i == 0 else str(i + 1)
        place = {"xaxis": f"x{number}", "yaxis": f"y{number}", "showlegend": False}
        traces.append(figures.path_above("truth", truth, figures.MUTED, width=1.2, hoverinfo="skip", **place))
        known = [(p, e) for p, e in zip(run.series["position"], run.series["position_error_m"]) if e is not None]
        traces.append({"type": "scatter", "mode": "markers", "name": run.name, "x": [p[0] for p, _ in known], "y": [p[2] for p, _ in known],
                       "marker": {"color": [e for _, e in known], "coloraxis": "coloraxis", "size": 5},
                       "text": [f"{e:.3g} m" for _, e in known], "hoverinfo": "text+name", **place})
        x, y = panel(i, len(runs))
        axes[f"xaxis{number}"] = axis("x [m]", domain=x, anchor=f"y{number}", range=across, constrain="domain")
        axes[f"yaxis{number}"] = axis("z [m]", domain=y, anchor=f"x{number}", range=along, scaleanchor=f"x{number}", constrain="domain")
        titles.append({"text": run.name, "x": x[0], "y": y[1], "xref": "paper", "yref": "paper", "xanchor": "left", "yanchor": "bottom",
                       "showarrow": False, "font": {"color": run.colour}})
    scale = {"colorscale": "Cividis", "reversescale": True, "cmin": 0.0, "cmax": top, "colorbar": {"title": {"text": "error [m]", "side": "right"}, "thickness": 14, "len": 0.8, "y": 0, "yanchor": "bottom"}}
    return {"data": traces, "layout": layout(60 + 360 * ((len(runs) + 1) // 2), annotations=titles, coloraxis=scale, **axes)}
