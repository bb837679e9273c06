"""What a comparison's folder holds, as plain objects: compare.json and the files of its runs.

null in compare.json means "not defined" and becomes None; a file that is missing is an empty one.
"""
import csv
import json
import math
import re
from dataclasses import dataclass, field

from ..pooling.estimators import pooled
from ..pooling.json_files import plain
from .metrics import read_table

FORMAT = "slammot-compare-1"

# Okabe and Ito's palette and two more, in the order that keeps the first ones farthest apart for all kinds of colour vision; black is the ground truth.
RUN_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#56B4E9", "#E69F00", "#CC79A7", "#8C6D31", "#7A5195")


class BadInput(Exception):
    """One line: file and reason."""


class NotMade(Exception):
    """One line: what is missing beside the input, or cannot be written."""


@dataclass
class Run:
    label: str
    name: str  # what the page calls it
    estimator: str
    sequence: str  # its name, empty where all runs are of one
    truth_is_here: bool  # its sequence is the one whose truth the page has
    pooled: str    # the estimator whose runs it is put together with
    kind: str      # filter | smoother | batch | ideal_covariance | foreign
    landmark: str
    colour: str
    metrics: dict
    table: dict   # key to metrics.Metric
    series: dict
    smoothed_series: dict
    last_scale_series: dict  # empty where the scale is known
    configuration: dict
    variances: dict = field(default_factory=dict)       # timestamp: the diagonal of P, position [m^2] and rotation [rad^2]
    landmarks: list = field(default_factory=list)       # final: (track, label, x, y, z)
    labels: dict = field(default_factory=dict)          # of the landmarks that had to be classified: label to count

    def metric(self, *path):
        """A metric by its path in metrics.json, None where it is not defined."""
        return dig(self.metrics, *path)

    @property
    def judged(self):
        """A batch is judged by what it is for: its filtered trajectory is its front window's."""
        return "smoothed" if self.kind == "batch" else "filtered"

    @property
    def others(self):
        """Name, series and line of the trajectories that it has beside the one it is judged by."""
        return [("in the last scale", self.last_scale_series, "dashdot"), ("smoothed", self.smoothed_series, "dash")]

    def value(self, key, which=None):
        """The value of a metric of the table, None where it is not defined."""
        metric = self.table[key]
        path = metric.path.split(".")
        return self.metric(which or self.judged, *path) if metric.of == "trajectory" else self.metric(*path)

    def sigma(self, first, end, unit=1.0):
        """The root of the sum of these variances at each pose of the series; None where they are not stated."""
        stated = [self.variances.get(t, [None] * 6)[first:end] for t in self.series.get("timestamp", [])]
        return [None if None in variances else unit * math.sqrt(sum(variances)) for variances in stated]

    def position_sigma(self):
        return self.sigma(0, 3)

    def rotation_sigma_deg(self):
        return self.sigma(3, 6, math.degrees(1.0))

    def axis_sigma(self, k):
        """Of one axis of the world [m]; none of a run that was turned, whose covariance is in its former axes."""
        return [None] * len(self.series.get("timestamp", [])) if self.alignment else self.sigma(k, k + 1)

    @property
    def divergence(self):
        return self.metric("divergence")

    @property
    def warnings(self):
        return self.metric("warnings") or []

    @property
    def alignment(self):
        """How `--align` has moved it, or None."""
        return self.metric("alignment")

    @property
    def failed_at(self):
        return self.metric("failed_at")

    @property
    def competes(self):
        """Whether its numbers may be called the best: not of a run that diverged, failed or has poses of few frames."""
        return self.divergence is None and self.failed_at is None


@dataclass
class Estimator:
    """What all runs of an estimator say together."""
    name: str
    colour: str
    runs: int
    diverged: int
    failed: int
    warned: int | None  # None in a comparison of before they were counted
    values: dict     # key of a metric to {value, lower, upper, runs}
    anees: dict      # part to {dof, mean, lower, upper, inside, infinite}
    per_frame: dict


@dataclass
class Comparison:
    command: str
    version: str
    provenance: dict
    sequence: dict
    truth: dict
    table: dict  # key to metrics.Metric
    runs: list
    estimators: list  # their runs put together
    pairs: list
    together: dict     # both as pooled.json has them

    @property
    def has_truth(self):
        return bool(self.truth.get("position"))

    @property
    def pooled(self):
        """Whether there are several runs of an estimator, or several sequences: the page then is about estimators."""
        return self.sequence.get("count", 1) > 1 or any(estimator.runs > 1 for estimator in self.estimators)

    @property
    def title(self):
        """What it is about: a sequence, or all that are put together."""
        names = list(dict.fromkeys(self.sequence.get("names", [])))
        if self.sequence.get("count", 1) == 1 or not names:
            return self.sequence["name"]
        return f"{self.sequence['count']} sequences: {names_together(names)}"

    @property
    def aligned(self):
        """On measured truth errors are those after similarity alignment."""
        return self.has_truth and not self.sequence["exact_truth"]

    @property
    def moved(self):
        """Whether runs were aligned before all errors, by `--align`."""
        return any(run.alignment for run in self.runs)

    @property
    def error_key(self):
        return "ate_sim3_m" if self.aligned else "position_rmse_m"


def names_together(names):
    """`circle-1 to circle-20` where nothing is missing between, else the first names."""
    parts = [re.fullmatch(r"(.*?)(\d+)", name) for name in names]
    if len(names) > 2 and all(parts) and len({part[1] for part in parts}) == 1:
        numbered = sorted((int(part[2]), part[0]) for part in parts)
        if [number for number, _ in numbered] == list(range(numbered[0][0], numbered[0][0] + len(names))):
            return f"{numbered[0][1]} to {numbered[-1][1]}"
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def dig(tree, *path):
    """tree[path[0]][path[1]]..., None as soon as something is absent or is not a finite number."""
    for key in path:
        if not isinstance(tree, dict):
            return None
        tree = tree.get(key)
    if isinstance(tree, float) and not math.isfinite(tree):
        return None
    return tree


