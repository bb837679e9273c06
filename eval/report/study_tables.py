"""The tables of a study: summary, classification as the thesis's table 4.1, and paired comparisons."""
import csv
import io
import math
from dataclasses import dataclass

BOUND = "bound"


@dataclass
class Table:
    title: str
    caption: str
    head: list
    rows: list  # of texts, as the head

    def csv(self):
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.head)
        writer.writerows(self.rows)
        return text.getvalue()

    def latex(self):
        lines = [r"\begin{tabular}{" + "l" * 2 + "r" * (len(self.head) - 2) + "}", r"\hline",
                 " & ".join(map(escaped, self.head)) + r" \\", r"\hline"]
        lines += [" & ".join(map(escaped, row)) + r" \\" for row in self.rows]
        return "\n".join(lines + [r"\hline", r"\end{tabular}", ""])


def escaped(text):
    for character in "&%$#_{}":
        text = text.replace(character, "\\" + character)
    return text.replace("–", "--").replace("∞", r"$\infty$")


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
    return "–" if not whole else f"{100.0 * part / whole:.1f}%"


def cells_of(summary):
    for group in summary["groups"]:
        for cell in group["cells"]:
            yield group, cell


def estimators_of(summary):
    """Without the bounds, which estimate nothing."""
    return [(group, cell) for group, cell in cells_of(summary) if cell["estimator"] != BOUND]


def bound_row(group, cell):
    """What is stated: the standard deviation of the position, root mean square over the frames."""
    sigma = [s for s in cell.get("per_frame", {}).get("position_sigma_m", []) if s is not None]
    stated = math.sqrt(sum(s * s for s in sigma) / len(sigma)) if sigma else None
    return [group["name"], cell["label"], str(cell["runs"]), str(len(cell["diverged"])), "–", number(stated)] + ["–"] * 10


def summary_table(summary):
    rows = []
    for group, cell in cells_of(summary):
        if cell["estimator"] == BOUND:
            rows.append(bound_row(group, cell))
            continue
        anees = cell.get("anees", {})
        pose = anees.get("pose", {})
        bound = cell.get("rmse_over_bound", {})
        timing = cell.get("timing", {})
        rows.append([
            group["name"], cell["label"], str(cell["runs"]), str(len(cell["diverged"])), str(len(cell["lost"])),
            with_interval(cell.get("filtered_position_rmse_m")), number(bound.get("position")), with_interval(bound.get("median")),
            with_interval(cell.get("filtered_rotation_rmse_deg")),
            anees_mean(pose), percent(pose["inside"], 1) if pose.get("inside") is not None else "–",
            anees_mean(anees.get("position", {})),
            with_interval(cell.get("nis_mean")), number((cell.get("nis_expected") or {}).get("value")),
            with_interval(cell.get("smoothed_position_rmse_m")),
            number(timing.get("frame_median_ms"))])
    return Table(
        "Summary",
        "Over all runs; brackets are 95% bootstrap intervals over runs. A batch's filtered values are its front window's: its own are the smoothed ones. A run is diverged when its numbers are none any "
        "more, lost when its error once exceeds a metre and a tenth of the path. ANEES is averaged over frames too (6 and 3 are "
        "right); inside: the part of the frames whose ANEES lies in its two-sided 95% interval. RMSE are of runs that did not diverge. "
        "A bound's row gives the standard deviation of the posterior Cramér-Rao bound, for known labels and the same policy of births and "
        "deaths; a biased estimator may seem to beat it. NIS is of the measurements that pass the gate, expected: what a consistent estimator would have.",
        ["scenario", "estimator", "runs", "diverged", "lost", "position RMSE [m]", "over the bound", "the same, median run", "rotation RMSE [deg]",
         "ANEES pose", "inside", "ANEES position", "NIS", "NIS expected", "smoothed RMSE [m]", "frame [ms]"], rows)


def anees_mean(part):
    """∞ where a covariance was none in some frame."""
    return "∞" if part.get("infinite") else number(part.get("mean"))


