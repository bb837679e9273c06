"""foreign.py SLAMMOT OUTPUT [--evo SOURCE]: ten trajectories as other programs write them, judged by `slammot evaluate`, by plain numpy written here
on its own, by evo where its source tree is given, and by the formulas of ov_eval (rebuilt here): results/judge/table.md is made of it.

Each row: figures of the judge, and the largest relative difference of those of the others, of all figures that they have. evo and ov_eval know no
covariance with other orders; evo knows none. RPE over a second of evo counts frames, so it is compared where no pose is missing.
"""
import argparse
import gzip
import json
import pathlib
import subprocess
import sys

import numpy as np

RATE, FRAMES, SEED = 20, 200, 62
EXTRINSICS = (np.array([0.4, -1.1, 0.7]), np.array([0.1, -0.2, 0.3]))  # of the camera in the body


# --- rotations -----------------------------------------------------------------------------------

def hat(a):
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def exp(v):
    angle = np.linalg.norm(v)
    if angle == 0.0:
        return np.eye(3)
    k = hat(v / angle)
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def log(R):
    q = quaternion(R)
    q = q if q[3] >= 0 else -q
    norm = np.linalg.norm(q[:3])
    return q[:3] * (2.0 * np.arctan2(norm, q[3]) / norm if norm > 0.0 else 2.0)


def quaternion(R):
    """x, y, z, w: the eigenvector of the largest eigenvalue of Bar-Itzhack's matrix (2000)."""
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[2, 1] - R[1, 2]],
                  [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], R[1, 2] + R[2, 1], R[0, 2] - R[2, 0]],
                  [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]]) / 3.0
    return np.linalg.eigh(K)[1][:, 3]


# --- truth and estimates -------------------------------------------------------------------------

def true_pose(t):
    """Of a loop that climbs."""
    s = t * RATE / FRAMES
    return exp([0.3 * np.sin(7 * s), 0, 0]) @ exp([0, 5.0 * s, 0]), np.array([6.0 * np.sin(5 * s), 1.5 * np.sin(9 * s), 4.0 * np.cos(5 * s)])


def random_covariance(rng, k):
    A = rng.normal(size=(6, 6))
    return 1e-6 * (1 + k / 20) * (A @ A.T + 2 * np.eye(6)) * np.outer(*2 * [[5, 5, 5, 1, 1, 1]])


def estimates(rng, outliers=0.0):
    """Lists of R, r and P of [dr (W), dtheta (C, right)], of which the truth is drawn."""
    made = []
    for k in range(FRAMES):
        R, r = true_pose(k / RATE)
        P = random_covariance(rng, k)
        e = np.linalg.cholesky(P) @ rng.normal(size=6)
        r = r - e[:3] + (rng.normal(size=3) * 3.0 if rng.uniform() < outliers else 0.0)
        made.append([R @ exp(-e[3:]), r, P])
    return made


def in_world(made, rotation, translation, scale=1.0):
    """Another program's frame and scale, with the covariance that it states there."""
    Q = exp(np.array(rotation))
    B = np.eye(6)
    B[:3, :3] = scale * Q
    return [[Q @ R, scale * Q @ r + translation, B @ P @ B.T] for R, r, P in made]


# --- files ---------------------------------------------------------------------------------------

def tum_row(t, R, r):
    return " ".join(f"{x:.17g}" for x in (t, *r, *quaternion(R)))


def upper(P):
    return [f"{x:.17g}" for x in P[np.triu_indices(len(P))]]


def write(file, rows, packed=False):
    file.parent.mkdir(parents=True, exist_ok=True)
    text = "\n".join(rows) + "\n"
    if packed:
        pathlib.Path(f"{file}.gz").write_bytes(gzip.compress(text.encode()))
    else:
        file.write_text(text, encoding="utf-8")


