"""What the program wrote, as pandas tables and numpy arrays."""
import csv
import gzip
import io
import json
import pathlib
from dataclasses import dataclass, field

import numpy as np
import pandas
import yaml

from .estimator import Camera, Frame, OtherViews

_TUM = ["timestamp", "x", "y", "z", "qx", "qy", "qz", "qw"]


def _file(folder, name, required=True):
    file = pathlib.Path(folder, name)
    if not file.is_file() and pathlib.Path(f"{file}.gz").is_file():
        file = pathlib.Path(f"{file}.gz")
    if pathlib.Path(folder, ".slammot-replacing").exists():
        raise ValueError(f"{folder}: its files were being replaced when a program was stopped: write it again")
    if not file.is_file():
        if required:
            raise FileNotFoundError(f"{file}: no such file")
        return None
    return file


def _table(file, text=None, **how):
    """A CSV or TUM file, or its text, as a table; None for no file."""
    if file is None:
        return None
    try:
        return pandas.read_csv(file if text is None else io.StringIO(text), float_precision="round_trip", **how)
    except (ValueError, EOFError, gzip.BadGzipFile, pandas.errors.ParserError) as error:
        raise ValueError(f"{file}: {error}") from None


def _text(file):
    with (gzip.open if file.suffix == ".gz" else open)(file, "rt", encoding="utf-8") as lines:
        return lines.read()


def _images(file):
    """A table whose last column, the name of an image, runs to the end of its line."""
    if file is None:
        return None
    rows = _text(file).splitlines()
    quoted = io.StringIO()
    csv.writer(quoted).writerows(row.split(",", rows[0].count(",")) for row in rows)
    return _table(file, quoted.getvalue())


def _yaml(file):
    if file is None:
        return {}
    try:
        return yaml.safe_load(_text(file))
    except yaml.YAMLError as error:
        raise ValueError(f"{file}: {error}") from None


def _trajectory(file):
    return _table(file, sep=r"\s+", comment="#", header=None, names=_TUM)


def _symmetric(table, prefix, size):
    """n x size x size, of columns PREFIX11, PREFIX12, ... that hold the upper triangles."""
    rows, columns = np.triu_indices(size)
    names = [f"{prefix}{i + 1}{j + 1}" for i, j in zip(rows, columns)]
    full = np.empty((len(table), size, size))
    full[:, rows, columns] = table[names].to_numpy()
    full[:, columns, rows] = full[:, rows, columns]
    return full


@dataclass
class Run:
    """A run's folder. Trajectories have columns timestamp, x, y, z, qx, qy, qz, qw; covariances are n x 6 x 6 of
    [dr (W), dtheta (C, right)]; tables are None where there is no file, as in runs made elsewhere."""
    folder: pathlib.Path
    description: dict
    trajectory: pandas.DataFrame
    covariance: np.ndarray = None
    smoothed: pandas.DataFrame = None
    smoothed_covariance: np.ndarray = None
    last_scale: pandas.DataFrame = None  # the shape of `trajectory` in the scale of its end
    landmarks: pandas.DataFrame = None
    predictions: pandas.DataFrame = None
    classification: pandas.DataFrame = None
    timing: pandas.DataFrame = None
    metrics: dict = field(default_factory=dict)


def read_run(folder):
    def covariances(name):
        table = _table(_file(folder, name, required=False), comment="#")
        return None if table is None else _symmetric(table, "p", 6)

    def optional(name):
        return _table(_file(folder, name, required=False), comment="#")

    trajectory = _trajectory(_file(folder, "trajectory.tum"))
    metrics = _file(folder, "metrics.json", required=False)
    return Run(folder=pathlib.Path(folder), description=_yaml(_file(folder, "run.yaml", required=False)),
               trajectory=trajectory, covariance=covariances("pose_covariance.csv"),
               smoothed=_trajectory(_file(folder, "trajectory_smoothed.tum", required=False)),
               smoothed_covariance=covariances("pose_covariance_smoothed.csv"),
               last_scale=_trajectory(_file(folder, "trajectory_last_scale.tum", required=False)), landmarks=optional("landmarks.csv"),
               predictions=optional("predictions.csv"),
               classification=optional("classification.csv"), timing=optional("timing.csv"),
               metrics=json.loads(_text(metrics)) if metrics else {})


