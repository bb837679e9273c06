"""The comparison in words where estimators have several runs, each put together over them."""
from verdict import WHY_ALIGNED, alignment_of, apart, error_name, failure_bound, warnings_of

FEWEST = 10  # runs from which an interval over runs decides


def decides(part):
    """Whether its interval is over enough runs: that of fewer is too narrow. A covariance that is not positive definite needs none."""
    return bool(part.get("infinite")) or part.get("runs", 0) >= FEWEST


def anees_class(part):
    """How an ANEES stands to its expected value, where it has an interval over runs."""
    if part.get("infinite"):
        return "over"
    low, high, dof = part.get("lower"), part.get("upper"), part.get("dof")
    if not decides(part) or low is None or high is None or low <= dof <= high:
        return ""
    return "over" if low > dof else "under"


def more_accurate(pair, difference):
    """"a", "b" or None where that is not decided. A diverged run has no difference, but it has lost: where some are, wins must agree."""
    if difference["lower"] is None or difference["runs"] < FEWEST or difference["lower"] <= 0.0 <= difference["upper"]:
        return None
    better, worse = "ab" if difference["upper"] < 0.0 else "ba"
    agree = difference["runs"] == pair["pairs"] or pair[f"wins_{better}"] > pair[f"wins_{worse}"]
    return better if agree else None


def between(estimate, unit=" m"):
    """value [lower, upper]"""
    if estimate["lower"] is None:
        return f"{estimate['value']:.3g}{unit}"
    return f"{estimate['value']:.3g}{unit} [{estimate['lower']:.3g}, {estimate['upper']:.3g}]"


def failures(estimators, aligned):
    sentences = [f"{e.name}: {e.failed} of {e.runs} runs failed (error above {failure_bound(aligned)}), {e.diverged} diverged."
                 for e in estimators if e.failed or e.diverged]
    return [("Failed", sentences)] if sentences else []


def warned(comparison):
    """The number of runs that warn, and the reasons of the first of them."""
    sentences = []
    for e in comparison.estimators:
        runs = [run for run in comparison.runs if run.pooled == e.name and (run.warnings or run.divergence)]
        if runs:
            sentences.append(f"{e.name}: {len(runs)} of {e.runs} runs warn{' or diverged' if e.diverged else ''}. {' '.join(warnings_of(runs[0]))}".strip())
    return [("Warned", sentences)] if sentences else []


def accuracy(comparison):
    known = sorted((e for e in comparison.estimators if (e.values.get(comparison.error_key) or {}).get("value") is not None),
                   key=lambda e: e.values[comparison.error_key]["value"])
    if not known:
        return [("Accuracy", ["Not known: no run has a defined error."])]
    sentences = [f"{error_name(comparison)[:1].upper()}{error_name(comparison)[1:]} {alignment_of(comparison)}, 95% interval over runs: " + "; ".join(
        f"{e.name} {between(e.values[comparison.error_key])}" for e in known) + "."]
    coverage = {e.name: (e.values.get("coverage") or {}).get("value") for e in comparison.estimators}
    for pair in comparison.pairs:
        d = pair["difference"]
        if apart([coverage.get(pair["a"]), coverage.get(pair["b"])]):
            sentences.append(f"{pair['a']} and {pair['b']} are not compared: they have poses of {100 * coverage[pair['a']]:.0f}% and {100 * coverage[pair['b']]:.0f}% of the frames.")
            continue
        which = more_accurate(pair, d)
        if which is None:
            continue
        better, worse, wins = pair[which], pair["b" if which == "a" else "a"], pair[f"wins_{which}"]
        both = "" if d["runs"] == pair["pairs"] else f", by the {d['runs']} in which both finished"
        sentences.append(f"{better} is more accurate than {worse}: better in {wins} of {pair['pairs']} pairs of runs{both}.")
    return [("Accuracy", sentences + ([WHY_ALIGNED] if comparison.aligned else []))]


def consistency_of(e):
    part, a = next(((part, e.anees[part]) for part in ("pose", "position", "rotation") if part in e.anees), (None, None))
    if a is None:
        return None
    if a["infinite"] or a["mean"] is None:
        return f"{e.name} has no ANEES: some of its covariances are not positive definite."
    text = f"ANEES of the {part} {between({'value': a['mean'], **{k: a[k] for k in ('lower', 'upper')}}, '')} ({a['dof']} expected)"
    if a["lower"] is None or e.runs < FEWEST:
        return f"{e.name}: {text}; {e.runs} run{'s decide' if e.runs > 1 else ' decides'} nothing."
    word = "overconfident" if a["lower"] > a["dof"] else "conservative" if a["upper"] < a["dof"] else "consistent within its interval"
    return f"{e.name} is {word}: {text}, {100 * a['inside']:.0f}% of the frames inside."


def findings(comparison):
    sentences = [s for s in map(consistency_of, comparison.estimators) if s]
    return [*failures(comparison.estimators, comparison.aligned), *warned(comparison), *accuracy(comparison),
            ("Consistency", sentences or ["Not judged: the truth is not exact, or a covariance is missing."])]