def write_run(folder, times, made, packed=False):
    write(folder / "trajectory.tum", [tum_row(t, R, r) for t, (R, r, _) in zip(times, made)], packed)
    write(folder / "pose_covariance.csv", [",".join([f"{t:.17g}", *upper(P)]) for t, (_, _, P) in zip(times, made)], packed)
    return folder


def write_sequence(folder, truth_times, packed=False):
    """Exact truth (there is a landmark), of a camera that sees one point."""
    frames = [k / RATE for k in range(FRAMES)]
    write(folder / "sequence.yaml", ["format: slammot-sequence-1", f"name: {folder.name}", "pixel_sigma: 1",
                                     "camera: {model: pinhole, width: 640, height: 480, fx: 400, fy: 400, cx: 320, cy: 240}"])
    write(folder / "frames.csv", ["frame,timestamp", *(f"{k},{t!r}" for k, t in enumerate(frames))], packed)
    write(folder / "observations.csv", ["frame,track,u,v", *(f"{k},0,320,240" for k in range(FRAMES))], packed)
    write(folder / "groundtruth.tum", [tum_row(t, *true_pose(t)) for t in truth_times], packed)
    write(folder / "landmarks.csv", ["track,frame,class,x,y,z,vx,vy,vz", "0,0,static,0,0,9,0,0,0"], packed)


# --- the ten -------------------------------------------------------------------------------------

WORLD = ([0.5, -1.3, 0.8], np.array([30.0, -7.0, 12.0]))


def rotation_first(made):
    """GTSAM's: [dtheta (C), dr (C)]."""
    def J(R):
        return np.block([[np.zeros((3, 3)), np.eye(3)], [R.T, np.zeros((3, 3))]])
    return [[R, r, J(R) @ P @ J(R).T] for R, r, P in made]


def of_body(made):
    """T_WB of T_WC."""
    Q, t = exp(EXTRINSICS[0]), EXTRINSICS[1]
    return [[R @ Q.T, r - R @ Q.T @ t, None] for R, r, _ in made]


class Case:
    """One trajectory: `made` is what the judge should see, at `frames`, before alignment `by`."""

    def __init__(self, name, what, options=(), by="none", outliers=0.0, world=None, keep=None):
        self.name, self.what, self.options, self.by = name, what, list(options), by
        self.rng = np.random.default_rng([SEED, sum(map(ord, name))])
        self.made = estimates(self.rng, outliers)
        if world:
            self.made = in_world(self.made, *WORLD, scale=world)
        self.frames = [k for k in range(FRAMES) if keep is None or keep(k, self.rng)]
        self.made = [self.made[k] for k in self.frames]
        self.times = np.array(self.frames) / RATE
        self.truth_times, self.packed, self.has_covariance = np.arange(FRAMES) / RATE, False, True
        if by != "none":
            self.options += ["--align", by]

    def written(self, folder):
        """Its file or folder, and more options."""
        run = folder / self.name
        if self.name == "KITTI":
            self.has_covariance = False
            write(run.with_suffix(".txt"), [" ".join(f"{x:.17g}" for x in np.column_stack([R, r]).ravel()) for R, r, _ in self.made])
            return run.with_suffix(".txt"), []
        if self.name == "EuRoC":
            self.has_covariance = False
            rows = [(t, r, quaternion(R)) for t, (R, r, _) in zip(self.times, of_body(self.made))]
            write(run.with_suffix(".csv"), ["#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z",
                                            *(",".join([str(round(1e9 * t)), *(f"{x:.17g}" for x in (*r, q[3], *q[:3]))]) for t, r, q in rows)])
            write(folder / "T_BC.txt", [" ".join(f"{x:.17g}" for x in (*EXTRINSICS[1], *quaternion(exp(EXTRINSICS[0]))))])
            return run.with_suffix(".csv"), ["--extrinsics", folder / "T_BC.txt"]
        if self.name == "ov_eval":
            write(run.with_suffix(".txt"), [" ".join([tum_row(t, R, r), *upper(P[3:, 3:]), *upper(P[:3, :3])]) for t, (R, r, P) in zip(self.times, self.made)])
            return run.with_suffix(".txt"), []
        if self.name == "GTSAM":
            write_run(run, self.times, rotation_first(self.made), self.packed)
            write(run / "run.yaml", ["estimator: GTSAM", "error_convention: rotation-first,right,local"])
            return run, []
        late = 5.0 + self.rng.uniform(-0.004, 0.004, len(self.times)) if self.name == "late" else 0.0
        return write_run(run, self.times + late, self.made), []


