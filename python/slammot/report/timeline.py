"""python3 -m slammot.report timeline RUN [--sequence SEQUENCE]: RUN/timeline.html, a recording and what a run made of it under
one slider: the image with its tracks and their labels, the map from above, NEES and other series.

The page needs nothing but itself: pictures are carried inside, made smaller, and its script draws on canvases without a library.
"""
import base64
import io
import pathlib
import sys

from .comparison import BadInput, NotMade
from .page import one_line, rendered, run_report

MOST_IMAGES = 200  # of more frames every k-th is shown
WIDTH = 640        # [px] of a picture at most
QUALITY = 70       # of JPEG
LABELS = ("static", "unknown", "moving")  # what the script calls 0, 1, 2
NONE = 3           # a track that is no landmark
DIGITS = 4         # significant, of what is drawn


def read(run, sequence):
    """A run's folder and its sequence's."""
    try:
        from .. import reading
    except ImportError as error:
        raise NotMade(f"{error.name}: not found; install python3-{error.name}") from error
    if (run / "compare.json").is_file():
        names = ", ".join(sorted(file.parent.name for file in run.glob("*/trajectory.tum")))
        raise BadInput(f"{run}: is a comparison: give the folder of one of its runs{names and ': '}{names}")
    try:
        found = reading.read_run(run)
        sequence = sequence or pathlib.Path((found.description.get("sequence") or {}).get("path") or "")
        if sequence == pathlib.Path():
            raise BadInput(f"{run / 'run.yaml'}: names no sequence; use --against")
        return found, reading.read_sequence(sequence)
    except (FileNotFoundError, ValueError) as error:
        raise BadInput(error) from error


def rounded(value):
    """A number for the script: short, and null where it is not defined."""
    return float(f"{value:.{DIGITS}g}") if value == value and abs(value) < 1e300 else None


def picture(file, size):
    """An image's file as a small JPEG, carried inside the page."""
    try:
        from PIL import Image
    except ImportError as error:
        raise NotMade("PIL: not found; install python3-pil") from error
    try:
        with Image.open(file) as opened:
            if opened.mode.startswith("I"):  # 16 bits: the high byte, as `slammot track` takes it
                opened = opened.point(lambda value: value / 256).convert("L")
            small = opened.convert("L" if opened.mode in ("1", "L", "LA") else "RGB").resize(size, Image.Resampling.BOX)
    except (OSError, ValueError) as error:
        raise BadInput(f"{file}: {error}") from error
    packed = io.BytesIO()
    small.save(packed, "JPEG", quality=QUALITY)
    return "data:image/jpeg;base64," + base64.b64encode(packed.getvalue()).decode("ascii")


class Labels:
    """The label of a track in a frame: as the run stated it there, else from the frame on that classification.csv names."""

    def __init__(self, run):
        rows = run.landmarks
        self.every_frame = rows is not None and bool(rows["track"].duplicated().any())
        self.stated = {(r.frame, r.track): r.label for r in rows.itertuples()} if self.every_frame else {}
        decided = run.classification
        self.decided = {} if decided is None else {r.track: (r.frame, r.label) for r in decided.itertuples()}

    def __call__(self, frame, track):
        if self.every_frame:
            label = self.stated.get((frame, track))
        else:
            since, label = self.decided.get(track, (None, None))
            if label is not None and not frame >= since:  # an empty frame is nan: never decided
                label = "unknown"
        return LABELS.index(label) if label in LABELS else NONE


class FromAbove:
    """World to the map: right and forward of the first camera, from where it stood [m]. As frontend/rendering/map_view.h."""

    def __init__(self, first):
        from ..so3 import matrix
        self.origin = first[["x", "y", "z"]].to_numpy(float)
        self.axes = matrix(first[["qx", "qy", "qz", "qw"]].to_numpy(float)).T[[0, 2]]

    def turned(self, directions):
        return directions @ self.axes.T

    def __call__(self, points):
        return self.turned(points - self.origin)


