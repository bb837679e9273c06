"""The figures of the page as Plotly takes them: {"data": traces, "layout": layout}.

A run keeps its colour through all figures. A value that is not defined is None, which leaves a gap.
"""
import math

from . import lags
from .charts.failures import failures
from .verdict import milliseconds

NEES_DOF = 6
NEES_INTERVAL = (1.237, 14.449)  # 95% of chi-square(6), two-sided
INK, MUTED, GRID = "#1b1f24", "#6b7280", "#e7e9ec"
BAND = "rgba(0, 0, 0, 0.07)"

# Stages of a frame, lighter than the runs' colours so that nobody takes one for a run (Tol, "light").
STAGE_COLOURS = ("#77AADD", "#EE8866", "#EEDD88", "#44BB99", "#FFAABB", "#99DDFF", "#BBCC33",
                 "#AAAA00", "#DDDDDD")

SYMBOLS = {"static": "circle", "moving": "diamond", "unknown": "circle-open"}


def axis(title, **more):
    return {"title": {"text": title, "standoff": 8}, "gridcolor": GRID, "zeroline": False,
            "linecolor": "#9aa1aa", "ticks": "outside", "tickcolor": "#9aa1aa", "automargin": True,
            **more}


def layout(height, **more):
    return {"height": height, "margin": {"l": 56, "r": 40, "t": 12, "b": 48},
            "paper_bgcolor": "rgba(0,0,0,0)", "plot_bgcolor": "#ffffff",
            "font": {"family": "system-ui, 'DejaVu Sans', sans-serif", "size": 13, "color": INK},
            "modebar": {"orientation": "v", "bgcolor": "rgba(0,0,0,0)", "color": "#b3b9c1"},
            "legend": {"orientation": "h", "yanchor": "bottom", "y": 1.02, "x": 0,
                       "traceorder": "normal"},
            "hovermode": "closest", **more}


def line(name, x, y, colour, **more):
    style = {"color": colour, "width": more.pop("width", 1.8), "dash": more.pop("dash", "solid")}
    return {"type": "scatter", "mode": "lines", "name": name, "x": x, "y": y, "line": style, **more}


def seconds(series, start):
    return [t - start for t in series.get("timestamp", [])]


def start_of(comparison):
    times = [run.series["timestamp"][0] for run in comparison.runs if run.series.get("timestamp")]
    return min(times, default=0.0)


def sound(runs):
    """The runs that may set a figure's scale: one that diverged or failed would hide all others."""
    finished = [run for run in runs if run.divergence is None]
    return [run for run in finished if run.failed_at is None] or finished or runs


def clean(values):
    return [v for v in values if v is not None]


# --- from above ------------------------------------------------------------------------------------

def path_above(name, positions, colour, **more):
    return line(name, [p[0] for p in positions], [p[2] for p in positions], colour, **more)


def points_above(name, points, kinds, colour, **more):
    marker = {"symbol": [SYMBOLS[kind] for kind in kinds], "color": colour, "size": 7, "opacity": 0.7}
    return {"type": "scatter", "mode": "markers", "name": name, "marker": marker,
            "x": [p[0] for p in points], "y": [p[2] for p in points], **more}


def true_points(truth):
    entries = sorted(truth["landmarks"], key=lambda entry: list(SYMBOLS).index(entry["class"]))
    return points_above("true points", [e["last"] for e in entries], [e["class"] for e in entries],
                        "#a8aeb6", text=[f"track {e['track']}, {e['class']}" for e in entries],
                        legendrank=2000)


def final_points(run, **more):
    # In the order of the symbols, so that the legend shows a filled one.
    ordered = sorted(run.landmarks, key=lambda mark: list(SYMBOLS).index(mark[1]))
    tracks, labels, *position = zip(*ordered)
    return points_above(f"points of {run.name}", list(zip(*position)), labels, run.colour,
                        text=[f"track {t}, {label}" for t, label in zip(tracks, labels)],
                        legendrank=2001, **more)


