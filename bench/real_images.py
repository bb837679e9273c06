"""real_images.py SLAMMOT DATA OUTPUT [--sensitivity | --first-frames] [--alignment] [NAME ...]: real images through `track` and `run` with the defaults: what docs/recordings.md speaks of.

Stated are camera and scale, nothing else: what a recording says of its camera's accelerations and of depths is taken out, and the estimators'
settings are the defaults. With --sensitivity EKF and window run again with one setting changed at a time; with --first-frames all run from other
first frames, whose true pose and velocity are stated then. With --alignment the images are tracked with `--noise alignment`. bench/real/regions.csv marks by hand what is seen where: a track belongs to an object if in a marked frame it lies in
the object's box. A folder of OUTPUT that is there already is not computed again; OUTPUT belongs to one build of the program. ATE is after alignment by Sim(3), in per cent of the true path
from the first frame used; the rotation's error is the RMSE over all frames without alignment, and that times 50 m over the path. NIS: the joint NIS as
a share of what is right.
"""
import collections
import hashlib
import json
import math
import pathlib
import subprocess
import sys
import warnings

import yaml
from real_motion import TrueCameras, residuals, rows_of

HERE = pathlib.Path(__file__).resolve().parent / "real"
SEQUENCES = {  # name: the folder of DATA, and arguments of `track`, which state the scale
    "kitti00": ("kitti00", ["--velocity-sigma", "0.3"]),
    "synth19_images": ("synth19_images", ["--mixed-colours", "--velocity-sigma", "0.1"]),
    "desk_hand": ("desk_hand", ["--chessboard", "9x6,0.04"]),
    "desk_hand_free": ("desk_hand", ["--velocity-sigma", "0.1"]),
    "kitti_traffic": ("kitti_traffic", ["--velocity-sigma", "0.3"]),
}
AT_REST, MOVED = 0.6, 3.0  # [px], residuals; the true poses are not exact either
ESTIMATORS = ["ekf", "window", "static_world", "five_point"]
FIRST_FRAMES = range(1, 40, 4)  # 0, 2, 4, .. 38 took part in choosing the motion of the camera noise (docs/models.md)
SETTINGS = [("pixel_sigma=0.2",), ("pixel_sigma=0.5",), ("motion.acceleration=3", "motion.angular_acceleration=3"), ("motion.adaptive=false",),
            ("gate.given_others=1",), ("prior.mean_sigma=0.1",), ("policy.max_visible=30",), ("labels.births=static_first",)]


def claim(output, program):
    """OUTPUT is of this build, or refused: a table is of one program."""
    digest = hashlib.sha256(pathlib.Path(program).read_bytes()).hexdigest() + "\n"
    file = output / "program.sha256"
    output.mkdir(parents=True, exist_ok=True)
    if not any(output.iterdir()):
        file.write_text(digest, encoding="utf-8")
    if not file.exists() or file.read_text(encoding="utf-8") != digest:
        sys.exit(f"{output}: holds runs of another build of the program")


def objects(tracked, marked):
    """The tracks of each object that is marked."""
    found = collections.defaultdict(set)
    for z in rows_of(tracked / "observations.csv"):
        for row in marked:
            inside = (float(row["u0"]) < float(z["u"]) < float(row["u1"])
                      and float(row["v0"]) < float(z["v"]) < float(row["v1"]))
            if z["frame"] == row["frame"] and inside:
                found[row["object"]].add(z["track"])
    return found


def counted(tracks, landmarks, frames=(0, math.inf)):
    """The last labels of the tracks within these frames, counted."""
    labels = {row["track"]: row["label"] for row in landmarks if frames[0] <= int(row["frame"]) <= frames[1]}
    counts = collections.Counter(labels[t] for t in tracks if t in labels)
    return ", ".join(f"{counts[label]} {label}" for label in ("static", "moving", "unknown"))


def at_rest_and_moved(tracked, run):
    """The tracks of ten frames and more that a point at rest explains, seen from the true poses, and that none does."""
    configuration = yaml.safe_load((run / "run.yaml").read_text(encoding="utf-8"))["configuration"]
    last = int(configuration["frames.last"])
    found = residuals(tracked, last if last >= 0 else math.inf, 10)
    return [t for t, r in found.items() if r < AT_REST], [t for t, r in found.items() if r > MOVED]


def path_of(tracked, first=0):
    """[m], of the true poses from this frame on."""
    poses = TrueCameras(tracked).poses
    points = [poses[frame][1] for frame in sorted(poses) if frame >= first]
    return sum(map(math.dist, points, points[1:]))


def tracked_by(program, data, output, name, noise=()):
    tracked = output / "-".join([name, *noise[1:], "tracked"])
    if not tracked.exists():
        folder, arguments = SEQUENCES[name]
        subprocess.run([program, "track", data / folder, "--output", tracked, *arguments, *noise], check=True)
        statements = tracked / "sequence.yaml"
        kept = [line for line in statements.read_text(encoding="utf-8").splitlines(keepends=True)
                if not line.startswith(("motion:", "prior:"))]
        statements.write_text("".join(kept), encoding="utf-8")
    return tracked


