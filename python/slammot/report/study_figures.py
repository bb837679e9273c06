"""The figures of a study, as PDF, SVG and PNG, by Matplotlib: the thesis's layouts where it has them."""
import pathlib
import re
from dataclasses import dataclass

from . import lags
from . import metrics
from .charts import distributions
from .comparison import RUN_COLOURS, BadInput
from .page import aside
from .study_axes import around, expected, explain, finite, grid, legend_above, pyplot
from .study_tables import error_name, error_of, estimators_of, frame_ms, is_ideal, plain, value_of

FEWEST = 3  # landmarks that make a box


MARKERS = "osD^vPX*"  # where lines lie close together


FIGURES = {}  # by the name that a study's file gives; eval/study/study_figures.cpp lists the names


@dataclass
class Figure:
    title: str
    caption: str
    svg: pathlib.Path


def registered(draw):
    """A figure is a function of (pyplot, summary) that returns (figure, (title, caption)); its name is the function's."""
    FIGURES[draw.__name__] = draw
    return draw


def colours(summary):
    labels = dict.fromkeys(cell["label"] for _, cell in estimators_of(summary))
    return {label: RUN_COLOURS[i % len(RUN_COLOURS)] for i, label in enumerate(labels)}


def plotted(group):
    return [cell for cell in group["cells"] if "per_frame" in cell and not is_ideal(cell)]


def plotted_cells(summary):
    """(group's name, cell) of all that is plotted."""
    return [(group["name"], cell) for group in summary["groups"] for cell in plotted(group)]


def ideal_of(group):
    return next((cell for cell in group["cells"] if is_ideal(cell) and "per_frame" in cell), None)


def group_rows(plt, summary, columns, width, height):
    """A figure, and for each group (group, its row of axes, its cells): a cell is (cell, colour and label of its marks)."""
    colour = colours(summary)
    groups = [(g, [(c, {"color": colour[c["label"]], "label": c["label"]}) for c in plotted(g)])
              for g in summary["groups"] if plotted(g)]
    figure, rows = grid(plt, len(groups), columns, width, height)
    return figure, [(group, row, cells) for row, (group, cells) in zip(rows, groups)]


def centred(count):
    """Places of so many things side by side, in units of their distance."""
    return [i - (count - 1) / 2 for i in range(count)]


def boxes(axis, positions, stats, width, color, label):
    """Boxes from quantiles: the quartiles and median, whiskers at 5% and 95%."""
    entries = [{"whislo": s[0], "q1": s[1], "med": s[2], "q3": s[3], "whishi": s[4], "fliers": []} for s in stats]
    line = {"color": color, "linewidth": 0.9}
    axis.bxp(entries, positions=positions, widths=width, showfliers=False, manage_ticks=False, boxprops=line,
             whiskerprops=line, capprops=line, medianprops={"color": color, "linewidth": 1.6})
    axis.plot([], [], color=color, label=label)