def places_of(run, sequence):
    """Row of the trajectory to frame: the nearest in time."""
    import numpy as np
    times, frames = run.trajectory["timestamp"].to_numpy(), sequence.frames["timestamp"].to_numpy()
    middles = (frames[1:] + frames[:-1]) / 2
    return np.searchsorted(middles, times)


def true_path(run, sequence):
    """(positions at the times of the poses, nan where no truth is near; error [m]; what was done to them)."""
    import numpy as np
    from ..judge.accuracy import pairs
    from ..judge.alignment import align
    estimated = run.trajectory[["x", "y", "z"]].to_numpy()
    true = np.full_like(estimated, np.nan)
    if sequence.truth is None:
        return true, np.full(len(true), np.nan), "no truth"
    rows, there = pairs(run.trajectory, sequence.truth)
    true[rows] = sequence.truth[["x", "y", "z"]].to_numpy()[there]
    if sequence.landmarks is not None:  # exact (docs/formats.md)
        return true, np.linalg.norm(true - estimated, axis=1), "as it is"
    if len(rows) < 3:
        return np.full_like(true, np.nan), np.full(len(true), np.nan), "fewer than three true poses"
    s = align(estimated[rows], true[rows])
    error = np.linalg.norm(s(estimated) - true, axis=1)
    if not s.scale > 1e-9:
        return np.full_like(true, np.nan), error, "no similarity"
    return (true - s.translation) @ s.rotation / s.scale, error, "aligned"


def nees_of(run):
    """({frame: NEES of the pose}, why there is none)."""
    filtered = run.metrics.get("filtered") or {}
    nees = filtered.get("nees") or {}
    if not nees.get("series"):
        return {}, filtered.get("nees_reason") or "the run has no metrics.json that states it"
    return {int(row[0]): row[2] for row in nees["series"]}, ""


def nis_of(run, sequence):
    """Frame to the mean NIS of its accepted measurements."""
    if run.predictions is None or run.predictions.empty:
        return {}
    of_rig = "camera" in run.predictions
    used = run.predictions[run.predictions["measured"] == "accepted"].merge(
        sequence.observations if of_rig else sequence.measured_by(0), on=["frame", "track", *(["camera"] if of_rig else [])], suffixes=("", "_z"))
    x, y = used["u_z"] - used["u"], used["v_z"] - used["v"]
    nis = (used["s_vv"] * x * x - 2 * used["s_uv"] * x * y + used["s_uu"] * y * y) / (used["s_uu"] * used["s_vv"] - used["s_uv"] ** 2)
    return nis.groupby(used["frame"]).mean().to_dict()


def tracks_of(observations, labels):
    """Frame to [track, u, v, label] of what it measured."""
    tracks = {}
    for r in observations.itertuples():
        tracks.setdefault(r.frame, []).append([int(r.track), round(r.u, 1), round(r.v, 1), labels(r.frame, r.track)])
    return tracks


def landmarks_of(run, above, tracks):
    """Frame to [label, measured, x, y, dx, dy] on the map, d in one second; None: the final ones of all frames, [label, track, ...]."""
    rows = run.landmarks
    if rows is None:
        return {None: []}
    rows = rows[rows[["x", "y", "z"]].notna().all(axis=1)]
    flat, steps = above(rows[["x", "y", "z"]].to_numpy(float)), above.turned(rows[["vx", "vy", "vz"]].to_numpy(float))
    every_frame = bool(run.landmarks["track"].duplicated().any())
    measured = {(frame, track) for frame, found in tracks.items() for track, *_ in found}
    by_frame = {} if every_frame else {None: []}
    for r, at, step in zip(rows.itertuples(), flat, steps):
        seen = not every_frame or (r.frame, r.track) in measured
        if r.label in LABELS and (seen or r.label == "static"):  # of what may move nobody knows where it is now
            by_frame.setdefault(r.frame if every_frame else None, []).append(
                [LABELS.index(r.label), int(seen) if every_frame else int(r.track), *map(rounded, [*at, *(step if r.label == "moving" else ())])])
    return by_frame


