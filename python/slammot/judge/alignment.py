"""A run brought to the truth: by its first pose, or by a least-squares fit of its positions; and what that leaves of NEES."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

FITTED = {"first": 6, "se3": 6, "sim3": 7}  # degrees of freedom
PARTS = {"pose": slice(0, 6), "position": slice(0, 3), "rotation": slice(3, 6)}


@dataclass(frozen=True)
class Similarity:
    """p_true is about scale * rotation @ p_estimated + translation."""
    scale: float
    rotation: NDArray     # (3, 3)
    translation: NDArray  # (3,) [m]

    def __call__(self, points: NDArray) -> NDArray:
        return self.scale * points @ self.rotation.T + self.translation


@dataclass(frozen=True)
class Alignment:
    """How `evaluate` has aligned a run of n poses. `left` of 6 n degrees of freedom remain of their errors.

    `expected`: mean NEES by part of an estimator whose covariances are right and whose errors are *independent from pose to
    pose*, to first order. Those of SLAM are not: what they share, an alignment takes away, so `verdict` is false of a fit; of
    `first` it is true where the first pose has next to no covariance, as one held fixed.
    """
    by: str
    similarity: Similarity
    fitted: int
    left: int
    verdict: bool
    expected: dict[str, float] = field(default_factory=dict)


def align(estimated: ArrayLike, true: ArrayLike, scale: bool = True) -> Similarity:
    """Least squares over positions (n, 3) [m] (Umeyama 1991, eq. 40 to 43); `scale` false: a rigid motion. Fewer than three
    different points show a translation only."""
    x, y = np.asarray(estimated, float), np.asarray(true, float)
    mean_x, mean_y = x.mean(0), y.mean(0)
    variance = ((x - mean_x) ** 2).sum() / len(x)
    if len(x) < 3 or variance == 0.0:
        return Similarity(1.0, np.eye(3), mean_y - mean_x)
    U, D, Vt = np.linalg.svd((y - mean_y).T @ (x - mean_x) / len(x))
    S = np.diag([1.0, 1.0, np.sign(np.linalg.det(U) * np.linalg.det(Vt))])
    R = U @ S @ Vt
    factor = float((D * np.diag(S)).sum() / variance) if scale else 1.0
    return Similarity(factor, R, mean_y - factor * R @ mean_x)


def align_run(poses: NDArray, covariances: NDArray | None, truth: NDArray, by: str) -> tuple[NDArray, NDArray | None, Alignment]:
    """Poses (n, 8) and covariances (n, 6, 6) of [dr (W), dtheta (C)] as aligned with the true poses that belong to them: dr
    turns and scales with the world, dtheta is the camera's and stays."""
    if by not in FITTED:
        raise ValueError(f"align is none, {', '.join(FITTED)}, not {by!r}")
    similarity = _at_first(poses[0], truth[0]) if by == "first" else _fit(poses[:, 1:4], truth[:, 1:4], by == "sim3")
    turned = Rotation.from_matrix(similarity.rotation) * Rotation.from_quat(poses[:, 4:])
    moved = np.column_stack([poses[:, 0], similarity(poses[:, 1:4]), turned.as_quat()])
    if covariances is not None:
        covariances = np.array(covariances)  # by blocks: one that is not known (NaN) shall not spoil another
        covariances[:, :3] = similarity.scale * similarity.rotation @ covariances[:, :3]
        covariances[:, :, :3] = similarity.scale * covariances[:, :, :3] @ similarity.rotation.T
    expected = {} if covariances is None else expected_nees(moved, covariances, by)
    alignment = Alignment(by, similarity, FITTED[by], 6 * len(poses) - FITTED[by],
                          by == "first" and covariances is not None and _first_is_held(covariances), expected)
    return moved, covariances, alignment


def expected_nees(aligned: ArrayLike, covariances: ArrayLike, by: str) -> dict[str, float]:
    """The mean NEES of all poses but the first, after alignment `by`, of errors that are drawn independently from
    `covariances`; by part of the error, to first order.

    With xi = [dphi, dt, ds / s] of the alignment, which is linear in the errors, xi = sum of H_k e_k, an error becomes
    e_k - G_k xi.
    """
    poses, P = np.asarray(aligned, float), np.asarray(covariances, float)
    R, size = Rotation.from_quat(poses[:, 4:]).as_matrix(), FITTED[by]
    arms = poses[:, 1:4] - (poses[0, 1:4] if by == "first" else poses[:, 1:4].mean(0))
    G = np.zeros((len(poses), 6, 7))
    G[:, :3, :3] = -np.cross(arms[:, None, :], np.eye(3)).swapaxes(1, 2)  # column i: dphi_i x arm
    G[:, :3, 3:6] = np.eye(3)
    G[:, :3, 6] = arms
    G[:, 3:, :3] = R.swapaxes(1, 2)
    G, H = G[:, :, :size], np.zeros((len(poses), size, 6))
    if by == "first":
        H[0, :3, 3:], H[0, 3:, :3] = R[0], np.eye(3)
    else:
        J = G[:, :3]
        H[:, :, :3] = np.linalg.solve(np.einsum("kia,kib->ab", J, J), J.swapaxes(1, 2))
    shared = np.einsum("kai,kij,kbj->ab", H, P, H)
    taken = G @ H @ P
    left = (P - taken - taken.swapaxes(1, 2) + G @ shared @ G.swapaxes(1, 2))[1:]
    return {part: _mean_trace(P[1:, block, block], left[:, block, block]) for part, block in PARTS.items()}


def _mean_trace(P: NDArray, left: NDArray) -> float:
    try:
        return float(np.trace(np.linalg.solve(P, left), axis1=1, axis2=2).mean()) if len(P) else np.nan
    except np.linalg.LinAlgError:
        return np.nan


def _at_first(pose: NDArray, true: NDArray) -> Similarity:
    R = (Rotation.from_quat(true[4:]) * Rotation.from_quat(pose[4:]).inv()).as_matrix()
    return Similarity(1.0, R, true[1:4] - R @ pose[1:4])


def _fit(estimated: NDArray, true: NDArray, scale: bool) -> Similarity:
    if len(true) < 3 or _is_line(estimated) or _is_line(true):
        raise ValueError("no rotation is seen in positions that are fewer than three, at rest or on a line: 'first' aligns them")
    return align(estimated, true, scale)


def _is_line(points: NDArray) -> bool:
    lengths = np.linalg.svd(points - points.mean(0), compute_uv=False)
    return not lengths[1] > 1e-6 * lengths[0]


def _first_is_held(P: NDArray) -> bool:
    variances = np.array([[np.trace(p[:3, :3]), np.trace(p[3:, 3:])] for p in P])
    return bool((variances[0] <= 0.01 * variances.mean(0)).all())