def camera_boxes(axis, cell, place, count, style):
    """Of every n-th frame; the lower whisker ends at the lower quartile."""
    f = cell["per_frame"]
    stride = max(1, len(f["frame"]) // 24)
    picked = range(stride - 1, len(f["frame"]), stride)
    names = [f"position_{q}_m" for q in ("q25", "q25", "median", "q75", "q95")]
    shift = place * 0.7 * stride / count
    boxes(axis, [f["frame"][k] + shift for k in picked], [[f[name][k] for name in names] for k in picked],
          0.6 * stride / count, **style)


@registered
def camera_error(plt, summary):
    figure, rows = group_rows(plt, summary, 1, 7.0, 2.9)
    for group, (axis,), cells in rows:
        for place, (cell, style) in zip(centred(len(cells)), cells):
            camera_boxes(axis, cell, place, len(cells), style)
        ideal = ideal_of(group)
        if ideal:
            axis.plot(ideal["per_frame"]["frame"], finite(ideal["per_frame"]["position_sigma_m"]), color="black",
                      linewidth=1, linestyle="--", label="ideal sigma (RMS)")
        explain(axis, title=group["name"], xlabel="frame", ylabel="camera position error [m]", ylim=(0, None))
    return figure, ("Camera position error", "Of a batch, smoothed. Boxes over the runs: median and quartiles, upper whisker at the 95% quantile (thesis figure 4.2a).")


def landmark_boxes(axis, cell, key, place, count, style):
    """By the number of observed frames, where there are enough landmarks."""
    ages = [a for a in cell["by_age"] if a[key]["count"] >= FEWEST]
    if not ages:
        return
    step = 0.8 / count
    stats = [[a[key][q] for q in ("q05", "q25", "median", "q75", "q95")] for a in ages]
    boxes(axis, [k + place * step for k in range(len(ages))], stats, 0.8 * step, **style)
    axis.set_xticks(range(len(ages)), [str(a["observations"]) for a in ages])


@registered
def landmark_error(plt, summary):
    figure, rows = group_rows(plt, summary, 2, 4.5, 3.0)
    for group, axes, cells in rows:
        for axis, kind in zip(axes, ("static", "moving")):
            for place, (cell, style) in zip(centred(len(cells)), cells):
                landmark_boxes(axis, cell, f"{kind}_position_m", place, len(cells), style)
            axis.set(title=f'{group["name"]}: {kind} landmarks', xlabel="observed frames", ylabel="position error [m]")
            if axis.lines:
                explain(axis, yscale="log")
            else:
                axis.text(0.5, 0.5, "none", transform=axis.transAxes, ha="center")
    return figure, ("Landmark position error", "Over all landmarks of all runs with this number of measurements: median, quartiles, "
                    "whiskers at the 5% and 95% quantiles; logarithmic scale (thesis figures 4.2b and 4.2c). Of a batch, those of the window in front of it.")


def by_scenario(summary):
    """The groups of each scenario, one for each swept value."""
    scenarios = {}
    for group in summary["groups"]:
        scenarios.setdefault(group["name"].split(",")[0], []).append(group)
    return scenarios


def sweep_curve(groups, key, label, kind, bad):
    """(swept value, ratio of the bad landmarks of a kind) of an estimator, where there are any of this kind."""
    cells = [(float(group["sweep"][key]), next(c for c in group["cells"] if c["label"] == label)) for group in groups]
    return sorted((value, bad(cell[kind]) / sum(cell[kind])) for value, cell in cells if kind in cell and sum(cell[kind]))


@registered
def classification_against_sweep(plt, summary):
    key = next((k for g in summary["groups"] for k in g["sweep"]), None)
    if key is None:
        raise BadInput("classification_against_sweep: the study sweeps nothing")
    scenarios, labels = by_scenario(summary), list(colours(summary))
    figure, rows = grid(plt, len(scenarios), len(labels), 4.4, 3.2)
    curves = (("moving", lambda c: c[1] + c[2], "misclassified, moving", "#D55E00", "-"),
              ("static", lambda c: c[1] + c[2], "misclassified, static", "#0072B2", "-"),
              ("static", lambda c: c[1], "wrongly classified, static", "#0072B2", ":"))
    for row, (scenario, groups) in zip(rows, scenarios.items()):
        for axis, label in zip(row, labels):
            for kind, bad, name, colour, style in curves:
                points = sweep_curve(groups, key, label, kind, bad)
                axis.plot(*zip(*points), style, color=colour, marker="o", markersize=3, label=name)
            explain(axis, title=f"{scenario}: {label}", xlabel=key, ylabel="ratio", ylim=(0, None))
    return figure, ("Classification against the threshold", "Ratios over all landmarks of all runs (thesis figures 4.1c and 4.1d).")


def label_bar(axis, y, counts, named):
    """The shares of right, wrong and undecided landmarks, one after another; one bar names them for the legend."""
    left, total = 0.0, max(1, sum(counts))
    for count, name, shade in zip(counts, ("right", "wrong", "undecided"), ("#56B4E9", "#D55E00", "#BBBBBB")):
        axis.barh(y, count / total, left=left, color=shade, label=name if named else None)
        left += count / total


@registered
def classification(plt, summary):
    rows = [(name, c) for name, c in plotted_cells(summary) if sum(c["static"]) or sum(c["moving"])]
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 1.0 + 0.32 * len(rows)), sharey=True)
    for axis, kind in zip(axes, ("static", "moving")):
        for i, (_, cell) in enumerate(rows):
            label_bar(axis, -i, cell[kind], named=i == 0)
        axis.set(title=f"truly {kind}", xlim=(0, 1), yticks=[-i for i in range(len(rows))])
        axis.set_yticklabels([f'{name}: {cell["label"]}' for name, cell in rows])
    return figure, ("Labels", "Shares of right, wrong and undecided landmarks, over all runs.")


