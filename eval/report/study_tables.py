"""The tables of a study: summary, every metric, consistency, classification as in the thesis's table 4.1, paired comparisons."""
import csv
import io
import math
from dataclasses import dataclass

import metrics


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


def is_ideal(cell):
    """An ideal covariance estimates nothing and is compared with nothing."""
    return cell["kind"] == "ideal_covariance"


def cells_of(summary):
    for group in summary["groups"]:
        for cell in group["cells"]:
            yield group, cell


def estimators_of(summary):
    return [(group, cell) for group, cell in cells_of(summary) if not is_ideal(cell)]


def ideal_row(group, cell):
    """The standard deviation of the position, root mean square over the frames."""
    sigma = [s for s in cell.get("per_frame", {}).get("position_sigma_m", []) if s is not None]
    stated = math.sqrt(sum(s * s for s in sigma) / len(sigma)) if sigma else None
    return [group["name"], cell["label"], str(cell["runs"]), str(len(cell["diverged"])), "–", number(stated)] + ["–"] * 10


def summary_table(summary):
    rows = []
    for group, cell in cells_of(summary):
        if is_ideal(cell):
            rows.append(ideal_row(group, cell))
            continue
        anees = cell.get("anees", {})
        pose = anees.get("pose", {})
        over_ideal = cell.get("rmse_over_ideal", {})
        timing = cell.get("timing", {})
        rows.append([
            group["name"], cell["label"], str(cell["runs"]), str(len(cell["diverged"])), str(len(cell["lost"])),
            with_interval(cell.get("filtered_position_rmse_m")), number(over_ideal.get("position")), with_interval(over_ideal.get("median")),
            with_interval(cell.get("filtered_rotation_rmse_deg")),
            anees_mean(pose), percent(pose["inside"], 1) if pose.get("inside") is not None else "–",
            anees_mean(anees.get("position", {})),
            with_interval(cell.get("nis_mean")), number((cell.get("nis_expected") or {}).get("value")),
            with_interval(cell.get("smoothed_position_rmse_m")),
            number(timing.get("frame_median_ms"))])
    return Table(
        "Summary",
        "Over all runs; brackets: 95% bootstrap intervals over runs (2000 resamples). A run has diverged when its state is no longer finite, "
        "and has failed when its position error exceeds both 1 m and 10% of the path length. RMSE is over the runs that did not diverge. "
        "RMSE over ideal sigma: ratio to the standard deviation of the ideal covariance, over all runs and for the median run. "
        "ANEES is the NEES averaged over runs and frames; a consistent estimator has 6 (pose) and 3 (position). Interval coverage: frames "
        "whose ANEES lies in its two-sided 95% interval. NIS is of the accepted measurements; expected NIS is that of a consistent estimator "
        "with the same gate. The row of an ideal covariance gives its standard deviation: that of an EKF linearised at the truth, "
        "with known labels, the fixed depth prior and no gate. It is no bound, and an estimator can have a smaller error. The filtered values of a batch are those of its front window; its own are the smoothed ones.",
        ["scenario", "estimator", "runs", "diverged", "failed", "position RMSE [m]", "RMSE over ideal sigma", "RMSE over ideal sigma, median run", "rotation RMSE [deg]",
         "ANEES pose", "interval coverage", "ANEES position", "NIS", "expected NIS", "smoothed RMSE [m]", "time per frame [ms]"], rows)


def anees_mean(part):
    """∞ where a covariance was not positive definite in some frame."""
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
        "ANEES of each part of the state: mean and maximum over the frames, and interval coverage as a share of the frames. For the camera, "
        "a frame is covered if its ANEES lies in the two-sided 95% interval of a consistent estimator. Landmarks of one run share the error of its camera. "
        "For them, a frame is covered if the 95% bootstrap interval over runs contains 3. A wide interval does so easily, so read it with the mean. "
        "Velocities are of the landmarks labelled unknown or moving.",
        ["scenario", "estimator", "part", "expected", "mean", "maximum", "interval coverage"], rows)


def named(runs):
    return "; ".join(f'seed {r["seed"]}: {number(r["mean"])} from frame {r["began"]}' for r in runs) or "none"