def run_of(program, tracked, estimator, settings=()):
    folder = tracked.parent / "-".join([tracked.name.removesuffix("-tracked"), estimator, *settings])
    if not (folder / "metrics.json").exists():
        changes = [word for setting in settings for word in ("--set", setting)]
        done = subprocess.run([program, "run", tracked, "--estimator", estimator, *changes, "--output", folder],
                              check=False, stdout=subprocess.DEVNULL)
        if done.returncode == 2:
            sys.exit(2)
    return folder


def cell(run, path):
    metrics = json.loads((run / "metrics.json").read_text(encoding="utf-8"))
    accuracy = metrics["filtered"]["accuracy"]
    rotation = accuracy["rotation_rmse_deg"]
    note = ", failed" if metrics["failed"] or metrics["diverged"] else ""
    joint = metrics["nis"]["joint_mean"]
    nis = "" if joint is None else f", NIS {joint / 2:.2g}"
    return (f"{100 * accuracy['ate_sim3_m'] / path:.2g}%, {rotation:.2g} ({50 * rotation / path:.2g}) deg{nis}{note}, "
            f"{len(metrics['warnings'])} w")


def print_table(rows, names, run, paths):
    print("| | " + " | ".join(f"{name} ({paths[name]:.3g} m)" for name in names) + " |")
    print("|---" * (len(names) + 1) + "|")
    for label, arguments in rows:
        print(f"| {label} | " + " | ".join(cell(run(name, *arguments), paths[name]) for name in names) + " |", flush=True)


def print_first_frames(name, tracked, run):
    """Geometric mean and worst ATE over the first frames, how many are within 1%, how many failed and how many of these warned. Of runs that
    ended early there is no error over the whole path: they are counted only."""
    for estimator, kinds in (("ekf", ["filtered"]), ("window", ["filtered", "smoothed"]), ("static_world", ["filtered"]),
                             ("five_point", ["filtered"])):
        runs = {first: run(name, estimator, (f"frames.first={first}",)) for first in FIRST_FRAMES}
        metrics = {first: json.loads((folder / "metrics.json").read_text(encoding="utf-8")) for first, folder in runs.items()}
        failed = [m for m in metrics.values() if m["failed"]]
        ended = [first for first, m in metrics.items() if m["diverged"]]
        for kind in kinds:
            errors = [100 * m[kind]["accuracy"]["ate_sim3_m"] / path_of(tracked, first) for first, m in metrics.items() if first not in ended]
            mean = math.exp(sum(map(math.log, errors)) / len(errors)) if errors else math.nan
            print(f"| {name} | {estimator}, {kind} | {mean:.2g}%, {max(errors, default=math.nan):.2g}%, {sum(e <= 1 for e in errors)} of "
                  f"{len(metrics)} | {len(ended)}, {len(failed)}, {sum(m['warned'] > 0 for m in failed)} |", flush=True)


def print_labels(name, tracked, run):
    marked = [row for row in rows_of(HERE / "regions.csv") if row["sequence"] == SEQUENCES[name][0]]
    at_rest, moved = at_rest_and_moved(tracked, run)
    landmarks = rows_of(run / "landmarks.csv")
    print(f"{run.name}: at rest by the true poses: {counted(at_rest, landmarks)}; moved: {counted(moved, landmarks)}")
    moves = {row["object"]: row["moves"] for row in marked}
    for thing, members in sorted(objects(tracked, marked).items()):
        frames = [int(frame) for frame in moves[thing].split("-")] if moves[thing] else (0, math.inf)
        print(f"   {thing}, frames {moves[thing] or 'all'}: {counted(members, landmarks, frames)}")


def main(program, data, output, names, options):
    claim(pathlib.Path(output), program)
    paths, tracked = {}, {}
    for name in names:
        noise = ["--noise", "alignment"] if "--alignment" in options else []
        tracked[name] = tracked_by(program, pathlib.Path(data), pathlib.Path(output), name, noise)
        paths[name] = path_of(tracked[name])

    def run(name, estimator, settings=()):
        return run_of(program, tracked[name], estimator, settings)

    if "--first-frames" in options:
        print("| | | mean, worst, within 1% | ended, failed, of these warned |\n|---|---|---|---|")
        for name in names:
            print_first_frames(name, tracked[name], run)
        return
    if "--sensitivity" in options:
        print_table([(f"{estimator}, {' '.join(f'`{s}`' for s in settings) or 'defaults'}", (estimator, settings))
                     for estimator in ("ekf", "window") for settings in [()] + SETTINGS], names, run, paths)
        return
    print_table([(estimator, (estimator,)) for estimator in ESTIMATORS], names, run, paths)
    for name in names:
        for estimator in ("ekf", "window"):
            print_labels(name, tracked[name], run(name, estimator))


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # of fits that begin beside the lens
    options = [word for word in sys.argv[1:] if word in ("--sensitivity", "--first-frames", "--alignment")]
    words = [word for word in sys.argv[1:] if word not in options]
    if len(words) < 3 or {"--sensitivity", "--first-frames"} <= set(options):
        sys.exit(__doc__.splitlines()[0])
    main(*words[:3], words[3:] or list(SEQUENCES), options)