def velocity_component(axis, track, k, colour):
    """A component of a target's velocity with the band that the estimator states, and the truth."""
    v, s, truth = (finite([x[k] for x in track[name]]) for name in ("velocity", "sigma", "truth"))
    axis.plot(track["frame"], v, color=colour, label=f'v{"xyz"[k]}')
    axis.fill_between(track["frame"], [a - 2 * b for a, b in zip(v, s)], [a + 2 * b for a, b in zip(v, s)],
                      color=colour, alpha=0.15, linewidth=0)
    axis.plot(track["frame"], truth, color=colour, linestyle="--", linewidth=0.8)


@registered
def velocity(plt, summary):
    cells = [cell for _, cell in plotted_cells(summary) if cell["tracks"]]
    if not cells:
        raise BadInput("velocity: the study records no tracks")
    figure, rows = grid(plt, len(cells), max(len(c["tracks"]) for c in cells), 3.4, 2.7)
    for row, cell in zip(rows, cells):
        for axis, track in zip(row, cell["tracks"]):
            for k, colour in enumerate(("#D55E00", "#009E73", "#0072B2")):
                velocity_component(axis, track, k, colour)
            explain(axis, title=f'{cell["label"]}: target {track["track"]}', xlabel="frame",
                    ylabel="velocity [m/s]", ylim=around([v for name in ("velocity", "truth") for x in track[name] for v in x if v is not None]))
    return figure, ("Estimated velocities", "Median over the runs. Shaded: two standard deviations as stated by the estimator. "
                    "Dashed: ground truth (thesis figures 3.1 and 3.2).")


def cost_points(accuracy, consistency, cell, style):
    """A cell's RMSE with its interval, and its ANEES, against its time, where they are defined."""
    rmse = error_of(cell)
    if not rmse or rmse["value"] is None:
        return
    value, low, ms = rmse["value"], rmse["lower"], frame_ms(cell)
    error = None if low is None else [[value - low], [rmse["upper"] - value]]
    accuracy.errorbar(ms, value, yerr=error, fmt="o", **style)
    mean = cell["anees"].get("pose", {}).get("mean")
    if mean is not None:
        consistency.plot(ms, mean, "o", **style)


@registered
def trade_off(plt, summary):
    figure, rows = group_rows(plt, summary, 2, 4.5, 3.3)
    for group, (accuracy, consistency), cells in rows:
        for cell, style in cells:
            cost_points(accuracy, consistency, cell, style)
        expected(consistency, 6)
        shared = {"title": group["name"], "xlabel": "time per frame [ms]", "xscale": "log"}
        explain(accuracy, **shared, ylabel=f"{error_name(group)} [m]", ylim=(0, None))
        explain(consistency, **shared, ylabel="ANEES of the pose (6 expected)", yscale="log")
        if not any("pose" in cell["anees"] for cell, _ in cells):
            consistency.text(0.5, 0.5, "not judged: truth not exact, or no covariance", transform=consistency.transAxes, ha="center")
    return figure, ("Accuracy and consistency against cost", "Filtered estimates; for a batch, smoothed ones. Bars: 95% intervals over runs.")


def anees_line(axis, cell, part, style):
    f = cell["per_frame"]
    if f"anees_{part}" in f:  # not with measured truth
        axis.plot(f["frame"], finite(f[f"anees_{part}"]), linewidth=1, **style)


@registered
def anees(plt, summary):
    figure, rows = group_rows(plt, summary, 3, 4.2, 2.9)
    for group, axes, cells in rows:
        for axis, (part, dof) in zip(axes, (("pose", 6), ("position", 3), ("rotation", 3))):
            for cell, style in cells:
                anees_line(axis, cell, part, style)
            f = cells[0][0]["per_frame"]
            if f"anees_{part}" in f:
                axis.fill_between(f["frame"], finite(f[f"anees_{part}_lower"]), finite(f[f"anees_{part}_upper"]), color="black", alpha=0.12,
                                  linewidth=0, label="95% interval of a consistent estimator")
            expected(axis, dof)
            explain(axis, title=f'{group["name"]}: {part}', xlabel="frame", ylabel=f"ANEES ({part})", yscale="log")
    return figure, ("Consistency of the camera", "Of a batch, smoothed. NEES averaged over the runs, for each frame. A consistent estimator has 6 for the pose and 3 for position "
                    "and rotation.")


def interval_band(axis, x, lower, upper, style):
    axis.fill_between(x, finite(lower), finite(upper), color=style["color"], alpha=0.2, linewidth=0)