def read_json(path, form=None):
    """What a JSON file holds; where a format is stated, an object that says it is in this format."""
    if path.exists() and not path.is_file():
        raise BadInput(f"{path}: not a regular file")  # a pipe would block
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{path}: {error}") from error
    if form and (not isinstance(content, dict) or content.get("format") != form):
        raise BadInput(f"{path}: not in the format {form}")
    return content


def rows_of(path):
    """The rows of a CSV file as dicts; comment lines start with #."""
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def number(text):
    """A finite number, or None."""
    try:
        value = float(text)
    except (TypeError, ValueError):
        return None
    return value if math.isfinite(value) else None


def read_variances(path):
    found = {}
    for row in rows_of(path):
        timestamp = number(row.get("timestamp"))
        variances = [number(row.get(f"p{i}{i}")) for i in range(1, 7)]
        if timestamp is not None:
            found[timestamp] = [None if v is None or v < 0.0 else v for v in variances]
    return found


def read_final_landmarks(path):
    newest = {}
    for row in rows_of(path):
        position = [number(row.get(axis)) for axis in "xyz"]
        if None not in position:
            newest[row["track"]] = (row["track"], row["label"], *position)
    return list(newest.values())


def read_label_counts(path):
    counts = {}
    for row in rows_of(path):
        counts[row["label"]] = counts.get(row["label"], 0) + 1
    return counts


def placed(alignment, p):
    """A point of the estimate in the frame and scale of the measured truth."""
    return [alignment["scale"] * sum(r * x for r, x in zip(row, p)) + t
            for row, t in zip(alignment["rotation"], alignment["translation"])]


def in_frame_of_truth(series):
    """Where the page draws the estimate: aligned on measured truth, as it is elsewhere."""
    if "alignment" in series:
        series["position"] = [placed(series["alignment"], p) for p in series["position"]]
        series["position_error_m"] = series["aligned_position_error_m"]
    return series


def with_settings(entry):
    settings = {key: value for key, value in entry.get("overrides", {}).items() if key != "landmark"}
    return ", ".join([entry["estimator"], *(f"{key} = {value}" for key, value in settings.items())])


def named(entries):
    """`estimator · landmark model`, or the label where that does not tell the runs apart; of one without models its label."""
    names = [e["label"] if e["landmark"] == "-" else " · ".join(filter(None, (with_settings(e), e["landmark"]))) for e in entries]
    return names if len(set(names)) == len(names) else [e["label"] for e in entries]


def read_run(output, entry, table, name, colour, sequence):
    folder = output / entry["folder"]
    series = in_frame_of_truth(entry.get("series") or {})
    landmarks = read_final_landmarks(folder / "landmarks.csv")
    own, several = entry.get("sequence") or {}, sequence.get("count", 1) > 1
    covariance = "pose_covariance_smoothed.csv" if entry.get("kind") == "batch" else "pose_covariance.csv"
    if "alignment" in series:
        landmarks = [(track, label, *placed(series["alignment"], p)) for track, label, *p in landmarks]
    return Run(
        label=entry["label"], name=name, estimator=entry["estimator"], sequence=own.get("name", "") if several else "",
        truth_is_here=not several or all(own.get(key) == sequence.get(key) for key in ("name", "sha256") if key in own), pooled=entry.get("pooled", ""), kind=entry.get("kind", ""), landmark=entry["landmark"],
        colour=colour, metrics=entry.get("metrics") or {}, table=table, series=series,
        smoothed_series=in_frame_of_truth(entry.get("smoothed_series") or {}),
        last_scale_series=in_frame_of_truth(entry.get("last_scale_series") or {}),
        configuration=entry.get("configuration") or {},
        # What is stated of the position is not about the aligned one.
        variances={} if "alignment" in series else read_variances(folder / covariance),
        landmarks=landmarks, labels=read_label_counts(folder / "classification.csv"))


def read_estimators(entries):
    return [Estimator(name=e["name"], colour=RUN_COLOURS[i % len(RUN_COLOURS)], runs=e["runs"], diverged=e["diverged"],
                      failed=e["failed"], warned=e.get("warned"), values=e["values"], anees=e["anees"], per_frame=e["per_frame"] or {})
            for i, e in enumerate(entries)]


def colour_of(entry, i, estimators):
    """Runs of one estimator have its colour."""
    return next((e.colour for e in estimators if e.name == entry.get("pooled")), RUN_COLOURS[i % len(RUN_COLOURS)])


def pooled_of(content):
    """What the runs say together; files of release 0.1 have it already, or have nothing of the frames."""
    if "estimators" in content or any("frames" not in run for run in content["runs"]):
        return {"estimators": content.get("estimators", []), "pairs": content.get("pairs", [])}
    return plain(pooled(content))


def read_comparison(output):
    path = output / "compare.json"
    content = read_json(path, FORMAT)
    try:
        together = pooled_of(content)
        entries = content["runs"]
        table = read_table(content["metrics"])
        estimators = read_estimators(together["estimators"])
        runs = [read_run(path.parent, entry, table, name, colour_of(entry, i, estimators), content["sequence"])
                for i, (entry, name) in enumerate(zip(entries, named(entries)))]
        return Comparison(command=content["command"], version=content["version"], provenance=content.get("provenance", {}),
                          sequence=content["sequence"], truth=content.get("truth") or {}, table=table, runs=runs,
                          estimators=estimators, pairs=together["pairs"], together=together)
    except KeyError as error:
        raise BadInput(f"{path}: the key {error} is missing") from error
