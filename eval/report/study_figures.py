"""The figures of a study, as PDF and PNG, by Matplotlib: the thesis's layouts where it has them."""
import pathlib
from dataclasses import dataclass

from comparison import RUN_COLOURS, BadInput

BOUND = "bound"
FEWEST = 3  # landmarks that make a box


@dataclass
class Figure:
    title: str
    caption: str
    png: pathlib.Path


def pyplot():
    try:
        import matplotlib
    except ImportError as error:
        raise BadInput("matplotlib: not found; install python3-matplotlib") from error
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "axes.spines.top": False,
                         "axes.spines.right": False, "pdf.fonttype": 42, "svg.hashsalt": "slammot",
                         "legend.frameon": False, "axes.titlesize": 8.5})
    return plt


def finite(values):
    return [float("nan") if v is None else v for v in values]


def colours(summary):
    labels = []
    for group in summary["groups"]:
        for cell in group["cells"]:
            if cell["label"] not in labels and cell["label"] != BOUND:
                labels.append(cell["label"])
    return {label: RUN_COLOURS[i % len(RUN_COLOURS)] for i, label in enumerate(labels)}


def drawn(group):
    return [cell for cell in group["cells"] if "per_frame" in cell and cell["label"] != BOUND]


def bound_of(group):
    return next((cell for cell in group["cells"] if cell["label"] == BOUND and "per_frame" in cell), None)


def panels(plt, count, height=2.9, width=7.0):
    figure, axes = plt.subplots(count, 1, figsize=(width, height * count), squeeze=False)
    return figure, [row[0] for row in axes]


def boxes(axis, positions, stats, colour, width):
    """Boxes from quantiles: the quartiles and median, whiskers at 5% and 95%."""
    entries = [{"whislo": s[0], "q1": s[1], "med": s[2], "q3": s[3], "whishi": s[4], "fliers": []} for s in stats]
    line = {"color": colour, "linewidth": 0.9}
    axis.bxp(entries, positions=positions, widths=width, showfliers=False, manage_ticks=False, boxprops=line,
             whiskerprops=line, capprops=line, medianprops={"color": colour, "linewidth": 1.6})


