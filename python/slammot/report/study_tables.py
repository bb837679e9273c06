"""The tables of a study: summary, every metric, consistency, classification as in the thesis's table 4.1, paired comparisons."""
import csv
import io
import math
import re
from dataclasses import dataclass, field

from . import lags
from . import metrics
from .pooled_verdict import anees_class, is_tested
from .verdict import failure_bound


PAGE = 1224  # pixels of a page's text in a window of 1400
LONG = 40  # letters of a cell that is wrapped
AT_ONCE = 200  # letters of a caption
INTERVALS = "95% intervals over runs (Student's t), from five runs on"


@dataclass
class Table:
    title: str
    caption: str
    head: list
    rows: list  # of texts, as the head
    classes: dict = field(default_factory=dict)  # (row, column) to a class of the page's style

    def csv(self):
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.head)
        writer.writerows(self.rows)
        return text.getvalue()

    def latex(self):
        numbers = "".join("p{9cm}" if any(len(row[i]) > 80 for row in self.rows) else "r" for i in range(2, len(self.head)))
        return booktabs("l" * 2 + numbers, list(map(escaped, self.head)), [list(map(escaped, row)) for row in self.rows])

    def parts(self, most):
        """The table as those beside which a page scrolls not: each has the first two columns and as many others as fit into so many pixels."""
        widths = [column_width(head, [row[i] for row in self.rows]) for i, head in enumerate(self.head)]
        room, others = most - sum(widths[:2]), widths[2:]
        parts = filled(others, room)
        while room > 0 and len(filled(others, room - 20)) == len(parts):  # about as many columns in each
            room -= 20
        return [self.columns([0, 1, *(2 + i for i in part)]) for part in filled(others, room)] or [self]

    def columns(self, kept):
        classes = {(row, kept.index(i)): kind for (row, i), kind in self.classes.items() if i in kept}
        return Table(self.title, self.caption, [self.head[i] for i in kept], [[row[i] for i in kept] for row in self.rows], classes)

    def spans(self):
        """For each row, over how many rows its first cell reaches; 0 below the first of equal ones."""
        spans = []
        for i, row in enumerate(self.rows):
            same = i > 0 and row[0] == self.rows[i - 1][0]
            reach = next((k for k in range(i, len(self.rows)) if self.rows[k][0] != row[0]), len(self.rows)) - i
            spans.append(0 if same else reach)
        return spans


def filled(widths, room):
    """Things of these widths in a row as long as there is room, then in the next; at least one in each."""
    rows, left = [], 0
    for i, width in enumerate(widths):
        if not rows or width > left:
            rows.append([])
            left = room
        rows[-1].append(i)
        left -= width
    return rows


def cell_width(text):
    """About, in pixels, on a page: the interval stands below its value in smaller letters, a long text is wrapped."""
    value, _, interval = text.partition(" [")
    return 320 if len(text) > LONG else max(sum(9 if c.isdigit() else 7.4 for c in value), 6.5 * (len(interval) + 1))


def column_width(head, texts):
    """A head is wrapped between words."""
    return 12 + max([8.6 * len(word) for word in head.split()] + list(map(cell_width, texts)))


def opening(caption):
    """What of a caption is read at once, and the rest where it is long: whole sentences both."""
    first, *others = re.split(r"(?<=\.) (?=[A-Z0-9√])", caption)
    while others and len(first) + len(others[0]) < AT_ONCE:
        first += " " + others.pop(0)
    rest = " ".join(others)
    return (first, rest) if len(rest) > AT_ONCE / 2 else (caption, "")


def booktabs(columns, head, rows):
    """Lines of cells that are LaTeX already; a rule between groups of equal first cells, which stand once."""
    lines = [r"% \usepackage{booktabs}", rf"\begin{{tabular}}{{{columns}}}", r"\toprule", " & ".join(head) + r" \\", r"\midrule"]
    for i, row in enumerate(rows):
        again = i > 0 and row[0] == rows[i - 1][0]
        if i > 0 and not again and any(a[0] == b[0] for a, b in zip(rows, rows[1:])):
            lines.append(r"\addlinespace")
        lines.append(" & ".join(["" if again else row[0], *row[1:]]) + r" \\")
    return "\n".join(lines + [r"\bottomrule", r"\end{tabular}", ""])