def representatives(comparison):
    """The runs that are drawn one by one: all, or the first of each estimator that has several."""
    if not comparison.pooled:
        return comparison.runs
    return list({run.colour: run for run in reversed(comparison.runs)}.values())[::-1]


def around(path, axis_of, other):
    """Limits that frame the path, with as much room about it as shows what is near."""
    low, high = min(p[axis_of] for p in path), max(p[axis_of] for p in path)
    width = max(high - low, max(p[other] for p in path) - min(p[other] for p in path)) or 1.0
    return [low - 0.3 * width, high + 0.3 * width]


def trajectory(comparison):
    truth = comparison.truth.get("position", [])
    runs = representatives(comparison)
    traces = [true_points(comparison.truth)] if comparison.truth.get("landmarks") else []
    mapped = [run for run in runs if run.landmarks]
    traces += [final_points(run, visible=True if run is mapped[0] else "legendonly")
               for run in mapped]
    if truth:
        traces.append(path_above("truth", truth, "#000000", width=3.2))
    for run in runs:
        traces.append(path_above(run.name, run.series.get("position", []), run.colour))
        traces += [path_above(f"{run.name}, {name}", series["position"], run.colour, dash=dash, visible="legendonly")
                   for name, series, dash in run.others if series.get("position")]
    framed = truth + [p for run in sound(runs) for p in run.series.get("position", [])]
    if not framed:
        return None
    return {"data": traces, "layout": layout(
        640, legend={"x": 1.01, "y": 0.95, "xanchor": "left", "font": {"size": 12}},
        margin={"l": 56, "r": 8, "t": 12, "b": 48},
        modebar={"orientation": "h", "bgcolor": "rgba(0,0,0,0)", "color": "#b3b9c1"},
        xaxis=axis("x [m]", range=around(framed, 0, 2), constrain="domain"),
        yaxis=axis("z [m]", range=around(framed, 2, 0), scaleanchor="x", constrain="domain"))}


# --- against time ----------------------------------------------------------------------------------

def two_sigma(run):
    return [None if s is None else 2.0 * s for s in run.position_sigma()]


def error_ceiling(comparison):
    runs = sound(comparison.runs)
    errors = [e for run in runs for e in clean(run.series.get("position_error_m", []))]
    bounds = [b for run in runs for b in clean(two_sigma(run))]
    return 1.08 * max(max(errors), min(max(bounds, default=0.0), 1.5 * max(errors))) or 1.0


def pooled_series(comparison):
    """(estimator, seconds, its series over the frames) of the estimators that have any."""
    start = start_of(comparison)
    return [(e, seconds(e.per_frame, start), e.per_frame) for e in comparison.estimators if e.per_frame.get("timestamp")]


def pooled_error(comparison):
    """Root mean square over the runs, with the stated standard deviation, of which it is an estimate."""
    traces = []
    for e, times, f in pooled_series(comparison):
        traces.append(line(e.name, times, f["position_rmse_m"], e.colour, legendgroup=e.name))
        stated = f["position_sigma_m"]
        if clean(stated):
            traces.append(line(f"{e.name}: σ", times, stated, e.colour, dash="dot", width=1.3, legendgroup=e.name,
                               showlegend=False))
    if not traces:
        return None
    # A failed estimator must not hide the others; its line leaves the figure.
    good = [e for e in comparison.estimators if not e.failed and not e.diverged] or comparison.estimators
    top = max((v for e in good for v in clean(e.per_frame.get("position_rmse_m", []))), default=1.0)
    return {"data": traces, "layout": layout(
        380, xaxis=axis("time [s]"), yaxis=axis("RMS position error [m]", range=[0.0, 1.5 * top or 1.0]))}