def cases():
    other = Case("other times", "truth at 25 Hz, 11 ms beside the frames")
    other.truth_times = np.arange(-0.029, FRAMES / RATE + 0.1, 0.04)
    packed = Case("GTSAM", "rotation-first covariance that run.yaml states; all files packed by gzip", world=1.0, by="se3")
    packed.packed = True
    return [Case("TUM", "poses of every frame"), Case("gaps", "2 of 5 poses are missing", keep=lambda k, rng: rng.uniform() > 0.4),
            Case("late", "clock 5 s ahead, times up to 4 ms off", ["--time-offset", -5.0, "--max-difference", 0.02]),
            Case("outliers", "3 of 100 positions metres off", outliers=0.03), Case("world", "another world, first pose aligned", by="first", world=1.0),
            Case("KITTI", "another world, scale 0.4; no times, no covariance", by="sim3", world=0.4),
            Case("EuRoC", "poses of a body; nanoseconds, w first; no covariance"),
            Case("ov_eval", "another world; no covariance between position and rotation", by="se3", world=1.0), packed, other]


# --- own numpy -----------------------------------------------------------------------------------

def umeyama(x, y, scale):
    """s, Q, t with y about s Q x + t: Horn's quaternion (1987), not the singular values that the judge takes."""
    a, b = x - x.mean(0), y - y.mean(0)
    M = a.T @ b
    N = np.array([[np.trace(M), M[1, 2] - M[2, 1], M[2, 0] - M[0, 2], M[0, 1] - M[1, 0]], [0, M[0, 0] - M[1, 1] - M[2, 2], M[0, 1] + M[1, 0], M[2, 0] + M[0, 2]],
                  [0, 0, M[1, 1] - M[0, 0] - M[2, 2], M[1, 2] + M[2, 1]], [0, 0, 0, M[2, 2] - M[0, 0] - M[1, 1]]])
    w, *v = np.linalg.eigh(N, UPLO="U")[1][:, 3]
    Q = exp(2 * np.arctan2(np.linalg.norm(v), w) * np.array(v) / np.linalg.norm(v))
    s = (b * (a @ Q.T)).sum() / (a * a).sum() if scale else 1.0
    return s, Q, y.mean(0) - s * Q @ x.mean(0)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def moved(made, s, Q, t):
    return in_world([[R, r, P] for R, r, P in made], log(Q), t, s)


def aligned(case, truth):
    x, y = np.array([r for _, r, _ in case.made]), np.array([r for _, r in truth])
    if case.by == "none":
        return case.made
    if case.by == "first":
        Q = truth[0][0] @ case.made[0][0].T
        return moved(case.made, 1.0, Q, y[0] - Q @ x[0])
    return moved(case.made, *umeyama(x, y, case.by == "sim3"))


def pose_errors(made, truth):
    return np.array([[*(r_true - r), *log(R.T @ R_true)] for (R, r, _), (R_true, r_true) in zip(made, truth)])