def landmark_parts(plt, summary, height, draw, name, **names):
    """For each group a row with NEES of position and of velocity; `draw` draws a cell's."""
    figure, rows = group_rows(plt, summary, 2, 4.5, height)
    for group, axes, cells in rows:
        for axis, part in zip(axes, ("position", "velocity")):
            for cell, style in cells:
                draw(axis, part, cell, style)
            expected(axis, 3)
            explain(axis, title=f'{group["name"]}: {part}', ylabel=f"{name} ({part})", yscale="log", **names)
    return figure


@registered
def landmark_anees(plt, summary):
    def by_frame(axis, part, cell, style):
        f = cell["per_frame"]
        anees_line(axis, cell, f"landmark_{part}", style)
        if f"anees_landmark_{part}" in f:  # not of a batch
            interval_band(axis, f["frame"], f[f"anees_landmark_{part}_lower"], f[f"anees_landmark_{part}_upper"], style)

    figure = landmark_parts(plt, summary, 2.9, by_frame, "ANEES of landmarks", xlabel="frame")
    return figure, ("Consistency of the landmarks by frame", "NEES averaged over the landmarks measured in a frame and over the runs, "
                    "with 95% interval over runs. A consistent estimator has 3.")


@registered
def anees_by_age(plt, summary):
    def by_age(axis, part, cell, style):
        ages = [(a["observations"], a[f"nees_{part}"]) for a in cell["by_age"] if a[f"nees_{part}"]]
        points = [(n, a["mean"], a["lower"], a["upper"]) for n, a in ages if a["mean"] is not None]
        if points:
            n, means, lower, upper = zip(*points)
            axis.plot(n, means, "o-", markersize=3, **style)
            interval_band(axis, n, lower, upper, style)

    figure = landmark_parts(plt, summary, 3.0, by_age, "ANEES", xlabel="measurements of the landmark", xscale="log")
    return figure, ("Consistency of the landmarks by age", "NEES averaged over the landmarks of all runs with this number of measurements, "
                    "with 95% interval over runs. A consistent estimator has 3. Of a batch, the window in front of it.")


def swept_key(summary):
    return next(key for group in summary["groups"] for key in group["sweep"])


def against_sweep(plt, summary, key):
    """Any number of the cells against the swept value, a line for each estimator."""
    swept, table = swept_key(summary), metrics.read_table(summary["metrics"])
    name = metrics.heading(table[key]) if key in table else plain(key)
    scenarios, colour = by_scenario(summary), colours(summary)
    figure, rows = grid(plt, len(scenarios), 1, 6.0, 3.2)
    for (axis,), (scenario, groups) in zip(rows, scenarios.items()):
        values = []
        for label in colour:
            cells = sorted((float(g["sweep"][swept]), c) for g in groups for c in plotted(g) if c["label"] == label)
            points = [(x, e["value"], e["lower"], e["upper"]) for x, e in ((x, value_of(c, key)) for x, c in cells) if e and e["value"] is not None]
            if not points:
                continue
            x, y, low, high = zip(*points)
            axis.plot(x, y, "o-", markersize=4, color=colour[label], label=label)
            values += [v for v in (*y, *low, *high) if v is not None]
            if None not in low:
                axis.fill_between(x, low, high, color=colour[label], alpha=0.18, linewidth=0)
        if key.startswith("anees_"):
            expected(axis, 6 if key == "anees_pose" else 3)
        logs = {f"{which}scale": "log" for which, of in (("x", [float(g["sweep"][swept]) for g in groups]), ("y", values)) if is_wide(of)}
        explain(axis, title=scenario, xlabel=swept, ylabel=name, **logs)
    return figure, (f"{name[:1].upper()}{name[1:]} against {swept}",
                    "Over all runs, with 95% interval over runs" + (". Dashed: a consistent estimator." if key.startswith("anees_") else "."))


def is_wide(values):
    """Positive values over more than a factor of twenty are drawn on a logarithmic scale."""
    return bool(values) and min(values) > 0 and max(values) > 20 * min(values)


AXES = ("x [m]", "y [m]", "z [m]", "about x [rad]", "about y [rad]", "about z [rad]")