def camera_error(plt, summary):
    groups = [g for g in summary["groups"] if drawn(g)]
    figure, axes = panels(plt, len(groups))
    colour = colours(summary)
    for axis, group in zip(axes, groups):
        cells = drawn(group)
        for i, cell in enumerate(cells):
            f = cell["per_frame"]
            stride = max(1, len(f["frame"]) // 24)
            picked = range(stride - 1, len(f["frame"]), stride)
            shift = (i - (len(cells) - 1) / 2) * 0.7 * stride / len(cells)
            stats = [(0.0, f["position_q25_m"][k], f["position_median_m"][k], f["position_q75_m"][k],
                      f["position_q95_m"][k]) for k in picked]
            stats = [(s[1], *s[1:]) for s in stats]  # no lower whisker: the lower quartile
            boxes(axis, [f["frame"][k] + shift for k in picked], stats, colour[cell["label"]], 0.6 * stride / len(cells))
            axis.plot([], [], color=colour[cell["label"]], label=cell["label"])
        bound = bound_of(group)
        if bound:
            axis.plot(bound["per_frame"]["frame"], finite(bound["per_frame"]["position_sigma_m"]), color="black",
                      linewidth=1, linestyle="--", label="Cramér-Rao bound (RMS)")
        axis.set(title=group["name"], xlabel="frame", ylabel="camera position error [m]", ylim=(0, None))
        axis.legend(fontsize=8)
    return figure, ("Error of the camera", "Boxes over the runs: quartiles and median, upper whisker at 95% (thesis figure 4.2a).")


def landmark_error(plt, summary):
    groups = [g for g in summary["groups"] if drawn(g)]
    figure, axes = plt.subplots(len(groups), 2, figsize=(9.0, 3.0 * len(groups)), squeeze=False)
    colour = colours(summary)
    kinds = (("static_position_m", "static landmarks"), ("moving_position_m", "moving landmarks"))
    for row, group in zip(axes, groups):
        cells = drawn(group)
        for axis, (key, name) in zip(row, kinds):
            for i, cell in enumerate(cells):
                ages = [a for a in cell["by_age"] if a[key]["count"] >= FEWEST]
                if not ages:
                    continue
                step = 0.8 / len(cells)
                where = [k + (i - (len(cells) - 1) / 2) * step for k in range(len(ages))]
                stats = [tuple(a[key][q] for q in ("q05", "q25", "median", "q75", "q95")) for a in ages]
                boxes(axis, where, stats, colour[cell["label"]], 0.8 * step)
                axis.plot([], [], color=colour[cell["label"]], label=cell["label"])
                axis.set_xticks(range(len(ages)), [str(a["observations"]) for a in ages])
            axis.set(title=f'{group["name"]}: {name}', xlabel="observed frames", ylabel="position error [m]")
            if axis.lines:
                axis.set_yscale("log")
                axis.legend(fontsize=8)
            else:
                axis.text(0.5, 0.5, "none", transform=axis.transAxes, ha="center")
    return figure, ("Error of the landmarks", "Over all landmarks of all runs that reached so many measurements: quartiles, median, "
                    "whiskers at 5% and 95%, logarithmic (thesis figures 4.2b and 4.2c).")


def classification_against_sweep(plt, summary):
    key = next((k for g in summary["groups"] for k in g["sweep"]), None)
    if key is None:
        raise BadInput("classification_against_sweep: the study sweeps nothing")
    scenarios = {}
    for group in summary["groups"]:
        scenarios.setdefault(group["name"].split(",")[0], []).append(group)
    labels = list(colours(summary))
    figure, axes = plt.subplots(len(scenarios), len(labels), figsize=(4.4 * len(labels), 3.2 * len(scenarios)), squeeze=False)
    curves = (("moving", lambda c: c[1] + c[2], "misclassified, moving", "#D55E00", "-"),
              ("static", lambda c: c[1] + c[2], "misclassified, static", "#0072B2", "-"),
              ("static", lambda c: c[1], "wrongly classified, static", "#0072B2", ":"))
    for row, (scenario, groups) in zip(axes, scenarios.items()):
        for axis, label in zip(row, labels):
            for kind, bad, name, colour, style in curves:
                points = []
                for group in groups:
                    cell = next(c for c in group["cells"] if c["label"] == label)
                    if kind in cell and sum(cell[kind]):
                        points.append((float(group["sweep"][key]), bad(cell[kind]) / sum(cell[kind])))
                axis.plot(*zip(*sorted(points)), style, color=colour, marker="o", markersize=3, label=name)
            axis.set(title=f"{scenario}: {label}", xlabel=key, ylabel="ratio", ylim=(-0.02, 1.02))
            axis.legend(fontsize=8)
    return figure, ("Classification against the threshold", "Ratios over all landmarks of all runs (thesis figures 4.1c and 4.1d).")


def classification(plt, summary):
    rows = [(g["name"], c) for g in summary["groups"] for c in drawn(g) if sum(c["static"]) or sum(c["moving"])]
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 0.6 + 0.32 * len(rows)), sharey=True)
    shades = ("#56B4E9", "#D55E00", "#BBBBBB")
    for axis, kind in zip(axes, ("static", "moving")):
        for i, (_, cell) in enumerate(rows):
            left, total = 0.0, max(1, sum(cell[kind]))
            for k, name in enumerate(("right", "wrong", "undecided")):
                share = cell[kind][k] / total
                axis.barh(-i, share, left=left, color=shades[k], label=name if i == 0 else None)
                left += share
        axis.set(title=f"truly {kind}", xlim=(0, 1), yticks=[-i for i in range(len(rows))])
        axis.set_yticklabels([f'{name}: {cell["label"]}' for name, cell in rows])
    axes[1].legend(fontsize=8, loc="lower left")
    return figure, ("Labels", "Shares of right, wrong and undecided landmarks, over all runs.")


def velocity(plt, summary):
    cells = [(g["name"], c) for g in summary["groups"] for c in drawn(g) if c["tracks"]]
    if not cells:
        raise BadInput("velocity: the study records no tracks")
    columns = max(len(c["tracks"]) for _, c in cells)
    figure, axes = plt.subplots(len(cells), columns, figsize=(3.4 * columns, 2.7 * len(cells)), squeeze=False)
    for row, (name, cell) in zip(axes, cells):
        for axis, track in zip(row, cell["tracks"]):
            for k, (component, colour) in enumerate(zip("xyz", ("#D55E00", "#009E73", "#0072B2"))):
                v = finite([x[k] for x in track["velocity"]])
                s = finite([x[k] for x in track["sigma"]])
                axis.plot(track["frame"], v, color=colour, label=f"v{component}")
                axis.fill_between(track["frame"], [a - 2 * b for a, b in zip(v, s)], [a + 2 * b for a, b in zip(v, s)],
                                  color=colour, alpha=0.15, linewidth=0)
                axis.plot(track["frame"], finite([x[k] for x in track["truth"]]), color=colour, linestyle="--", linewidth=0.8)
            axis.set(title=f'{cell["label"]}: target {track["track"]}', xlabel="frame", ylabel="velocity [m/s]", ylim=(-2.5, 2.5))
            axis.legend(fontsize=7, ncol=3)
    return figure, ("Velocities of the targets", "Median over the runs; shaded: two standard deviations as the estimator states them; "
                    "dashed: the truth (thesis figures 3.1 and 3.2).")