LATEX = {**{c: "\\" + c for c in "&%$#_{}"}, "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
         "–": "--", "−": "$-$", "∞": r"$\infty$", "σ": r"$\sigma$", "√": r"$\surd$"}


def escaped(text):
    return "".join(LATEX.get(character, character) for character in text)


def number(value, digits=3):
    if value is None:
        return "–"
    return f"{value:.{digits}g}"


def with_interval(estimate):
    """value [lower, upper]"""
    if not estimate or estimate["value"] is None:
        return "–"
    if estimate["lower"] is None:
        return number(estimate["value"])
    return f'{number(estimate["value"])} [{number(estimate["lower"])}, {number(estimate["upper"])}]'


def percent(part, whole):
    return "–" if part is None or not whole else f"{100.0 * part / whole:.1f}%"


def share(estimate):
    """Of the runs; of those that began."""
    return percent(estimate["value"], 1) if estimate else "–"


def is_ideal(cell):
    """An ideal covariance estimates nothing and is compared with nothing."""
    return cell["kind"] == "ideal_covariance"


def acting(cell, name):
    """What became of a mechanism beyond the thesis in the runs of a cell: (text, why it is off)."""
    found = next((m for m in cell.get("in_force", []) if m["name"] == name), None)
    if found is None:
        return ("states nothing" if cell.get("in_force") == [] else "–"), ""
    if not found["on"]:
        return "off", found["because"]
    runs = "" if found["on"] == found["runs"] else f" in {found['on']} of {found['runs']}"
    return f"on{runs}, {found['acted']}", found["because"]


def in_force(group):
    """(name, key, what became of it in each cell) of every mechanism that a run of the group states."""
    keys = {m["name"]: m["key"] for cell in group["cells"] for m in cell.get("in_force", [])}
    return [(name, key, [acting(cell, name) for cell in group["cells"]]) for name, key in keys.items()]


def cells_of(summary):
    for group in summary["groups"]:
        for cell in group["cells"]:
            yield group, cell


def estimators_of(summary):
    return [(group, cell) for group, cell in cells_of(summary) if not is_ideal(cell)]


def estimators_with(key, summary):
    """(group, cell, what stands there under the key) where anything does."""
    return [(group, cell, cell[key]) for group, cell in estimators_of(summary) if cell.get(key)]


def is_batch(cell):
    """A batch is judged by what it is for: its filtered trajectory is its front window's."""
    return cell["kind"] == "batch"


def error_of(cell):
    """The error by which estimators are compared: after alignment where the truth is measured."""
    which = "smoothed" if is_batch(cell) else "filtered"
    return cell.get(f"{which}_{'ate_sim3_m' if cell.get('aligned') else 'position_rmse_m'}")


def error_name(group):
    return "ATE Sim(3)" if any(cell.get("aligned") for cell in group["cells"]) else "position RMSE"


def anees_text(part):
    if part.get("infinite") or part.get("lower") is None:
        return anees_mean(part)
    return with_interval({"value": part["mean"], "lower": part["lower"], "upper": part["upper"]})


def ideal_sigma(cell):
    """The standard deviation of the position, root mean square over the frames: the first, a pin, has none and stands in no list."""
    sigma = [s for s in cell.get("per_frame", {}).get("position_sigma_m", []) if s is not None]
    return math.sqrt(sum(s * s for s in sigma) / (len(sigma) + 1)) if sigma else None


def frame_ms(cell):
    return cell.get("timing", {}).get("frame_median_ms")


LAST_SCALE = "ATE Sim(3), last scale [m]"
IN_LAST_SCALE = "Where nothing measures the scale, the ATE before the last scale's is of poses as they were when newest, each in the scale believed then; in the last scale they all are in that of the end. "


def has_last_scale(group):
    """Whether nothing measures its scale, so that the shape counts."""
    return any("last_scale_ate_sim3_m" in cell for cell in group["cells"])