@registered
def error_axes(plt, summary):
    cells = [(name, cell) for name, cell in plotted_cells(summary) if cell.get("axes")]
    if not cells:
        raise BadInput("error_axes: no first run with exact truth")
    figure, rows = grid(plt, len(cells), 6, 2.6, 2.2)
    colour = colours(summary)
    for row, (name, cell) in zip(rows, cells):
        axes = cell["axes"]
        for k, axis in enumerate(row):
            errors, sigma = finite([e[k] for e in axes["error"]]), finite([s[k] for s in axes["sigma"]])
            axis.fill_between(axes["frame"], [-3 * s for s in sigma], [3 * s for s in sigma], color="black", alpha=0.12, linewidth=0, label="3σ as stated")
            axis.plot(axes["frame"], errors, color=colour[cell["label"]], linewidth=1, label=cell["label"])
            explain(axis, xlabel="frame", ylabel=AXES[k])
        row[0].set_title(f'{name}: {cell["label"]}', loc="left")
    return figure, ("Error of each axis", "True less estimated pose of the first run, of a batch the smoothed one: position in the world, rotation in the camera. Shaded: three standard deviations as stated.")


def lag_line(axis, line, shift, style):
    """A quantity against the lag, with its interval over runs; a little aside, so that bars of equal lags stand apart."""
    x = [place * shift for place in lags.places(line.lags)]
    y, low, high = (line.values(which) for which in ("value", "lower", "upper"))
    bars = None if None in low else [[v - l for v, l in zip(y, low)], [h - v for v, h in zip(y, high)]]
    axis.errorbar(x, y, yerr=bars, fmt="-", markersize=3.5, linewidth=1.2, capsize=2, **style)


@registered
def lag(plt, summary):
    """None where no estimator keeps past poses."""
    groups = [(group, [(cell, lines) for cell in plotted(group) if (lines := lags.summary_lines(summary, cell))]) for group in summary["groups"]]
    groups = [(group, cells) for group, cells in groups if cells]
    if not groups:
        return None
    figure, rows = grid(plt, len(groups), len(lags.RATIOS), 3.6, 3.0)
    colour = colours(summary)
    place_of = {label: i for i, label in enumerate(colour)}
    for row, (group, cells) in zip(rows, groups):
        for axis, (quantity, name) in zip(row, lags.RATIOS):
            shown = [(cell, lines[quantity]) for cell, lines in cells if quantity in lines]
            for place, (cell, line) in zip(centred(len(shown)), shown):
                lag_line(axis, line, 1.03 ** place, {"color": colour[cell["label"]], "label": cell["label"], "marker": MARKERS[place_of[cell["label"]] % len(MARKERS)]})
            axis.axhline(1.0, color="black", linestyle="--", linewidth=1)
            axis.set(title=group["name"], xlabel="lag [frames]", ylabel=f"{name} over filtered", xscale="log")
            known = sorted({lag for _, line in shown for lag in line.lags})
            axis.set_xticks(lags.places(known), known)
            axis.minorticks_off()
    return figure, ("Poses at a lag", f"{lags.EXPLAINED} {lags.OVER_FILTERED} Bars: 95% intervals over runs. Dashed: as filtered.")


def drawn(plt, summary, name):
    name, _, parameter = name.partition(":")
    return against_sweep(plt, summary, parameter) if parameter else FIGURES[name](plt, summary)


def file_of(name):
    """In the folder of the figures, whatever the name."""
    return re.sub(r"[^\w.-]", "_", name)


def save(figure, file, **options):
    with aside(file) as unfinished:
        figure.savefig(unfinished, bbox_inches="tight", **options)


# Without the time and the version of who wrote them: the same bytes each time.
FILES = {"pdf": {"metadata": {"CreationDate": None}}, "svg": {"metadata": {"Date": None, "Creator": None}},
         "png": {"metadata": {"Software": None}, "dpi": 150}}


def draw_all(summary, folder, runs=()):
    """Of each run of `runs` a row of runs.csv: how they are distributed needs no asking."""
    folder.mkdir(parents=True, exist_ok=True)
    names = [name for name in summary["figures"] if name in FIGURES or ":" in name]  # others are tables
    several = bool(distributions.shown_groups(summary, runs))
    if not (names or several) or not any(plotted(group) for group in summary["groups"]):
        return []  # nothing asked for, or every run failed at once: the tables say so
    plt = pyplot()
    figures = []
    for name in (["distributions"] if several else []) + names:
        made = distributions.draw(plt, summary, runs) if name == "distributions" else drawn(plt, summary, name)
        if made is None:
            continue
        figure, (title, caption) = made
        figure.tight_layout()
        legend_above(figure)
        for ending, options in FILES.items():
            save(figure, folder / f"{file_of(name)}.{ending}", **options)
        plt.close(figure)
        figures.append(Figure(title, caption, folder / f"{file_of(name)}.svg"))
    return figures