def shown_of(path, points):
    """The map's limits [left, right, near, far]: the path, what lies about it, and always a third of the points."""
    import numpy as np
    low, high = path.min(0), path.max(0)
    away = np.abs(points - (low + high) / 2).max(1)
    near = (away < (high - low).max()) | (away <= np.quantile(away, 1 / 3)) if len(points) else []
    low, high = (f(np.vstack([path, points[near]]), axis=0) for f in (np.min, np.max))
    margin = 0.05 * (high - low).max() + 0.1
    return [rounded(v) for v in (low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin)]


def series_of(run, sequence, count, places, error, how, tracks):
    """What is drawn against the frames, in its order: name, unit, lines, band; or why it is not."""
    def of(by_frame):
        return [rounded(by_frame.get(k, float("nan")) if by_frame.get(k) is not None else float("nan")) for k in range(count)]

    nees, reason = nees_of(run)
    series = [{"name": "NEES of the pose", "log": True, "lines": [of(nees)] if nees else [], "band": [1.237, 14.449], "expected": 6,
               "why": f"Not judged: {reason}."}]
    errors = dict(zip(map(int, places), error))
    series.append({"name": "Position error" + (" after Sim(3) alignment" if how == "aligned" else ""), "unit": "m",
                   "lines": [of(errors)] if how in ("as it is", "aligned") else [], "why": f"Not known: {how}."})
    series.append({"name": "Mean NIS of accepted measurements", "lines": [of(nis)] if (nis := nis_of(run, sequence)) else [],
                   "why": "Not known: run with --landmarks every-frame."})
    counts = [[sum(found[3] == label for found in tracks.get(k, ())) for k in range(count)] for label in range(3)]
    series.append({"name": "Measured landmarks by label", "labels": True, "lines": counts, "why": ""})
    return series