def pooled_nees(comparison):
    """ANEES of each frame, and the interval of the largest number of runs."""
    shown = [(e, times, f) for e, times, f in pooled_series(comparison) if clean(f.get("anees_pose", []))]
    if not shown:
        return None
    most, times, f = max(shown, key=lambda entry: entry[0].runs)
    traces = [
        line("lower", times, f["anees_pose_lower"], MUTED, width=0, showlegend=False, hoverinfo="skip"),
        line(f"95% interval of a consistent estimator, {most.runs} runs", times, f["anees_pose_upper"], MUTED, width=0,
             fill="tonexty", fillcolor=BAND, hoverinfo="skip"),
        line(f"expected: {NEES_DOF}", [times[0], times[-1]], [NEES_DOF, NEES_DOF], INK, dash="dash", width=1.2)]
    traces += [line(e.name, t, s["anees_pose"], e.colour, width=1.4) for e, t, s in shown]
    values = [v for _, _, s in shown for v in clean(s["anees_pose"])]
    return {"data": traces, "layout": layout(
        380, xaxis=axis("time [s]"), yaxis=axis("ANEES of the pose", type="log", **log_ticks(values)))}


def position_error(comparison):
    if comparison.pooled:
        return pooled_error(comparison)
    start = start_of(comparison)
    traces = []
    for run in comparison.runs:
        errors = run.series.get("position_error_m", [])
        if not clean(errors):
            continue
        times = seconds(run.series, start)
        traces.append(line(run.name, times, errors, run.colour, legendgroup=run.label))
        if clean(two_sigma(run)):
            traces.append(line(f"{run.name}: 2σ", times, two_sigma(run), run.colour, dash="dot",
                               width=1.3, legendgroup=run.label, showlegend=False))
        traces += [line(f"{run.name}, {name}", seconds(series, start), series["position_error_m"], run.colour, dash=dash, visible="legendonly")
                   for name, series, dash in run.others if clean(series.get("position_error_m", []))]
    if not traces:
        return None
    return {"data": traces, "layout": layout(
        380, xaxis=axis("time [s]"),
        yaxis=axis("position error [m]", range=[0.0, error_ceiling(comparison)]), **failures(comparison.runs, start))}


