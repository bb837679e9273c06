"""The figures of one run, from arrays: what metrics.json calls accuracy and nees, by the same definitions."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from .alignment import PARTS, Alignment, align_run
from .alignment import align as align_positions
from .consistency import nees, nees_interval
from .intervals import quantile

COLUMNS = ["timestamp", "x", "y", "z", "qx", "qy", "qz", "qw"]
Poses = ArrayLike | pd.DataFrame


@dataclass(frozen=True)
class Evaluation:
    """`frames` has a row for each judged pose: timestamp [s], position_error_m, rotation_error_deg, and nees_pose,
    nees_position, nees_rotation (NaN for the first, whose covariance is a pin). `figures` are those of the run, by the keys
    of metrics.json. `alignment` is how it was aligned before."""
    frames: pd.DataFrame
    figures: dict[str, float]
    alignment: Alignment | None = None


def _poses(poses: Poses, what: str) -> NDArray:
    table = poses[COLUMNS].to_numpy(float) if isinstance(poses, pd.DataFrame) else np.asarray(poses, float)
    if table.ndim != 2 or table.shape[1] != 8:
        raise ValueError(f"{what} must be n x 8 (timestamp, x, y, z, qx, qy, qz, qw), not {table.shape}")
    if (np.diff(table[:, 0]) <= 0.0).any():
        raise ValueError(f"the times of {what} do not increase")
    return table


def pairs(poses: Poses, truth: Poses, time_offset: float = 0.0, max_difference: float | None = None) -> tuple[NDArray, NDArray]:
    """Which rows belong together: (rows of poses, rows of truth). A true pose is judged by the pose nearest in time, at most
    `max_difference` seconds away, or half of the shortest interval of the truth; `time_offset` is added to the poses' times."""
    times, frames = _poses(poses, "the poses")[:, 0] + time_offset, _poses(truth, "the truth")[:, 0]
    tolerance = np.diff(frames).min(initial=np.inf) / 2 if max_difference is None else max_difference
    later = np.clip(np.searchsorted(frames, times), 1, max(len(frames) - 1, 1))
    nearest = np.where(times - frames[later - 1] <= frames[np.minimum(later, len(frames) - 1)] - times, later - 1, later)
    nearest = np.minimum(nearest, len(frames) - 1)
    away = np.abs(frames[nearest] - times)
    best = {}  # truth to pose
    for row in np.flatnonzero(away <= tolerance):
        frame = nearest[row]
        if frame not in best or away[row] < away[best[frame]]:
            best[frame] = row
    return np.array([best[f] for f in sorted(best)], int), np.array(sorted(best), int)


def errors(poses: Poses, truth: Poses) -> NDArray:
    """(n, 6): [r_true - r_est (W, m), Log(R_est^-1 R_true) (C, rad)] of poses that belong together row by row. With
    boxminus as Hertzberg et al. (2013); its NEES is `nees(errors, covariances)`."""
    estimated, true = _poses(poses, "the poses"), _poses(truth, "the truth")
    turn = Rotation.from_quat(estimated[:, 4:]).inv() * Rotation.from_quat(true[:, 4:])
    return np.hstack([true[:, 1:4] - estimated[:, 1:4], turn.as_rotvec()])


def _rms(values: ArrayLike) -> float:
    values = np.asarray(values, float)
    return float(np.sqrt(np.mean(values**2))) if values.size else np.nan


def _norms(vectors: NDArray) -> NDArray:
    return np.linalg.norm(vectors, axis=-1)


def _aligned_figures(estimated: NDArray, true: NDArray) -> dict[str, float]:
    if len(true) < 3:
        return {"ate_se3_m": np.nan, "ate_sim3_m": np.nan, "sim3_scale": np.nan}
    se3, sim3 = align_positions(estimated, true, scale=False), align_positions(estimated, true)
    return {"ate_se3_m": _rms(_norms(true - se3(estimated))), "ate_sim3_m": _rms(_norms(true - sim3(estimated))),
            "sim3_scale": sim3.scale}