def trade_off(plt, summary):
    groups = [g for g in summary["groups"] if drawn(g)]
    figure, axes = plt.subplots(len(groups), 2, figsize=(9.0, 3.3 * len(groups)), squeeze=False)
    colour = colours(summary)
    for row, group in zip(axes, groups):
        for cell in drawn(group):
            rmse = cell.get("filtered_position_rmse_m")
            if not rmse or rmse["value"] is None:
                continue
            ms, hue = cell["timing"]["frame_median_ms"], colour[cell["label"]]
            low, high = rmse["lower"], rmse["upper"]
            error = None if low is None else [[rmse["value"] - low], [high - rmse["value"]]]
            row[0].errorbar(ms, rmse["value"], yerr=error, fmt="o", color=hue, label=cell["label"])
            if cell["anees"]["pose"]["mean"] is not None:
                row[1].plot(ms, cell["anees"]["pose"]["mean"], "o", color=hue, label=cell["label"])
        row[1].axhline(6, color="black", linewidth=0.8, linestyle="--")
        for axis, name in zip(row, ("position RMSE [m]", "ANEES of the pose (6 is right)")):
            axis.set(title=group["name"], xlabel="time of a frame, median [ms]", ylabel=name)
            axis.set_xscale("log")
            axis.legend(fontsize=7)
        row[0].set_ylim(0, None)
        row[1].set_yscale("log")
    return figure, ("Accuracy and consistency against cost", "Filtered estimates; bars are 95% bootstrap intervals over runs.")


def anees(plt, summary):
    groups = [g for g in summary["groups"] if drawn(g)]
    figure, axes = panels(plt, len(groups))
    colour = colours(summary)
    for axis, group in zip(axes, groups):
        for cell in drawn(group):
            f = cell["per_frame"]
            axis.plot(f["frame"], finite(f["anees_pose"]), color=colour[cell["label"]], linewidth=1, label=cell["label"])
        f = drawn(group)[0]["per_frame"]
        axis.fill_between(f["frame"], f["anees_pose_lower"], f["anees_pose_upper"], color="black", alpha=0.12, linewidth=0,
                          label="95% interval of a consistent estimator")
        axis.axhline(6, color="black", linewidth=0.8, linestyle="--")
        axis.set(title=group["name"], xlabel="frame", ylabel="ANEES of the pose")
        axis.set_yscale("log")
        axis.legend(fontsize=7)
    return figure, ("Consistency of the camera", "Average NEES over the runs, frame by frame; 6 is right.")


def anees_by_age(plt, summary):
    groups = [g for g in summary["groups"] if drawn(g)]
    figure, axes = plt.subplots(len(groups), 2, figsize=(9.0, 3.0 * len(groups)), squeeze=False)
    colour = colours(summary)
    for row, group in zip(axes, groups):
        for axis, part in zip(row, ("position", "velocity")):
            for cell in drawn(group):
                ages = [(a["observations"], a[f"nees_{part}"]) for a in cell["by_age"] if a[f"nees_{part}"]]
                ages = [(n, a) for n, a in ages if a["mean"] is not None]
                if ages:
                    axis.plot([n for n, _ in ages], [a["mean"] for _, a in ages], "o-", markersize=3,
                              color=colour[cell["label"]], label=cell["label"])
            axis.axhline(3, color="black", linewidth=0.8, linestyle="--")
            axis.set(title=f'{group["name"]}: {part}', xlabel="measurements of the landmark", ylabel=f"ANEES ({part})")
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.legend(fontsize=7)
    return figure, ("Consistency of the landmarks by age", "Average NEES over the landmarks of all runs with so many measurements; 3 is right.")


DRAWERS = {"camera_error": camera_error, "landmark_error": landmark_error, "classification": classification,
           "classification_against_sweep": classification_against_sweep, "velocity": velocity, "trade_off": trade_off,
           "anees": anees, "anees_by_age": anees_by_age}


def draw_all(summary, folder):
    folder.mkdir(parents=True, exist_ok=True)
    plt = pyplot()
    figures = []
    for name in summary["figures"]:
        if not any(drawn(group) for group in summary["groups"]):
            break  # every run failed at once: the tables say so
        figure, (title, caption) = DRAWERS[name](plt, summary)
        figure.tight_layout()
        figure.savefig(folder / f"{name}.pdf", metadata={"CreationDate": None})
        figure.savefig(folder / f"{name}.png", dpi=150, metadata={"Software": None})
        plt.close(figure)
        figures.append(Figure(title, caption, folder / f"{name}.png"))
    return figures