def nees_by_run_table(summary):
    rows = []
    for group, cell in estimators_of(summary):
        runs = cell.get("nees_by_run")
        if not runs:
            continue
        rows.append([group["name"], cell["label"], str(runs["runs"])] + [number(q) for q in runs["quantiles"]] +
                    [f'{runs["exceeding"]} ({percent(runs["exceeding"], runs["runs"])})', named(runs["worst"])])
    return Table(
        "NEES by run",
        "The mean pose NEES of each run over its frames: 10%, 50% and 90% quantiles over the runs. A run exceeds when its mean is above the 99% quantile "
        "of a consistent estimator's with the run's own correlation from frame to frame. An ANEES above 6 may be every run's or that of a few: here it is seen. "
        "Worst: up to three such runs, with the frame from which the excess grows (Page's CUSUM).",
        ["scenario", "estimator", "runs", "10%", "median", "90%", "exceeding", "worst"], rows)


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
            rows.append(counts_row(group["name"], f'{cell["label"]}, observed at least ten times',
                                   cell["static_often_seen"], cell["moving_often_seen"]))
            if sum(cell["standing_by_frame"]) > 0:
                rows.append(counts_row(group["name"], f'{cell["label"]}, objects, by frame',
                                       cell["standing_by_frame"], cell["moving_by_frame"]))
    return Table(
        "Classification",
        "Landmarks over all runs, by true class. Misclassified: wrong or undecided. Many moving landmarks cross the image in a few frames, "
        "so the second row counts only landmarks observed at least ten times. Known landmarks are not counted, nor those of the first frame "
        "where they are static by rule (labels.first_frame=static). Where objects stop, the third row counts frames in which they were measured: at rest "
        "(under static) and moving.",
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
        "Both estimators use the same measurements. Wins: pairs with the smaller position RMSE (for a batch, of the smoothed trajectory); a diverged run loses. "
        "Difference of the position RMSE: mean over the pairs in which both finished, 95% bootstrap interval (2000 resamples).",
        ["scenario", "pair", "pairs", "first wins", "second wins", "difference [m]"], rows)


def metric_cell(metric, cell, which):
    if metric.pooled == "timing":
        return metrics.text(metric, cell.get("timing", {}).get(metric.key))
    return with_interval(cell.get(which + metric.key))


def metrics_table(summary):
    """A column for each metric that is pooled over runs and defined in some cell."""
    pooled = [m for m in metrics.read_table(summary["metrics"]).values() if m.pooled != "not"]
    columns = [(m, which) for m in pooled for which in (("filtered_", "smoothed_") if m.of == "trajectory" else ("",))]
    cells = [(group, cell) for group, cell in estimators_of(summary) if "anees" in cell]
    columns = [(m, which) for m, which in columns
               if any(metric_cell(m, cell, which) != metrics.UNDEFINED for _, cell in cells)]
    rows = [[group["name"], cell["label"]] + [metric_cell(m, cell, which) for m, which in columns] for group, cell in cells]
    names = [metrics.heading(m) if which != "smoothed_" else f"smoothed: {metrics.heading(m)}" for m, which in columns]
    explained = " ".join(f"{m.name[:1].upper()}{m.name[1:]}: {m.caption}." for m in dict.fromkeys(m for m, _ in columns))
    return Table(
        "Metrics",
        f"Mean over the runs, or root mean square where the metric is an RMSE, with 95% bootstrap interval (2000 resamples); times: median over the runs. {explained}",
        ["scenario", "estimator"] + names, rows)


def at_frames(failures):
    return "; ".join(f'seed {f["seed"]} at frame {f["frame"]}' for f in failures) or "none"


# Names of counts in journals of release 0.1, which a study may still be merged from.
OLD_COUNTS = {"frames": "frames_done", "offered": "measurements_offered", "admitted": "landmarks_admitted", "lost": "landmarks_lost"}


def measurements_table(summary):
    rows = []
    for group, cell in estimators_of(summary):
        counts = cell.get("coverage")
        if not counts:
            continue
        counts = {OLD_COUNTS.get(name, name): value for name, value in counts.items()}
        offered = counts["measurements_offered"]
        rows.append([group["name"], cell["label"], f'{counts["frames_done"]:.0f}', f"{offered:.0f}",
                     percent(counts["rejected"], offered), percent(counts["out_of_view"], offered),
                     f'{counts["landmarks_admitted"]:.0f}', f'{counts["landmarks_lost"]:.0f}',
                     at_frames(cell["diverged"]), at_frames(cell["lost"])])
    return Table(
        "Measurement counts", "Measurements of landmarks in the state, landmarks initialised and pruned, and the runs that diverged or failed.",
        ["scenario", "estimator", "frames", "measurements", "rejected", "out of view", "initialised", "pruned", "diverged", "failed"], rows)