def summary_cells(group, cell):
    """Head to (text, class)."""
    if is_ideal(cell):
        return {"runs": (str(cell["runs"]), ""), "diverged": (str(len(cell["diverged"])), ""), "position RMSE [m]": (number(ideal_sigma(cell)), "")}
    anees = cell.get("anees", {})
    pose, position = anees.get("pose", {}), anees.get("position", {})
    over_ideal = cell.get("rmse_over_ideal", {})
    aligned = cell.get("aligned")
    which = "smoothed" if is_batch(cell) else "filtered"
    silent = cell.get("failed_silently")
    return {
        "runs": (str(cell["runs"]), ""),
        "failed": (str(len(cell["lost"])), "over" if cell["lost"] else ""),
        "diverged": (str(len(cell["diverged"])), "over" if cell["diverged"] else ""),
        "warned": (share(cell.get("warned")), ""),
        "failed, not warned": (share(silent), "over" if silent and silent["value"] else ""),
        "ATE Sim(3) [m]": (with_interval(cell.get(f"{which}_ate_sim3_m")) if aligned or has_last_scale(group) else "–", ""),
        LAST_SCALE: (with_interval(cell.get("last_scale_ate_sim3_m")), ""),
        "scale": (with_interval(cell.get(f"{which}_sim3_scale")) if aligned else "–", ""),
        "position RMSE [m]": (with_interval(cell.get(f"{which}_position_rmse_m")), ""),
        "ANEES pose (6)": (anees_text(pose), anees_class(pose)),
        "frames inside": (percent(pose["inside"], 1) if pose.get("inside") is not None else "–", ""),
        "ANEES position (3)": (anees_text(position), anees_class(position)),
        "RMSE over ideal sigma": (number(over_ideal.get("position")), ""),
        "the same, median run": (with_interval(over_ideal.get("median")), ""),
        "joint NIS (2)": (with_interval(cell.get("nis_joint")), ""),
        "NIS of 30 (2)": (with_interval(cell.get("nis_lasting")), ""),
        "time per frame [ms]": (number(frame_ms(cell)), "")}


def summary_table(summary):
    cells = [(group["name"], cell["label"], summary_cells(group, cell)) for group, cell in cells_of(summary)]
    heads = [head for head in dict.fromkeys(head for _, _, of_cell in cells for head in of_cell)
             if any(of_cell.get(head, ("–",))[0] != "–" for _, _, of_cell in cells)]
    order = [h for h in ORDER if h in heads]
    rows = [[group, label] + [of_cell.get(head, ("–", ""))[0] for head in order] for group, label, of_cell in cells]
    classes = {(i, k + 2): of_cell[head][1] for i, (_, _, of_cell) in enumerate(cells) for k, head in enumerate(order) if head in of_cell}
    return Table(
        "Summary",
        f"Over all runs; brackets: {INTERVALS}. Orange: failed or diverged runs, and ANEES whose interval lies above "
        "what a consistent estimator has (in parentheses); blue: below. Frames inside: those whose ANEES, over the runs, lies in its two-sided 95% interval. "
        "A run has failed when its position error exceeds "
        f"{failure_bound(False)} (where the truth is measured: {failure_bound(True)}), has diverged when its state is no longer finite, and warns where its own numbers "
        "speak against it, without any truth. RMSE is over the runs that did not diverge; of a batch, values are smoothed ones. RMSE over ideal sigma: ratio to the standard deviation of the ideal covariance, that of an EKF "
        "linearised at the truth, with known labels, the fixed depth prior and no gate; its row gives it. It is no bound. Joint NIS: of all accepted measurements of "
        "a frame together, a measurement; 2 is right with an open gate. NIS of 30: of the sum of thirty innovations of a track; more than 2 where its errors last. "
        f"{IN_LAST_SCALE if LAST_SCALE in order else ''}Other numbers: table Metrics.",
        ["scenario", "estimator"] + order, rows, classes)


ORDER = ("runs", "failed", "diverged", "warned", "failed, not warned", "ATE Sim(3) [m]", LAST_SCALE, "scale", "position RMSE [m]", "ANEES pose (6)", "frames inside",
         "ANEES position (3)", "joint NIS (2)", "NIS of 30 (2)", "RMSE over ideal sigma", "the same, median run", "time per frame [ms]")

NAMED = 3  # runs


def warning_text(run):
    """The first reason, and how many more there are."""
    first, *others = run["warnings"]
    began = "" if first["frame"] is None else f'from frame {first["frame"]}, '
    more = f" (and {len(others)} more)" if others else ""
    return f'seed {run["seed"]}: {began}{first["reason"]}{more}'