def read_study(folder):
    """A row per run: scenario, group, estimator, label, swept values, seed, metrics, times. Runs of a group that have
    the same seed saw the same measurements."""
    return _table(_file(folder, "runs.csv"), keep_default_na=False, na_values=[""])


@dataclass
class Sequence:
    """A sequence's folder. `truth` has the columns of a trajectory; `landmarks`, `known` and `priors` are None if not stated."""
    folder: pathlib.Path
    name: str
    camera: Camera
    pixel_sigma: float
    frames: pandas.DataFrame        # frame, timestamp[, image]
    observations: pandas.DataFrame  # frame, track, u, v[, relative_sigma][, camera][, depth, depth_sigma]
    truth: pandas.DataFrame = None
    landmarks: pandas.DataFrame = None
    known: pandas.DataFrame = None
    settings: dict = field(default_factory=dict)  # sequence.yaml
    initial: dict = field(default_factory=dict)   # initial.yaml
    other_cameras: tuple = ()                     # of a rig, from camera 1 on
    other_images: pandas.DataFrame = None         # frame, camera, image
    priors: pandas.DataFrame = None               # track, p_static

    def measured_by(self, camera):
        """The observations of one camera of the rig."""
        return self.observations[self.observations["camera"] == camera] if "camera" in self.observations else self.observations

    def __iter__(self):
        """Frames as an estimator is given them."""
        by_frame = dict(iter(self.observations.groupby("frame", sort=False)))
        nothing = self.observations.iloc[:0]
        for row in self.frames.itertuples():
            rows = by_frame.get(row.frame, nothing)
            cameras = rows["camera"].to_numpy() if "camera" in rows else np.zeros(len(rows), int)
            first, others = rows[cameras == 0], rows[cameras > 0]
            relative = first["relative_sigma"].to_numpy(float) if "relative_sigma" in rows else np.ones(len(first))
            depths = first[["depth", "depth_sigma"]].fillna(0.0).to_numpy(float) if "depth" in rows else np.zeros((len(first), 2))
            yield Frame(row.frame, row.timestamp, first["track"].to_numpy(), first[["u", "v"]].to_numpy(float), relative, depths,
                        OtherViews(others["track"].to_numpy(), cameras[cameras > 0], others[["u", "v"]].to_numpy(float)))


def _camera(stated):
    mounted = stated.get("T_C0_C", {})
    return Camera(stated["model"], int(stated["width"]), int(stated["height"]), *(float(stated[key]) for key in ("fx", "fy", "cx", "cy")),
                  np.array(stated.get("distortion", []), float), np.array(mounted.get("position", Camera.position), float),
                  np.array(mounted.get("quaternion", Camera.orientation), float))


def read_sequence(folder):
    """Of the native layout, which `slammot simulate` and `slammot track` write."""
    settings = _yaml(_file(folder, "sequence.yaml"))
    cameras = tuple(map(_camera, settings.get("cameras") or [settings["camera"]]))
    observations = _table(_file(folder, "observations.csv"))
    by = [column for column in ("frame", "track", "camera") if column in observations]
    observations = observations.sort_values(by, ignore_index=True)
    return Sequence(folder=pathlib.Path(folder), name=settings["name"], camera=cameras[0], other_cameras=cameras[1:],
                    other_images=_images(_file(folder, "other_images.csv", required=False)),
                    pixel_sigma=float(settings["pixel_sigma"]), frames=_images(_file(folder, "frames.csv")),
                    observations=observations, truth=_trajectory(_file(folder, "groundtruth.tum", required=False)),
                    landmarks=_table(_file(folder, "landmarks.csv", required=False)),
                    known=_table(_file(folder, "known.csv", required=False)),
                    priors=_table(_file(folder, "priors.csv", required=False)), settings=settings,
                    initial=_yaml(_file(folder, "initial.yaml", required=False)))
