"""The comparison in words, computed from its numbers. Each finding is (heading, sentences).

One run of each estimator is a description and no proof of a difference.
"""
import math


SAME = 0.03  # a relative difference below this is not reported

# Mean NEES over its degrees of freedom, over the frames of a run: what to call it.
CONSERVATIVE, OVERCONFIDENT = 0.67, 1.5


def error(comparison):
    """Of a run: the error that it is compared by."""
    return lambda run: run.value(comparison.error_key)


def error_name(comparison):
    return "ATE Sim(3)" if comparison.aligned else "position RMSE"


def alignment_of(comparison):
    if comparison.aligned:
        return "after similarity alignment"
    return "as aligned" if comparison.moved else "without alignment"


def failure_bound(aligned):
    """What the error of a failed run exceeds."""
    return ("a tenth of the path or a third of the largest distance from its start, after alignment" if aligned else
            "a tenth of the path so far, and a metre or a tenth of the whole path, whichever is less")


WHY_ALIGNED = ("The truth is measured, and images of one camera tell neither frame nor scale: "
               "errors here are after similarity alignment, and the scale stands beside them.")


def moved(comparison):
    """How runs were aligned before they were judged (`--align`)."""
    of_note = {}
    for run in comparison.runs:
        if run.alignment:
            of_note.setdefault(run.alignment["note"], []).append(run.pooled if comparison.pooled else run.name)
    return [("Aligned", [f"{listed(list(dict.fromkeys(names)))}: {note}." for note, names in of_note.items()])] if of_note else []


def nees_ratio(run):
    return run.value("nees.pose.mean_over_dof")


def frame_ms(run):
    return run.value("frame_median_ms")


def ranked(runs, measure):
    """(value, run) of the runs where it is defined, smallest first."""
    return sorted(((measure(run), run) for run in runs if measure(run) is not None),
                  key=lambda pair: pair[0])


def listed(words):
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


def times(ratio):
    return f"{ratio:.2g} times" if ratio < 10 else f"{ratio:.0f} times"


def milliseconds(value):
    return f"{value:.3g} ms" if value < 1000.0 else f"{value:.0f} ms"


def metres(value):
    return f"{value:.3g} m"


def divergence(comparison):
    failed = [run for run in comparison.runs if run.divergence is not None]
    sentences = [f"{run.name} diverged at frame {run.divergence['frame']} ({run.divergence['reason']}); "
                 + ("without a solution, nothing of its path is judged." if run.kind == "batch" else "its metrics cover only the frames before.")
                 for run in failed]
    return [("Diverged", sentences)] if failed else []


def failure(comparison):
    failed = [run for run in comparison.runs if run.failed_at is not None]
    bound = failure_bound(comparison.aligned)
    sentences = [f"{run.name} has poses of {100 * run.metric(run.judged, 'accuracy', 'coverage'):.2g}% of the frames: a failed run." if few_poses(run) else
                 f"{run.name} failed at frame {run.failed_at}: its error exceeds {bound}." for run in failed]
    return [("Failed", sentences)] if sentences else []


def few_poses(run):
    """Whether fewer than half of the frames have a pose, which no error can make up for."""
    coverage = run.metric(run.judged, "accuracy", "coverage")
    return coverage is not None and coverage < 0.5


def warnings_of(run):
    """A warning about a whole run has no frame."""
    return [run.name + (f", from frame {warning['frame']}" if warning["frame"] is not None else "") + f": {warning['reason']}." for warning in run.warnings]


def warned(comparison):
    sentences = [sentence for run in comparison.runs for sentence in warnings_of(run)]
    return [("Warned", sentences)] if sentences else []


def with_its_settings(run, landmark):
    """`ekf (ekf.iterations = 3)` of the name `ekf, ekf.iterations = 3 · scaled_velocity`."""
    estimator, _, settings = run.name.removesuffix(f" · {landmark}").partition(", ")
    return f"{estimator} ({settings})" if settings else estimator