def warnings_table(summary):
    rows = []
    for group, cell in estimators_of(summary):
        runs = cell.get("warnings") or []
        if runs:
            more = f". And {len(runs) - NAMED} more runs" if len(runs) > NAMED else ""
            rows.append([group["name"], cell["label"], str(cell["runs"]), str(len(runs)), ". ".join(map(warning_text, runs[:NAMED])) + more])
    return Table(
        "Warnings", f"What runs say against themselves, without any truth; of each estimator the first {NAMED} runs that warn, with the first reason. results.jsonl has all.",
        ["scenario", "estimator", "runs", "that warn", "why"], rows)


def anees_mean(part):
    """∞ where a covariance was not positive definite in some frame."""
    return "∞" if part.get("infinite") else number(part.get("mean"))


def consistency_table(summary):
    rows = []
    for group, cell in estimators_of(summary):
        for part, a in cell.get("anees", {}).items():
            if a["mean"] is not None or a["infinite"]:
                rows.append([group["name"], cell["label"], part.replace("_", " "), str(a["dof"]), anees_mean(a),
                             number(a["largest"]) if a["largest"] is not None else "∞", percent(a["inside"], 1)])
    return Table(
        "Consistency",
        "ANEES of each part of the state: mean over the poses of all runs (of landmarks, over the frames), maximum over the frames, and interval coverage as a share of the frames; of a batch, "
        "smoothed. For the camera, "
        "a frame is covered if its ANEES lies in the two-sided 95% interval of a consistent estimator. Landmarks of one run share the error of its camera. "
        "For them, a frame is covered if the 95% interval over runs contains 3. A wide interval does so easily, so read it with the mean. "
        "Velocities are of the landmarks labelled unknown or moving.",
        ["scenario", "estimator", "part", "expected", "mean", "maximum", "interval coverage"], rows)


def named(runs):
    began = lambda r: "" if r["began"] is None else f' from frame {r["began"]}'
    return "; ".join(f'seed {r["seed"]}: {infinite_or_number(r["mean"])}{began(r)}' for r in runs) or "none"


def infinite_or_number(nees):
    """A mean NEES is null where a covariance was not positive definite."""
    return "∞" if nees is None else number(nees)


def nees_by_run_table(summary):
    rows = []
    for group, cell, runs in estimators_with("nees_by_run", summary):
        rows.append([group["name"], cell["label"], str(runs["runs"])] + [infinite_or_number(q) for q in runs["quantiles"]] +
                    [f'{runs["exceeding"]} ({percent(runs["exceeding"], runs["runs"])})', named(runs["worst"])])
    return Table(
        "NEES by run",
        "The mean pose NEES of each run over its frames: 10%, 50% and 90% quantiles over the runs. A run exceeds when its mean is above the 99% quantile "
        "of a consistent estimator's with the run's own correlation from frame to frame. An ANEES above 6 may be every run's or that of a few: here it is seen. "
        "Worst: up to three such runs, with the frame from which the excess grows (Page's CUSUM).",
        ["scenario", "estimator", "runs", "10%", "median", "90%", "exceeding", "worst"], rows)


def counts_row(group, label, static, moving, decided="–"):
    row = [group, label]
    for counts in (static, moving):
        right, wrong, undecided = counts
        row += [str(right), str(wrong), str(undecided), percent(right, sum(counts)),
                percent(wrong + undecided, sum(counts))]
    return row + [decided]


def classification_table(summary):
    rows = []
    reference = summary.get("reference")
    if reference:
        rows.append(counts_row("published", reference["label"], reference["static"], reference["moving"]))
    for group, cell in estimators_of(summary):
        if sum(cell.get("static", [])) + sum(cell.get("moving", [])) > 0:
            rows.append(counts_row(group["name"], cell["label"], cell["static"], cell["moving"],
                                   with_interval(cell.get("median_frames_to_decision"))))
            rows.append(counts_row(group["name"], f'{cell["label"]}, observed at least ten times',
                                   cell["static_often_seen"], cell["moving_often_seen"]))
            if sum(cell["standing_by_frame"]) > 0:
                rows.append(counts_row(group["name"], f'{cell["label"]}, objects, by frame',
                                       cell["standing_by_frame"], cell["moving_by_frame"]))
    return Table(
        "Classification",
        "Landmarks over all runs, by true class. Misclassified: wrong or undecided. Many moving landmarks cross the image in a few frames, "
        "so the second row counts only landmarks observed at least ten times. Known landmarks are not counted, nor those of the first frame "
        "where they are static by rule (labels.births=static_first). Where objects stop, the third row counts frames in which they were measured: at rest "
        "(under static) and moving. Frames to decision: measurements until a label, median of a run.",
        ["scenario", "estimator"] + [f"{kind} {what}" for kind in ("static", "moving")
                                     for what in ("right", "wrong", "undecided", "right %", "misclassified %")] + ["frames to decision"], rows)