def by_numpy(case, truth):
    made = aligned(case, truth)
    e = pose_errors(made, truth)
    x, y = np.array([r for _, r, _ in made]), np.array([r for _, r in truth])
    figures = {"position_rmse_m": rms(np.linalg.norm(e[:, :3], axis=1)), "rotation_rmse_deg": np.degrees(rms(np.linalg.norm(e[:, 3:], axis=1)))}
    for key, scale in (("ate_se3_m", False), ("ate_sim3_m", True)):
        s, Q, t = umeyama(x, y, scale)
        figures[key] = rms(np.linalg.norm(y - (s * x @ Q.T + t), axis=1))
    figures["sim3_scale"] = s
    positions, rotations = [], []
    for i, t in enumerate(case.times):
        j = np.searchsorted(case.times, t + 1.0 - 1e-6)
        if j < len(made):
            (R_i, r_i, _), (R_j, r_j, _) = made[i], made[j]
            (S_i, s_i), (S_j, s_j) = truth[i], truth[j]
            positions.append(np.linalg.norm(S_j.T @ S_i @ (R_i.T @ (r_j - r_i) - S_i.T @ (s_j - s_i))))
            rotations.append(np.degrees(np.linalg.norm(log((S_i.T @ S_j).T @ (R_i.T @ R_j)))))
    figures |= {"rpe_1s_position_rmse_m": rms(positions), "rpe_1s_rotation_rmse_deg": rms(rotations)}
    if case.has_covariance:
        parts = {"position": slice(0, 3), "rotation": slice(3, 6), **({} if case.name == "ov_eval" else {"pose": slice(0, 6)})}
        for part, block in parts.items():
            figures[f"nees.{part}"] = np.mean([d[block] @ np.linalg.inv(P[block, block]) @ d[block] for d, (_, _, P) in list(zip(e, made))[1:]])
    return figures


def by_ov_eval(case, truth):
    """ResultTrajectory's: alignments se3, sim3 and none; NEES of the truth as fitted to the estimate, of its rotation as it is."""
    if case.by == "first":
        return {}
    x, y = np.array([r for _, r, _ in case.made]), np.array([r for _, r in truth])
    s, Q, t = umeyama(x, y, case.by == "sim3") if case.by != "none" else (1.0, np.eye(3), np.zeros(3))
    figures = {"position_rmse_m": rms(np.linalg.norm(y - (s * x @ Q.T + t), axis=1)),
               "rotation_rmse_deg": np.degrees(rms([np.linalg.norm(log((Q @ R).T @ R_true)) for (R, _, _), (R_true, _) in zip(case.made, truth)]))}
    if case.has_covariance and case.by != "sim3":
        s, Q, t = umeyama(y, x, False) if case.by != "none" else (1.0, np.eye(3), np.zeros(3))
        e = [Q @ r_true + t - r for (_, r, _), (_, r_true) in zip(case.made, truth)]
        figures["nees.position"] = np.mean([d @ np.linalg.inv(P[:3, :3]) @ d for d, (_, _, P) in list(zip(e, case.made))[1:]])
        if case.by == "none":
            e = [-log(R_true.T @ R) for (R, _, _), (R_true, _) in zip(case.made, truth)]
            figures["nees.rotation"] = np.mean([d @ np.linalg.inv(P[3:, 3:]) @ d for d, (_, _, P) in list(zip(e, case.made))[1:]])
    return figures


# --- evo -----------------------------------------------------------------------------------------

def by_evo(case, truth):
    """Of evo's own functions, on the poses that belong together."""
    from evo import main_ape, main_rpe
    from evo.core import metrics, trajectory

    def path(poses):
        matrices = [np.block([[R, r[:, None]], [np.zeros((1, 3)), 1.0]]) for R, r in poses]
        return trajectory.PoseTrajectory3D(poses_se3=matrices, timestamps=case.times)

    def rmse(function, relation, *, by=case.by, **more):
        how = {"align": by in ("se3", "sim3"), "correct_scale": by == "sim3", "align_origin": by == "first"}
        return function(path(truth), path([(R, r) for R, r, _ in case.made]), relation, **how, **more).stats["rmse"]

    relation, part = metrics.PoseRelation, metrics.PoseRelation.translation_part
    figures = {"position_rmse_m": rmse(main_ape.ape, part), "rotation_rmse_deg": rmse(main_ape.ape, relation.rotation_angle_deg),
               "ate_sim3_m": rmse(main_ape.ape, part, by="sim3")}
    if case.by != "sim3":  # else the scale is corrected before
        figures["ate_se3_m"] = rmse(main_ape.ape, part, by="se3")
    if len(case.made) == FRAMES:
        second = {"delta": RATE, "delta_unit": metrics.Unit.frames, "all_pairs": True}
        figures |= {"rpe_1s_position_rmse_m": rmse(main_rpe.rpe, part, **second), "rpe_1s_rotation_rmse_deg": rmse(main_rpe.rpe, relation.rotation_angle_deg, **second)}
    return figures