def within_landmark_model(rows):
    """The same landmark model under different estimators: the question this program is for."""
    sentences = []
    for landmark in dict.fromkeys(run.landmark for _, run in rows if run.landmark not in ("", "-")):
        same = [(value, run) for value, run in rows if run.landmark == landmark]
        of_each = {}  # estimator to its best, which comes first
        for value, run in same:
            of_each.setdefault(run.estimator, (value, run))
        if len(of_each) < 2:
            continue
        several = len(of_each) < len(same)
        (best, winner), *_, (worst, loser) = of_each.values()
        names = [with_its_settings(run, landmark) if several else run.estimator for run in (winner, loser)]
        end = ", each with the best of its settings." if several else "."
        gain = 1.0 - best / worst if worst > 0.0 else 0.0
        sentences.append(
            f"With {landmark}, {names[0]} and {names[1]} are equally accurate{end}"
            if gain < SAME else
            f"With {landmark}, the error of {names[0]} is {100 * gain:.0f}% smaller than that of {names[1]}{end}")
    return sentences


def unmeasured(runs):
    """Whether no run used a single measurement: then no estimator was compared. Of one made elsewhere nobody knows."""
    if any(run.kind == "foreign" for run in runs):
        return False
    counts = [run.metric("coverage", name) for run in runs for name in ("accepted", "landmarks_admitted")]
    return all(count == 0 for count in counts)


def apart(coverages):
    """Whether runs were judged over frames so different that their errors do not compare."""
    known = [c for c in coverages if c is not None]
    return bool(known) and max(known) - min(known) > 0.1


def accuracy(comparison, runs):
    if unmeasured(runs):
        return [("Accuracy", ["Not judged: no run used any measurement."])]
    runs = [run for run in runs if run.competes]
    if not runs:
        return [("Accuracy", ["Not compared: every run failed."])]
    rows = ranked(runs, error(comparison))
    why = [WHY_ALIGNED] if comparison.aligned else []
    if not rows:
        return [("Accuracy", ["Not known: the sequence has no ground truth."
                              if not comparison.has_truth else "No run has a defined accuracy."])]
    value, best = rows[0]
    if len(rows) == 1:
        article = "an" if comparison.aligned else "a"
        return [("Accuracy", [f"{best.name} has {article} {error_name(comparison)} of {metres(value)}, {alignment_of(comparison)}.", *why])]
    coverages = [run.metric(run.judged, "accuracy", "coverage") for _, run in rows]
    if apart(coverages):
        each = "; ".join(f"{run.name} {metres(v)}, of {100 * c:.0f}% of the frames" for (v, run), c in zip(rows, coverages) if c is not None)
        return [("Accuracy", [f"Not compared, as the frames that have poses differ. {error_name(comparison)[:1].upper()}{error_name(comparison)[1:]}, {alignment_of(comparison)}: {each}.", *why])]
    others = ", ".join(f"{run.name} {metres(v)}" for v, run in rows[1:])
    equal = [run.name for v, run in rows if value >= (1.0 - SAME) * v]
    which = f"{best.name} is the most accurate" if len(equal) == 1 else f"{listed(equal)} are equally accurate, within {100 * SAME:.0f}%"
    return [("Accuracy", [f"{which}: {error_name(comparison)}{' of ' + best.name if len(equal) > 1 else ''} {metres(value)}, {alignment_of(comparison)} "
                          f"({others}).", *within_landmark_model(rows), *why])]


FEWEST_JUDGED = 12  # poses: the mean NEES of fewer, were they independent, is not known to a third with 95%


def judged(ratio):
    if ratio > OVERCONFIDENT:
        return "overconfident"
    return "conservative" if ratio < CONSERVATIVE else "near what is expected"


def consistency_of(run):
    ratio = nees_ratio(run)
    failures = run.value("nees.pose.covariances_not_positive_definite") or 0
    if failures:
        return f"{run.name} has no mean NEES: {failures} of its covariances {'is' if failures == 1 else 'are'} not positive definite."
    coverage = run.value("nees.pose.fraction_inside")
    poses = run.metric(run.judged, "nees", "pose", "used")
    if poses is not None and poses < FEWEST_JUDGED:
        return f"{run.name} has a mean pose NEES of {6 * ratio:.3g} (6 expected) over {poses} poses: too few for a verdict."
    if run.alignment and not run.alignment["verdict"]:
        return f"{run.name} has a mean pose NEES of {6 * ratio:.3g}: no verdict, as it was aligned (above)."
    text = (f"{run.name} is {judged(ratio)}: mean pose NEES {6 * ratio:.3g} (6 expected)")
    if coverage is not None:
        text += f", {100 * coverage:.0f}% of the frames in the 95% interval"
    if judged(ratio) == "overconfident":
        text += f"; its errors are about {times(math.sqrt(ratio))} its stated standard deviation"
    return text + "."