def data_of(run, sequence):
    """All that the script draws; frames are those shown, series are of all."""
    import numpy as np
    count = len(sequence.frames)
    if not len(run.trajectory) or not count:
        raise BadInput(f"{run.folder}: the run has no frame")
    labels, places, above = Labels(run), places_of(run, sequence), FromAbove(run.trajectory.iloc[0])
    tracks = tracks_of(sequence.measured_by(0), labels)
    others = [tracks_of(sequence.measured_by(1 + k), labels) for k in range(len(sequence.other_cameras))]
    landmarks = landmarks_of(run, above, tracks)
    estimated = above(run.trajectory[["x", "y", "z"]].to_numpy())
    true, error, how = true_path(run, sequence)
    every = -(-count // MOST_IMAGES)
    times = sequence.frames["timestamp"].to_numpy()
    points = np.array([found[2:4] for found in landmarks.get(None, landmarks.get(max(filter(lambda f: f is not None, landmarks), default=None), []))], float).reshape(-1, 2)
    return {"width": sequence.camera.width, "height": sequence.camera.height, "every": every, "count": count,
            "frames": [{"frame": k, "time": round(float(times[k] - times[0]), 3), "tracks": tracks.get(k, []), "others": [other.get(k, []) for other in others],
                        "landmarks": landmarks.get(k, []) if labels.every_frame else None} for k in range(0, count, every)],
            "landmarks": landmarks.get(None, []), "every_frame": labels.every_frame,
            "path": [[int(k), *map(rounded, p)] for k, p in zip(places, estimated)],
            "heading": [list(map(rounded, v)) for v in headings(run, above)],
            "truth": [[int(k), *map(rounded, p)] for k, p in zip(places, above(true)) if p[0] == p[0]], "how": how,
            "shown": shown_of(estimated, points), "series": series_of(run, sequence, count, places, error, how, tracks)}


def headings(run, above):
    """Where the camera looks, on the map."""
    import numpy as np
    from ..so3 import matrix
    quaternions = run.trajectory[["qx", "qy", "qz", "qw"]].to_numpy(float)
    return above.turned(np.array([matrix(q)[:, 2] for q in quaternions]))


def pictures_of(sequence, frames, images, name="images"):
    """(a picture or None for each frame shown, why some are missing); `images` are their names by frame."""
    width = min(WIDTH, sequence.camera.width)
    size = width, max(1, round(width * sequence.camera.height / sequence.camera.width))
    files = [sequence.folder / images[frame["frame"]] if frame["frame"] in images else None for frame in frames]
    missing = [file for file in files if file and not file.is_file()]
    if len(missing) == len(files):
        return None, f"The {name} are not where the sequence names them, as {missing[0]}."
    return ([picture(file, size) if file and file.is_file() else None for file in files],
            f"{len(missing)} {name} are missing, as {missing[0]}." if missing else "")


def pictures_of_all(sequence, frames):
    """(the pictures of camera 0 or None, of each other camera whose images are named likewise, why some are missing)."""
    if "image" not in sequence.frames:
        return None, [], "The sequence names no images."
    pictures, missing = pictures_of(sequence, frames, dict(enumerate(map(str, sequence.frames["image"]))))
    others, named = [], sequence.other_images
    for k in range(len(sequence.other_cameras) if named is not None else 0):
        rows = named[named["camera"] == 1 + k]
        found, why = pictures_of(sequence, frames, dict(zip(rows["frame"], map(str, rows["image"]))), f"images of camera {1 + k}")
        others.append(found)
        missing = " ".join(filter(None, (missing, why)))
    return pictures, others, missing


def notes_of(data, missing):
    """(heading, text) of what a reader needs to know."""
    notes = [("Frames", f"Every {data['every']}th of {data['count']} frames is shown: at most {MOST_IMAGES} pictures fit a page. The series are of all." if data["every"] > 1
              else f"All {data['count']} frames are shown.")]
    if data["pictures"]:
        notes.append(("Pictures", f"JPEG, at most {WIDTH} pixels wide: the measurements were made in the images as they are. {missing}"))
    elif missing:
        notes.append(("Pictures", f"{missing} Tracks are drawn where they were measured."))
    notes.append(("Labels", "As the run states them in each frame (landmarks.csv)." if data["every_frame"] else
                  "Unknown until the frame in which the run decided (classification.csv), and the map's landmarks are the final ones; of each frame with --landmarks every-frame."))
    notes.append(("Map", "Axes are right and forward of the first camera [m]. " + {
        "as it is": "Dashed: the true path. ", "aligned": "Dashed: the true path, moved, turned and scaled to the estimated one. "}.get(data["how"], "") +
                  "A line at what moves is one second of its velocity."))
    notes.append(("NEES", "Grey: where it lies in 95 of 100 frames of a consistent estimator; dashed: its mean, 6."))
    return notes


LEGEND = (("0", "static"), ("1", "unknown"), ("2", "moving"), ("3", "measured, no landmark"), ("rest", "static, not measured now"),
          ("path", "estimated path"), ("truth", "true path"))


def page(output, given):
    run, sequence = read(output, given.sequence)
    data = data_of(run, sequence)
    data["pictures"], data["other_pictures"], missing = pictures_of_all(sequence, data["frames"])
    if "image" in sequence.frames and missing:
        print(f"timeline: warning: {one_line(missing)}", file=sys.stderr)
    estimator = run.description.get("estimator") or run.folder.resolve().name
    return rendered(
        "timeline.html", "timeline.js", data, with_plotly=False, title=f"{estimator} on {sequence.name}",
        about="Drag the slider, use the keys left and right, or click into a series; the space bar plays.", wide=data["width"] > 2 * data["height"],
        pictured=bool(data["pictures"]), others=len(sequence.other_cameras), legend=[entry for entry in LEGEND if entry[0] != "truth" or data["truth"]], notes=notes_of(data, missing))


def main():
    return run_report("timeline", page, "trajectory.tum", "timeline.html", sequence={"type": pathlib.Path, "metavar": "SEQUENCE"})
