"""A study in words, computed from its summary. Each finding is (heading, sentences)."""
from . import ranking
from ..judge.intervals import FEW
from .pooled_verdict import NOT_DECIDED, anees_class, between, decided_sentence, failed_sentences, is_tested, more_accurate
from .study_tables import error_name, error_of, estimators_of

MOST_GROUPS = 4  # that are named one by one
POSE = 6  # degrees of freedom


def labels(summary):
    return list(dict.fromkeys(cell["label"] for _, cell in estimators_of(summary)))


def cells_called(summary, label):
    return [(group, cell) for group, cell in estimators_of(summary) if cell["label"] == label]


def failures(summary):
    rows, aligned = [], False
    for label in labels(summary):
        cells = [cell for _, cell in cells_called(summary, label)]
        rows.append((label, *(sum(n) for n in zip(*((c["runs"], len(c["lost"]), len(c["diverged"])) for c in cells)))))
        aligned = aligned or any(c.get("aligned") for c in cells)
    return failed_sentences(rows, aligned)


def warned(summary):
    sentences = []
    for label in labels(summary):
        cells = [cell for _, cell in cells_called(summary, label)]
        warning = sum(len(cell.get("warnings") or []) for cell in cells)
        if warning:
            sentences.append(f"{label}: {warning} of {sum(c['runs'] for c in cells)} runs warn, those that diverged aside; why is in the table Warnings.")
    return [("Warned", sentences)] if sentences else []


def known_errors(group, summary):
    """(estimate, label), the smallest error first."""
    found = [(error_of(cell), cell["label"]) for g, cell in estimators_of(summary) if g is group]
    return sorted(((e, label) for e, label in found if e and e["value"] is not None), key=lambda pair: pair[0]["value"])


def accuracy(summary):
    ordered = [(group, known_errors(group, summary)) for group in summary["groups"]]
    ordered = [(group, errors) for group, errors in ordered if errors]
    if not ordered:
        return [("Accuracy", ["No run has a defined error."])]
    if len(ordered) <= MOST_GROUPS:
        sentences = [f'{group["name"]}, {error_name(group)}: ' + "; ".join(f"{label} {between(e)}" for e, label in errors) + "." for group, errors in ordered]
    else:
        first = [errors[0][1] for _, errors in ordered]
        sentences = ["Smallest error: " + ", ".join(
            f"{label} in {first.count(label)}" for label in sorted(dict.fromkeys(first), key=first.count, reverse=True)) + f" of {len(ordered)} scenarios."]
    if any(e["lower"] is None for _, errors in ordered for e, _ in errors):
        sentences.append(f"{FEW[:1].upper()}{FEW[1:]} have no interval.")
    measured = [group["name"] for group, _ in ordered if any(cell.get("aligned") for cell in group["cells"])]
    if measured:
        sentences.append("Where the truth is measured, errors are after similarity alignment (ATE Sim(3)), as images of one camera tell neither frame nor scale.")
    return [("Accuracy", sentences)]


def pairs(summary):
    """Every decided pair, with the number of scenarios in which it is decided."""
    tested = [pair for group in summary["groups"] for pair in group["pairs"] if is_tested(pair)]
    wins, scenarios = {}, {}
    for pair in tested:
        a, b = pair["a"], pair["b"]
        for order in ((a, b), (b, a)):
            scenarios[order] = scenarios.get(order, 0) + 1
        if which := more_accurate(pair):
            order = (a, b) if which == "a" else (b, a)
            wins[order] = wins.get(order, 0) + 1
    decided = [(a, b, f" (in {n} of {scenarios[a, b]} scenarios)" if scenarios[a, b] > 1 else "") for (a, b), n in wins.items()]
    return [("Differences", [decided_sentence(decided, len(tested))])]


def range_of(values):
    low, high = min(values), max(values)
    return f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g} to {high:.3g}"


def consistency_of(summary, label):
    parts = [cell["anees"]["pose"] for _, cell in cells_called(summary, label) if "pose" in cell.get("anees", {})]
    means = [p["mean"] for p in parts if p["mean"] is not None]
    if not parts:
        return None
    if len(means) < len(parts):
        return f"{label} has no ANEES: some of its covariances are not positive definite."
    interval = between({"value": means[0], "lower": parts[0].get("lower"), "upper": parts[0].get("upper")}, "") if len(parts) == 1 else range_of(means)
    text = f"ANEES of the pose {interval} ({POSE} expected), {range_of([100 * p['inside'] for p in parts])}% of the frames inside"
    judged = [p for p in parts if p.get("lower") is not None]
    if not judged:
        return f"{label}: {text}; {FEW} decide nothing."
    classes = [anees_class(p) for p in judged]
    words = [(word, classes.count(name)) for word, name in (("overconfident", "over"), ("conservative", "under")) if name in classes]
    where = "" if len(parts) == 1 else "in {} of " + f"{len(judged)} scenarios"
    few = f"; {len(parts) - len(judged)} with {FEW} decide nothing" if len(judged) < len(parts) else ""
    word = " and ".join(f"{word} {where.format(n)}".strip() for word, n in words) or NOT_DECIDED
    return f"{label} is {word}: {text}{few}."


def consistency(summary):
    sentences = [s for s in (consistency_of(summary, label) for label in labels(summary)) if s]
    return [("Consistency", sentences or ["Not judged: the truth is not exact, or a covariance is missing."])]


def recommendation(summary):
    text = ranking.sentence(ranking.ranking(summary)) if "ranking" in summary["figures"] else ""
    return [("Ranking", [text])] if text else []


def findings(summary):
    return [*failures(summary), *warned(summary), *recommendation(summary), *accuracy(summary), *pairs(summary), *consistency(summary)]


def most_runs(summary):
    return max(cell["runs"] for group in summary["groups"] for cell in group["cells"])


def runs_differ(summary):
    return any(cell["runs"] != most_runs(summary) for group in summary["groups"] for cell in group["cells"])


SEEDS = {"simulations": "Each seed is another simulation of the scenario.",
         "noise": "Each seed is another draw of the noise added to one recording: intervals are over draws, not over sequences.",
         "one run": "A recording to which no noise is added is one run: it has no interval."}


def seeds(summary):
    """What the runs of a scenario are: the sentence, and of which scenarios where they differ."""
    kinds = dict.fromkeys(group.get("seeds", "simulations") for group in summary["groups"])
    if len(kinds) == 1:
        return [SEEDS[kind] for kind in kinds]
    named = {kind: list(dict.fromkeys(g["name"].split(",")[0] for g in summary["groups"] if g["seeds"] == kind)) for kind in kinds}
    return [f"{', '.join(named[kind])}: {SEEDS[kind][0].lower()}{SEEDS[kind][1:]}" for kind in kinds]