def consistency(comparison, runs):
    known = [run for run in runs
             if nees_ratio(run) is not None
             or run.value("nees.pose.covariances_not_positive_definite")]
    if not known:
        reasons = {run.metric(run.judged, "nees_reason") for run in runs} - {None, ""}
        reason = listed(sorted(reasons)) if reasons else "no run has both a covariance and a truth"
        return [("Consistency", [f"Not judged: {reason}."])]
    # That a lost run is as far off as it says is no praise: it may be so of what is left.
    known = [run for run in known if run.competes or judged(nees_ratio(run) or math.inf) == "overconfident"]
    known.sort(key=lambda run: nees_ratio(run) or math.inf)
    return [("Consistency", [consistency_of(run) for run in known])] if known else []


def right_ratio(run):
    """Share of the landmarks with a known truth that carry the right label; both classes count."""
    counts = [run.metric("classification", kind) or {} for kind in ("static", "moving")]
    total = sum(c.get(name) or 0 for c in counts for name in ("right", "wrong", "undecided"))
    return sum(c.get("right") or 0 for c in counts) / total if total else None


def labels(runs):
    rows = ranked(runs, right_ratio)
    if not rows:
        return []
    (least, worst), (most, best) = rows[0], rows[-1]
    text = f"{best.name} labels {100 * most:.0f}% of the landmarks correctly"
    if most - least >= SAME:
        text += f", {worst.name} {100 * least:.0f}%"
    elif len(rows) > 1:
        text += "; the other differs" if len(rows) == 2 else "; the others differ"
        text += f" by less than {100 * SAME:.0f} percentage points"
    return [("Labels", [text + "."])]


def camera_rate(comparison):
    """Frames a second of the sequence itself, from the longest run's series."""
    spans = [(times_[-1] - times_[0]) / (frames[-1] - frames[0])
             for run in comparison.runs
             for times_, frames in [(run.series.get("timestamp", []), run.series.get("frame", []))]
             if len(frames) > 1 and len(times_) == len(frames)]
    return 1.0 / min(spans) if spans and min(spans) > 0.0 else None


def cost(comparison, runs):
    rows = ranked(runs, frame_ms)
    if not rows:
        return []
    fastest, quick = rows[0]
    slowest, slow = rows[-1]
    if len(rows) == 1:
        sentences = [f"{quick.name} takes {milliseconds(fastest)} per frame."]
    elif slowest <= (1.0 + SAME) * fastest:
        sentences = [f"All take about {milliseconds(slowest)} per frame."]
    else:
        more = f", {times(slowest / fastest)} as long" if fastest > 0.0 else ""
        sentences = [f"{quick.name} is the fastest with {milliseconds(fastest)} per frame, "
                     f"{slow.name} the slowest with {milliseconds(slowest)}{more}."]
    rate = camera_rate(comparison)
    if rate is not None:
        late = [run.name for value, run in rows if value > 1000.0 / rate or run.kind == "batch"]
        sentences.append(
            f"At the camera's {rate:.3g} Hz ({1000.0 / rate:.3g} ms per frame) " +
            (f"{listed(late)} cannot run in real time." if late else "all run in real time." if len(rows) > 1
             else "it runs in real time."))
    return [("Cost", sentences)]


def findings(comparison):
    done = [run for run in comparison.runs if run.divergence is None]
    if not done:
        return [*divergence(comparison), *warned(comparison)]
    return [*divergence(comparison), *failure(comparison), *warned(comparison), *moved(comparison), *accuracy(comparison, done), *consistency(comparison, done),
            *labels(done), *cost(comparison, done)]
