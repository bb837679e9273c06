#!/usr/bin/python3
"""real_images.py SLAMMOT DATA OUTPUT [NAME ...]: images of real sequences through `track` and `compare`; the table of docs/images.md.

bench/real/NAME.yaml is the configuration of a sequence, its first comment lines say what it is; bench/real/regions.csv marks by
hand what is seen where. A track belongs to an object if in a marked frame it lies in the object's box. A folder of OUTPUT that
is there already is not computed again.
"""
import collections
import json
import math
import pathlib
import subprocess
import sys
import warnings

import yaml
from real_motion import residuals, rows_of

HERE = pathlib.Path(__file__).resolve().parent / "real"
SEQUENCES = {  # name: folder of DATA, arguments of `track`
    "synth19_images": ("synth19_images", ["--mixed-colours", "--velocity-sigma", "0.1"]),
    "desk_hand": ("desk_hand", ["--chessboard", "9x6,0.04"]),
    "desk_hand_still": ("desk_hand", ["--chessboard", "9x6,0.04"]),
    "kitti00": ("kitti00", ["--points", "150", "--velocity-sigma", "0.3"]),
    "kitti_traffic": ("kitti_traffic", ["--points", "150", "--velocity-sigma", "0.3"]),
    "kitti_traffic_moving_start": ("kitti_traffic", ["--points", "150", "--velocity-sigma", "0.3", "--moving-start"]),
}


def computed(program, data, output, name):
    """The folders of the tracked sequence and of its comparison."""
    source, arguments = SEQUENCES[name]
    tracked, compared = output / f"{name}-tracked", output / name
    if not tracked.exists():
        subprocess.run([program, "track", data / source, "--output", tracked, *arguments], check=True)
    if not any(compared.glob("*/pictures")):  # which need the landmarks of every frame
        done = subprocess.run([program, "compare", tracked, "--landmark", "scaled_velocity", "--config",
                               HERE / f"{name}.yaml", "--pictures", "--output", compared], check=False)
        if done.returncode == 2:
            sys.exit(2)
    return tracked, compared


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
    """The tracks of twenty frames and more that a point at rest explains within two of the stated sigmas, and that none does within ten."""
    configuration = yaml.safe_load((run / "run.yaml").read_text(encoding="utf-8"))["configuration"]
    sigma, last = float(configuration["pixel_sigma"]), int(configuration["frames.last"])
    found = residuals(tracked, last if last >= 0 else math.inf, 20)
    return [t for t, r in found.items() if r < 2 * sigma], [t for t, r in found.items() if r > 10 * sigma]


def print_run(name, run, tracks, moves, at_rest, moved):
    metrics = json.loads((run / "metrics.json").read_text())
    accuracy = metrics["filtered"]["accuracy"]
    print(f"{name} {run.name}: diverged {metrics['diverged']}, position RMSE {accuracy['position_rmse_m']:.4f} m, "
          f"ATE SE3 {accuracy['ate_se3_m']:.4f} Sim3 {accuracy['ate_sim3_m']:.4f} m, scale {accuracy['sim3_scale']:.3f}, "
          f"RPE {accuracy['rpe_1s_position_rmse_m']:.4f} m {accuracy['rpe_1s_rotation_rmse_deg']:.2f} deg, NIS {metrics['nis']['mean']:.2f}")
    print("   ms: " + ", ".join(f"{s['stage']} {s['median_ms']:.1f}" for s in metrics["runtime"]["stages"]))
    landmarks = rows_of(run / "landmarks.csv")
    for thing, members in sorted(tracks.items()):
        print(f"   {thing}: {counted(members, landmarks)}")
        if moves[thing]:
            frames = [int(frame) for frame in moves[thing].split("-")]
            print(f"   {thing}, frames {moves[thing]}, while it moves: {counted(members, landmarks, frames)}")
    print(f"   at rest by the true poses: {counted(at_rest, landmarks)}; moved: {counted(moved, landmarks)}")


def main(program, data, output, names):
    for name in names or SEQUENCES:
        tracked, compared = computed(program, pathlib.Path(data), pathlib.Path(output), name)
        marked = [row for row in rows_of(HERE / "regions.csv") if row["sequence"] == SEQUENCES[name][0]]
        tracks = objects(tracked, marked)
        moves = {row["object"]: row["moves"] for row in marked}
        runs = sorted(path.parent for path in compared.glob("*/metrics.json"))
        at_rest, moved = at_rest_and_moved(tracked, runs[0]) if (tracked / "groundtruth.tum").exists() else ([], [])
        for run in runs:
            print_run(name, run, tracks, moves, at_rest, moved)


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # of fits that begin beside the lens
    if len(sys.argv) < 4:
        sys.exit(__doc__.splitlines()[0])
    main(*sys.argv[1:4], sys.argv[4:])