def consistency_table(summary):
    rows = []
    for group, cell in estimators_of(summary):
        smoothed = {f"smoothed {part}": a for part, a in cell.get("smoothed_anees", {}).items()}
        for part, a in {**cell.get("anees", {}), **smoothed}.items():
            if a["mean"] is not None or a["infinite"]:
                rows.append([group["name"], cell["label"], part.replace("_", " "), str(a["dof"]), anees_mean(a),
                             number(a["largest"]) if a["largest"] is not None else "∞", percent(a["inside"], 1)])
    return Table(
        "Consistency",
        "ANEES of each part of the state: mean and largest over the frames, and the part of the frames that are inside. Of the camera: "
        "whose ANEES lies in the two-sided 95% interval of a consistent estimator. Of landmarks, which share their camera's error: "
        "whose 95% bootstrap interval over runs holds 3, which a wide interval does easily: read it beside the mean. Velocities are of the "
        "landmarks that are unknown or moving; one that is labelled static has none.",
        ["scenario", "estimator", "part", "right is", "mean", "largest", "inside"], rows)


def counts_row(group, label, static, moving):
    row = [group, label]
    for counts in (static, moving):
        right, wrong, undecided = counts
        row += [str(right), str(wrong), str(undecided), percent(right, sum(counts)),
                percent(wrong + undecided, sum(counts))]
    return row


def classification_table(summary):
    rows = []
    reference = summary.get("reference")
    if reference:
        rows.append(counts_row("published", reference["label"], reference["static"], reference["moving"]))
    for group, cell in estimators_of(summary):
        if "static" in cell:
            rows.append(counts_row(group["name"], cell["label"], cell["static"], cell["moving"]))
            rows.append(counts_row(group["name"], f'{cell["label"]}, seen 10 times or more',
                                   cell["static_often_seen"], cell["moving_often_seen"]))
            if sum(cell["standing_by_frame"]) > 0:
                rows.append(counts_row(group["name"], f'{cell["label"]}, objects frame by frame',
                                       cell["standing_by_frame"], cell["moving_by_frame"]))
    return Table(
        "Classification",
        "Landmarks over all runs, by their true class. Right, wrong, undecided; misclassified are the wrong and the undecided "
        "(thesis 4.1.1). Many movers cross the image in a few frames: the second row of each is of landmarks measured at least "
        "ten times. Those of the first frame are static by rule and not counted, nor are known ones. Where objects stop, the third row is of "
        "the frames in which they were measured standing (under static) and moving.",
        ["scenario", "estimator"] + [f"{kind} {what}" for kind in ("static", "moving")
                                     for what in ("right", "wrong", "undecided", "right %", "misclassified %")], rows)


def pairs_table(summary):
    rows = []
    for group in summary["groups"]:
        for pair in group["pairs"]:
            difference = pair["position_rmse_difference_m"]
            rows.append([group["name"], f'{pair["a"]} - {pair["b"]}', str(pair["pairs"]), str(pair["wins_a"]),
                         str(pair["wins_b"]), with_interval(difference)])
    return Table(
        "Paired comparisons",
        "The same measurements for both. Wins: pairs with the smaller position RMSE (of a batch: smoothed); a diverged run loses. Difference of the "
        "position RMSE, mean over the pairs in which both finished, with its 95% bootstrap interval.",
        ["scenario", "pair", "pairs", "first wins", "second wins", "difference [m]"], rows)


def coverage_table(summary):
    rows = []
    for group, cell in estimators_of(summary):
        coverage = cell.get("coverage")
        if not coverage:
            continue
        offered = coverage["offered"]
        rows.append([group["name"], cell["label"], f'{coverage["frames"]:.0f}', f"{offered:.0f}",
                     percent(coverage["rejected"], offered), percent(coverage["out_of_view"], offered),
                     f'{coverage["admitted"]:.0f}', f'{coverage["lost"]:.0f}',
                     "; ".join(f'seed {d["seed"]} at frame {d["frame"]}' for d in cell["diverged"]) or "none",
                     "; ".join(f'seed {d["seed"]} at frame {d["frame"]}' for d in cell["lost"]) or "none"])
    return Table(
        "Coverage", "What was used, what was not, and which runs went wrong. Measurements of landmarks in the state.",
        ["scenario", "estimator", "frames", "measurements", "rejected", "out of view", "born", "given up", "diverged", "lost"], rows)