# --- the judge -----------------------------------------------------------------------------------

def by_judge(program, case, folder):
    write_sequence(folder / "sequence", case.truth_times, case.packed)
    run, options = case.written(folder)
    file = folder / "metrics.json"
    words = [program, "evaluate", run, "--against", folder / "sequence", "--json", file, "--force", *case.options, *options]
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{case.name}: {done.stderr}")
    metrics, = json.loads(file.read_text(encoding="utf-8")).values()
    nees = metrics["filtered"]["nees"] or {}
    return metrics["filtered"]["accuracy"] | {f"nees.{part}": nees[part]["mean"] for part in ("pose", "position", "rotation") if part in nees}


def truth_of(case):
    """At the frames that have a pose; between true poses that are elsewhere along the turn and the line, as the judge's."""
    truth = []
    for t in case.times:
        k = np.searchsorted(case.truth_times, t)
        if k < len(case.truth_times) and case.truth_times[k] == t:
            truth.append(true_pose(t))
            continue
        (R, r), (S, s) = true_pose(case.truth_times[k - 1]), true_pose(case.truth_times[k])
        part = (t - case.truth_times[k - 1]) / (case.truth_times[k] - case.truth_times[k - 1])
        truth.append((R @ exp(part * log(R.T @ S)), r + part * (s - r)))
    return truth


def difference(ours, theirs):
    """The largest relative one, and of how many figures."""
    if not theirs:
        return "-"
    largest, key = max((abs(ours[key] / value - 1.0), key) for key, value in theirs.items())
    return f"{largest:.0e} of {len(theirs)}" + (f" ({key})" if largest > 1e-6 else "")


COLUMNS = {"position_rmse_m": "position RMSE [m]", "rotation_rmse_deg": "rotation RMSE [deg]", "ate_sim3_m": "ATE Sim(3) [m]", "sim3_scale": "scale",
           "nees.pose": "NEES pose (6)", "nees.position": "position (3)", "nees.rotation": "rotation (3)"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("--evo", type=pathlib.Path, help="evo's source tree, the folder above its package")
    asked = parser.parse_args()
    if asked.evo:
        sys.path.insert(0, str(asked.evo))
    print("| trajectory | what | `evaluate` with | poses | " + " | ".join(COLUMNS.values()) + " | own numpy | evo | formulas of ov_eval |")
    print("|---" * (7 + len(COLUMNS)) + "|")
    for case in cases():
        ours, truth = by_judge(asked.program, case, asked.output / case.name.replace(" ", "_")), truth_of(case)
        options = " ".join(str(word) for word in case.options + (["--extrinsics F"] if case.name == "EuRoC" else []))
        cells = ["-" if ours.get(key) is None else f"{ours[key]:.4g}" for key in COLUMNS]
        others = [difference(ours, by_numpy(case, truth)), difference(ours, by_evo(case, truth)) if asked.evo else "-", difference(ours, by_ov_eval(case, truth))]
        print("| " + " | ".join([case.name, case.what, f"`{options}`" if options else "", str(ours["poses"]), *cells, *others]) + " |")


if __name__ == "__main__":
    main()