def pairs_table(summary):
    rows = []
    for group in summary["groups"]:
        for pair in group["pairs"]:
            difference = pair["position_rmse_difference_m"]
            rows.append([group["name"], f'{pair["a"]} - {pair["b"]}', str(pair["pairs"]), str(pair["wins_a"]),
                         str(pair["wins_b"]), str(pair["pairs"] - pair["wins_a"] - pair["wins_b"]), with_interval(difference),
                         number(pair.get("p_holm"), 2) if is_tested(pair) else "–"])
    return Table(
        "Paired comparisons",
        "Both estimators use the same measurements. Wins: pairs with the smaller position RMSE (of a batch, of the smoothed trajectory; ATE Sim(3) where the "
        "truth is measured); a diverged run loses. Difference: mean over the pairs in which both finished, with its 95% interval (Student's t, from five pairs on). "
        "p: of the paired t test, corrected for the number of pairs of all scenarios by Holm's method.",
        ["scenario", "pair", "pairs", "first wins", "second wins", "equal", "difference [m]", "p"], rows)


def metric_cell(metric, cell, which):
    if metric.pooled == "timing":
        return metrics.text(metric, cell.get("timing", {}).get(metric.key))
    return with_interval(cell.get(which + metric.key))


def lags_table(summary):
    """A row for each lag of the estimators that keep past poses."""
    rows = []
    for group, cell in estimators_of(summary):
        lines = lags.summary_lines(summary, cell)
        for lag in next(iter(lines.values())).lags if lines else []:
            estimates = [lines[quantity].of_lag(lag) if quantity in lines else None for quantity, _ in lags.QUANTITIES + lags.RATIOS]
            rows.append([group["name"], cell["label"], str(lag), *map(with_interval, estimates)])
    return Table("Poses at a lag", f"{lags.EXPLAINED} {lags.OVER_FILTERED} Brackets: {INTERVALS}.",
                 ["scenario", "estimator", "lag [frames]", *(name for _, name in lags.QUANTITIES), *(f"{name} over filtered" for _, name in lags.RATIOS)], rows)


def at_a_time(summary):
    """Runs at the same time share caches and memory: their times are longer."""
    jobs = summary.get("provenance", {}).get("jobs") or 0
    return f", made {jobs} at a time" if jobs > 1 else ""


TRAJECTORIES = {"filtered_": "", "last_scale_": "in the last scale: ", "smoothed_": "smoothed: "}


def metrics_table(summary):
    """A column for each metric that is pooled over runs and defined in some cell; the lags have a table of their own."""
    pooled = [m for m in metrics.read_table(summary["metrics"]).values() if m.pooled != "not" and not lags.is_of_lag(m.key)]
    columns = [(m, which) for m in pooled for which in (TRAJECTORIES if m.of == "trajectory" else ("",))]
    cells = [(group, cell) for group, cell in estimators_of(summary) if "anees" in cell]
    columns = [(m, which) for m, which in columns
               if any(metric_cell(m, cell, which) != metrics.UNDEFINED for _, cell in cells)]
    rows = [[group["name"], cell["label"]] + [metric_cell(m, cell, which) for m, which in columns] for group, cell in cells]
    names = [TRAJECTORIES.get(which, "") + metrics.heading(m) for m, which in columns]
    explained = " ".join(f"{m.name[:1].upper()}{m.name[1:]}: {m.caption}." for m in dict.fromkeys(m for m, _ in columns))
    return Table(
        "Metrics",
        f"Mean over the runs, or root mean square where the metric is an RMSE (ATE and RPE are), brackets: {INTERVALS}; times: median over the runs{at_a_time(summary)}. {explained}",
        ["scenario", "estimator"] + names, rows)


def plain(key):
    """What a column of a paper's table is called by default: the metric's name and unit."""
    return {"anees_pose": "ANEES pose", "anees_position": "ANEES position", "anees_rotation": "ANEES rotation"}.get(key, key)