def _relative_figures(poses: NDArray, truth: NDArray, interval: float = 1.0) -> dict[str, float]:
    """Error of the motion within `interval` seconds (Sturm et al. 2012, RPE), over all pairs of poses."""
    later = np.searchsorted(poses[:, 0], poses[:, 0] + interval - 1e-6)
    i = np.flatnonzero(later < len(poses))
    j = later[i]

    def motion(table):
        R = Rotation.from_quat(table[:, 4:]) if len(i) else None
        return (R[i].inv() * R[j], R[i].inv().apply(table[j, 1:4] - table[i, 1:4])) if len(i) else (None, np.zeros((0, 3)))

    (R_est, r_est), (R_true, r_true) = motion(poses), motion(truth)
    turn = (R_true.inv() * R_est).magnitude() if len(i) else np.zeros(0)
    return {"rpe_1s_pairs": len(i), "rpe_1s_position_rmse_m": _rms(_norms(r_est - r_true)),
            "rpe_1s_rotation_rmse_deg": _rms(np.degrees(turn))}


def nees_figures(samples: ArrayLike, dof: int) -> dict[str, float]:
    """What a run says of its NEES (frames,): mean, median, 95% quantile, share in the chi-square interval of one sample."""
    samples = np.asarray(samples, float)
    if np.isnan(samples).any():
        return {}
    lower, upper = nees_interval(dof)
    known = len(samples) > 0
    mean = float(np.mean(samples)) if known else np.nan
    return {"dof": dof, "used": len(samples), "covariances_not_positive_definite": int(np.isinf(samples).sum()), "mean": mean,
            "mean_over_dof": mean / dof, "median": quantile(samples, 0.5), "q95": quantile(samples, 0.95),
            "fraction_inside": float(np.mean((samples >= lower) & (samples <= upper))) if known else np.nan}


def evaluate(poses: Poses, covariances: ArrayLike | None, truth: Poses, *, time_offset: float = 0.0,
             max_difference: float | None = None, align: str = "none") -> Evaluation:
    """Judges one run against exact truth, as `slammot evaluate` does.

    poses: (n, 8) timestamp [s], x, y, z [m], qx, qy, qz, qw: T_WC; or a data frame with these columns.
    covariances: (n, 6, 6) of [dr (W, m), dtheta (C, rad, R_true = R_est Exp(dtheta))], or None: then there is no NEES.
    truth: (m, 8), in the frame of the estimates.
    align: none, first (pose), se3 or sim3 (a fit of the positions): before errors and NEES. What that leaves of NEES stands in
        the result's `alignment`.
    time_offset, max_difference: [s], as those of the program; by default 0 and half a frame.
    """
    at, frames = pairs(poses, truth, time_offset, max_difference)
    estimated, true = _poses(poses, "the poses")[at], _poses(truth, "the truth")[frames]
    estimated[:, 0] = true[:, 0]
    if len(at) == 0:
        raise ValueError("no pose is within half a frame of a true one")
    P = None if covariances is None else np.asarray(covariances, float)[at]
    alignment = None
    if align != "none":
        estimated, P, alignment = align_run(estimated, P, true, align)
    e = errors(estimated, true)
    position, rotation = _norms(e[:, :3]), np.degrees(_norms(e[:, 3:]))
    figures = {"coverage": len(at) / len(np.asarray(truth)), "poses": len(at), "position_rmse_m": _rms(position),
               "position_max_m": position.max(), "position_final_m": position[-1], "rotation_rmse_deg": _rms(rotation),
               "rotation_max_deg": rotation.max(), **_aligned_figures(estimated[:, 1:4], true[:, 1:4]),
               **_relative_figures(estimated, true)}
    table = pd.DataFrame({"timestamp": estimated[:, 0], "position_error_m": position, "rotation_error_deg": rotation})
    if P is not None:
        for part, block in PARTS.items():
            table[f"nees_{part}"] = np.append(np.nan, nees(e[1:, block], P[1:, block, block]))
            of_part = nees_figures(table[f"nees_{part}"][1:], block.stop - block.start)
            figures |= {f"nees.{part}.{key}": value for key, value in of_part.items()}
    return Evaluation(table, {key: value if isinstance(value, int) else float(value) for key, value in figures.items()}, alignment)
