"""What the figures of a study share: pyplot as they use it, axes with readable scales, one legend above all."""
import math

from .comparison import NotMade


def pyplot():
    try:
        import matplotlib
    except ImportError as error:
        raise NotMade("matplotlib: not found; install python3-matplotlib") from error
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "axes.spines.top": False,
                         "axes.spines.right": False, "pdf.fonttype": 42, "svg.hashsalt": "slammot",
                         "legend.frameon": False, "axes.titlesize": 8.5})
    return plt


def finite(values):
    return [float("nan") if v is None else v for v in values]


def grid(plt, rows, columns, width, height):
    """A figure and its rows of axes, each so many inches wide and high."""
    return plt.subplots(rows, columns, figsize=(width * columns, height * rows), squeeze=False)


def explain(axis, **names):
    """Title, names, scales and limits of an axis; logarithmic ones get ticks that can be read."""
    axis.set(**names)
    for which, part in (("x", axis.xaxis), ("y", axis.yaxis)):
        if names.get(f"{which}scale") == "log":
            readable_ticks(part, *(axis.get_xlim() if which == "x" else axis.get_ylim()))


def readable_ticks(part, low, high):
    """At 1, 2, 5 of few decades, at 1 of more; plain numbers, and powers of ten where these would be long."""
    from matplotlib.ticker import FuncFormatter, LogFormatterMathtext, LogLocator, NullFormatter
    decades = math.log10(high / low)
    part.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if decades < 2.5 else (1.0,), numticks=12))
    part.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.10g}") if low >= 1e-4 and high < 1e7 else LogFormatterMathtext())
    part.set_minor_formatter(NullFormatter())


def legend_above(figure):
    """One legend for all axes, above them: it lies over no curve."""
    entries = {}
    for axis in figure.axes:
        for handle, label in zip(*axis.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    if entries:
        columns = max(1, min(len(entries), int(figure.get_figwidth() / (0.5 + 0.075 * max(map(len, entries))))))
        figure.legend(entries.values(), entries.keys(), loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=columns, fontsize=8)


def expected(axis, value):
    """Where the mean NEES of a consistent estimator is."""
    axis.axhline(value, color="black", linewidth=0.8, linestyle="--")


def around(values):
    """Limits that show these values and half as much about them; a band may leave them."""
    if not values:
        return None, None
    low, high = min(values), max(values)
    margin = 0.5 * (high - low) or 1.0
    return low - margin, high + margin