def value_of(cell, key):
    """A number of a cell by its key: a pooled metric (of a batch, smoothed), a time, or the ANEES of a part."""
    which = "smoothed" if is_batch(cell) else "filtered"
    if key.startswith("anees_"):
        part = cell.get("anees", {}).get(key[6:])
        return part and {"value": part["mean"], "lower": part.get("lower"), "upper": part.get("upper")}
    if key in cell.get("timing", {}):
        return {"value": cell["timing"][key], "lower": None, "upper": None}
    return cell.get(f"{which}_{key}") or cell.get(key)


def competes(cell):
    return not cell["diverged"] and not cell.get("lost")


def best_of(key, values, table, aligned=False):
    """The best values of a column in one scenario; none where the metric has no best."""
    known = [v["value"] for v in values if v and v["value"] is not None]
    if len(set(known)) < 2:
        return None
    if key.startswith("anees_"):
        expected = 6 if key == "anees_pose" else 3
        return min(known, key=lambda v: abs(v - expected))
    better = table[key].better if metrics.is_ranked(table[key], aligned) else "neither"
    return min(known) if better == "smaller" else max(known) if better == "larger" else None


def paper_table(summary):
    """LaTeX of the columns that the study asks for, with its own labels and caption; the best of a scenario in bold. A cell with
    diverged runs says so and is not the best: its numbers are those of the other runs. Nor is one with failed runs."""
    wanted = summary["latex"]
    table = metrics.read_table(summary["metrics"])
    label = lambda name: escaped(wanted["labels"].get(name, name))
    head = [wanted["labels"].get(key) or (metrics.heading(table[key]) if key in table else plain(key)) for key in wanted["columns"]]
    rows = []
    for group in summary["groups"]:
        cells = [cell for cell in group["cells"] if not is_ideal(cell)]
        values = [[value_of(cell, key) for key in wanted["columns"]] for cell in cells]
        whole = [row for cell, row in zip(cells, values) if competes(cell)]
        aligned = any(cell.get("aligned") for cell in cells)
        best = [best_of(key, [row[i] for row in whole], table, aligned) for i, key in enumerate(wanted["columns"])]
        for cell, row in zip(cells, values):
            texts = [rf"\textbf{{{escaped(number(v['value']))}}}" if v and b is not None and v["value"] == b and competes(cell) else
                     escaped(number(v["value"]) if v else "–") for v, b in zip(row, best)]
            diverged = escaped(f' ({len(cell["diverged"])} of {cell["runs"]} diverged)') if cell["diverged"] else ""
            rows.append([label(group["name"]), label(cell["label"]) + diverged, *texts])
    tabular = booktabs("ll" + "r" * len(head), ["", "", *map(escaped, head)], rows)
    caption = rf"\caption{{{escaped(wanted['caption'])}}}" if wanted["caption"] else ""
    return "\n".join(filter(None, [r"\begin{table}", r"\centering", caption, tabular.rstrip(), r"\end{table}", ""])) + "\n"


def at_frames(failures):
    return "; ".join(f'seed {f["seed"]} at frame {f["frame"]}' for f in failures) or "none"


# Names of counts in journals of release 0.1, which a study may still be merged from.
OLD_COUNTS = {"frames": "frames_done", "offered": "measurements_offered", "admitted": "landmarks_admitted", "lost": "landmarks_lost"}


def measurements_table(summary):
    rows = []
    for group, cell, counts in estimators_with("coverage", summary):
        counts = {OLD_COUNTS.get(name, name): value for name, value in counts.items()}
        offered = counts["measurements_offered"]
        rows.append([group["name"], cell["label"], f'{counts["frames_done"]:.0f}', f"{offered:.0f}",
                     percent(counts["rejected"], offered), percent(counts["out_of_view"], offered),
                     f'{counts["landmarks_admitted"]:.0f}', f'{counts["landmarks_lost"]:.0f}',
                     at_frames(cell["diverged"]), at_frames(cell["lost"])])
    return Table(
        "Measurement counts", "Measurements of landmarks in the state, landmarks initialised and pruned, and the runs that diverged or failed.",
        ["scenario", "estimator", "frames", "measurements", "rejected", "out of view", "initialised", "pruned", "diverged", "failed"], rows)