def log_ticks(values):
    """Plain numbers: 1, 2 and 5 of every decade where there are few, 1 of more; of very many, every n-th as a power of ten."""
    values = [v for v in values if v > 0.0]
    low, high = (math.floor(math.log10(f(values, default=1.0))) for f in (min, max))
    ticks = [step * 10.0 ** decade for decade in range(low, high + 2, (high - low) // 8 + 1) for step in ((1, 2, 5) if high - low <= 3 else (1,))]
    return {"tickvals": ticks, "ticktext": [tick_text(tick) for tick in ticks]}


def tick_text(value):
    return f"{value:,.10g}" if 1e-4 <= value < 1e7 else f"10<sup>{math.log10(value):.0f}</sup>"


def nees(comparison):
    if comparison.pooled:
        return pooled_nees(comparison)
    start = start_of(comparison)
    shown = [run for run in comparison.runs if clean(run.series.get("nees_pose", []))]
    if not shown:
        return None
    last = max(seconds(run.series, start)[-1] for run in shown)
    ends, (low, high) = [0.0, last], NEES_INTERVAL
    traces = [
        line("lower", ends, [low, low], MUTED, width=0, showlegend=False, hoverinfo="skip"),
        line("95% interval of a consistent estimator", ends, [high, high], MUTED, width=0,
             fill="tonexty", fillcolor=BAND, hoverinfo="skip"),
        line(f"expected: {NEES_DOF}", ends, [NEES_DOF, NEES_DOF], INK, dash="dash", width=1.2)]
    traces += [line(run.name, seconds(run.series, start), run.series["nees_pose"], run.colour, width=1.4)
               for run in shown]
    return {"data": traces, "layout": layout(
        380, xaxis=axis("time [s]"), yaxis=axis("NEES of the pose", type="log",
                                        **log_ticks([v for run in shown for v in clean(run.series["nees_pose"])])), **failures(shown, start))}


# --- against lag -----------------------------------------------------------------------------------

def lag_trace(name, line, colour, **more):
    bars = {}
    if None not in line.values("lower"):
        bars = {"error_y": {"type": "data", "symmetric": False, "thickness": 1.2, "width": 3,
                            "array": [e["upper"] - e["value"] for e in line.estimates],
                            "arrayminus": [e["value"] - e["lower"] for e in line.estimates]}}
    return {"type": "scatter", "mode": "lines+markers", "name": name, "x": lags.places(line.lags), "y": line.values(),
            "text": [f"lag {lag}" for lag in line.lags], "hovertemplate": "%{text}: %{y:.3f}", "line": {"color": colour, "width": 1.8},
            "legendgroup": name, **bars, **more}


def lag(comparison):
    """Errors and NEES over those as filtered, side by side, of the estimators that keep past poses; None where there are none."""
    names = {run.label: run.name for run in comparison.runs}
    found = [(names.get(e.name, e.name), e.colour, lags.estimator_lines(comparison, e)) for e in comparison.estimators]
    known = sorted({lag for *_, lines in found for quantity, _ in lags.RATIOS if quantity in lines for lag in lines[quantity].lags})
    if not known:
        return None
    traces, axes = [], {}
    ticks = {"type": "log", "tickvals": lags.places(known), "ticktext": [str(lag) for lag in known]}
    for panel, (quantity, title) in enumerate(lags.RATIOS):
        number = "" if panel == 0 else str(panel + 1)
        place = {"xaxis": f"x{number}", "yaxis": f"y{number}"}
        ends = lags.places([known[0], known[-1]])
        traces.append(line("as filtered", ends, [1, 1], INK, dash="dash", width=1.2, showlegend=not panel, legendgroup="filtered", **place))
        traces += [lag_trace(name, lines[quantity], colour, showlegend=not panel, **place) for name, colour, lines in found if quantity in lines]
        # Names below: beside the axes they would lie upon the next panel of a narrow page.
        axes[f"xaxis{number}"] = axis(f"lag [frames]<br>{title}", domain=[0.36 * panel, 0.36 * panel + 0.28], anchor=f"y{number}", **ticks)
        axes[f"yaxis{number}"] = axis("" if panel else "value over filtered", anchor=f"x{number}")
    return {"data": traces, "layout": layout(380, **axes)}


# --- cost ------------------------------------------------------------------------------------------

def stages_of(run):
    return {s["stage"]: s.get("median_ms") or 0.0
            for s in run.metric("runtime", "stages") or [] if s["stage"] != "total"}


def runtime(comparison):
    runs = [run for run in representatives(comparison) if stages_of(run)]
    if not runs:
        return None
    names = [run.name for run in runs]
    stages = list(dict.fromkeys(stage for run in runs for stage in stages_of(run)))
    traces = [{"type": "bar", "orientation": "h", "name": stage, "y": names,
               "x": [stages_of(run).get(stage, 0.0) for run in runs],
               "marker": {"color": STAGE_COLOURS[i % len(STAGE_COLOURS)]},
               "hovertemplate": "%{y}<br>" + stage + ": %{x:.3g} ms<extra></extra>"}
              for i, stage in enumerate(stages)]
    totals = [sum(stages_of(run).values()) for run in runs]
    notes = [{"x": total, "y": name, "text": milliseconds(total), "showarrow": False,
              "xanchor": "left", "xshift": 6} for total, name in zip(totals, names)]
    return {"data": traces, "layout": layout(
        120 + 46 * len(runs), barmode="stack", bargap=0.35, annotations=notes,
        xaxis=axis("median milliseconds a frame", range=[0.0, 1.15 * max(totals) or 1.0]),
        yaxis=axis("", autorange="reversed", ticks=""))}
