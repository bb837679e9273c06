"""The comparison in words where estimators have several runs, each put together over them."""
from ..judge.intervals import FEW
from ..judge.paired import LEVEL, better
from .verdict import WHY_ALIGNED, alignment_of, apart, error_name, failure_bound, moved, warnings_of

# Of an ANEES whose interval holds what is expected: neither consistent nor not.
NOT_DECIDED = "neither shown consistent nor inconsistent"


def anees_class(part):
    """How an ANEES stands to its expected value, where it has an interval over runs. A covariance that is not positive definite
    needs none."""
    if part.get("infinite"):
        return "over"
    if part.get("no_verdict"):
        return ""
    low, high, dof = part.get("lower"), part.get("upper"), part.get("dof")
    if low is None or high is None or low <= dof <= high:
        return ""
    return "over" if low > dof else "under"


def difference_of(pair):
    return pair["difference"] if "difference" in pair else pair["position_rmse_difference_m"]


def is_tested(pair):
    return difference_of(pair)["lower"] is not None


def more_accurate(pair):
    """"a", "b" or None where that is not decided."""
    return better({**pair, "difference": difference_of(pair)}, pair.get("p_holm", 1.0)) if is_tested(pair) else None


def ordered_pairs(decided):
    """`a than b and c; b than c`, of (winner, loser, remark)."""
    of_winner = {}
    for winner, loser, remark in decided:
        of_winner.setdefault(winner, []).append(f"{loser}{remark}")
    return "; ".join(f"{winner} than {', '.join(losers)}" for winner, losers in of_winner.items())


def decided_sentence(decided, tested):
    """All decided pairs; `tested` is the number of pairs for which the p values are corrected."""
    if not tested:
        return f"No difference is tested: {FEW}."
    how = f"paired t tests, {100 * LEVEL:.0f}%" + (f" over all {tested} pairs by Holm's correction" if tested > 1 else "")
    return f"More accurate ({how}): {ordered_pairs(decided)}." if decided else f"No difference is decided ({how})."


def between(estimate, unit=" m"):
    """value [lower, upper]"""
    if estimate["lower"] is None:
        return f"{estimate['value']:.3g}{unit}"
    return f"{estimate['value']:.3g}{unit} [{estimate['lower']:.3g}, {estimate['upper']:.3g}]"


def failed_sentences(rows, aligned):
    """Of rows (label, runs, failed, diverged); the bound once, behind the numbers."""
    sentences = [f"{label}: {failed} of {runs} runs failed, {diverged} diverged." for label, runs, failed, diverged in rows if failed or diverged]
    return [("Failed", [*sentences, f"A run has failed when its error is above {failure_bound(aligned)}."])] if sentences else []


def warned(comparison):
    """The number of runs that warn, and the reasons of the first of them."""
    sentences = []
    for e in comparison.estimators:
        runs = [run for run in comparison.runs if run.pooled == e.name and (run.warnings or run.divergence)]
        if runs:
            sentences.append(f"{e.name}: {len(runs)} of {e.runs} runs warn{' or diverged' if e.diverged else ''}. {' '.join(warnings_of(runs[0]))}".strip())
    return [("Warned", sentences)] if sentences else []


def remark_of(pair, which):
    """In how many pairs of runs the better one is better."""
    d = pair["difference"]
    both = "" if d["runs"] == pair["pairs"] else f", difference of the {d['runs']} in which both finished"
    return f" (in {pair[f'wins_{which}']} of {pair['pairs']} runs{both})"


def differences(comparison):
    coverage = {e.name: (e.values.get("coverage") or {}).get("value") for e in comparison.estimators}
    sentences, decided = [], []
    for pair in comparison.pairs:
        if apart([coverage.get(pair["a"]), coverage.get(pair["b"])]):
            sentences.append(f"{pair['a']} and {pair['b']} are not compared: they have poses of {100 * coverage[pair['a']]:.0f}% and {100 * coverage[pair['b']]:.0f}% of the frames.")
        elif which := more_accurate(pair):
            decided.append((pair[which], pair["b" if which == "a" else "a"], remark_of(pair, which)))
    return [*sentences, decided_sentence(decided, sum(map(is_tested, comparison.pairs)))] if comparison.pairs else []


def accuracy(comparison):
    known = sorted((e for e in comparison.estimators if e.failed + e.diverged < e.runs and (e.values.get(comparison.error_key) or {}).get("value") is not None),
                   key=lambda e: e.values[comparison.error_key]["value"])
    if not known:
        return [("Accuracy", ["Not known: no run has a defined error, or every one failed."])]
    few = "" if all(e.values[comparison.error_key]["lower"] is not None for e in known) else f" ({FEW} have no interval)"
    sentence = (f"{error_name(comparison)[:1].upper()}{error_name(comparison)[1:]} {alignment_of(comparison)}, 95% interval over runs{few}: "
                + "; ".join(f"{e.name} {between(e.values[comparison.error_key])}" for e in known) + ".")
    return [("Accuracy", [sentence, *differences(comparison), *([WHY_ALIGNED] if comparison.aligned else [])])]


def consistency_of(e):
    part, a = next(((part, e.anees[part]) for part in ("pose", "position", "rotation") if part in e.anees), (None, None))
    if a is None:
        return None
    if a["infinite"] or a["mean"] is None:
        return f"{e.name} has no ANEES: some of its covariances are not positive definite."
    text = f"ANEES of the {part} {between({'value': a['mean'], **{k: a[k] for k in ('lower', 'upper')}}, '')} ({a['dof']} expected)"
    if a.get("no_verdict"):
        return f"{e.name}: {text}: no verdict, as runs were aligned (above)."
    if a["lower"] is None:
        return f"{e.name}: {text}; {FEW} decide nothing."
    word = {"over": "overconfident", "under": "conservative", "": NOT_DECIDED}[anees_class(a)]
    return f"{e.name} is {word}: {text}, {100 * a['inside']:.0f}% of the frames inside."


def findings(comparison):
    sentences = [s for s in map(consistency_of, comparison.estimators) if s]
    return [*failed_sentences([(e.name, e.runs, e.failed, e.diverged) for e in comparison.estimators], comparison.aligned), *warned(comparison), *moved(comparison), *accuracy(comparison),
            ("Consistency", sentences or ["Not judged: the truth is not exact, or a covariance is missing."])]
