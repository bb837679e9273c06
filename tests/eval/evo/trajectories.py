"""Trajectories on which slammot and evo are compared, and the recording of evo's figures.

usage: trajectories.py FOLDER          writes them as FOLDER/NAME/truth.tum and estimate.tum
       trajectories.py FOLDER RECORD   runs evo_ape and evo_rpe (which must be on the PATH) on them into the file RECORD
"""
import json
import math
import pathlib
import random
import subprocess
import sys
import zipfile

RATE, FRAMES = 15, 150


def product(p, q):
    """Of quaternions x, y, z, w."""
    (a, b, c, d), (x, y, z, w) = p, q
    return [d * x + a * w + b * z - c * y, d * y - a * z + b * w + c * x, d * z + a * y - b * x + c * w, d * w - a * x - b * y - c * z]


def turn(axis, angle):
    norm = math.dist(axis, (0, 0, 0))
    return [math.sin(angle / 2) * x / norm for x in axis] + [math.cos(angle / 2)]


def rotated(q, p):
    x, y, z, w = q
    return product(product(q, [*p, 0.0]), [-x, -y, -z, w])[:3]


def truth(flat=False):
    """A loop that climbs, unless it is flat; (time, position, quaternion)."""
    poses = []
    for i in range(FRAMES):
        s = i / FRAMES
        position = [6.0 * math.sin(5.0 * s), 0.0 if flat else 1.5 * math.sin(9.0 * s), 4.0 * math.cos(5.0 * s)]
        poses.append((i / RATE, position, product(turn((0, 1, 0), 5.0 * s), turn((1, 0, 1), 0.4 * math.sin(7.0 * s)))))
    return poses


def estimate(poses, seed, scale=1.0, noise=0.02, drift=0.0, frame=None, every=1, jitter=0.0, offset=0.0):
    rng = random.Random(seed)
    q_frame, t_frame = frame or ([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
    made, away = [], [0.0, 0.0, 0.0]
    for i, (time, position, q) in enumerate(poses):
        away = [a + rng.gauss(0.0, drift) for a in away]
        disturbed = [scale * p + a + rng.gauss(0.0, noise) for p, a in zip(position, away)]
        axis, angle = [rng.gauss(0.0, 1.0) for _ in range(3)], rng.gauss(0.0, 0.05)
        late = rng.uniform(-jitter, jitter)
        if i % every:
            continue
        moved = [m + t for m, t in zip(rotated(q_frame, disturbed), t_frame)]
        made.append((time + late + offset, moved, product(product(q_frame, q), turn(axis, angle))))
    return made


TURNED = (turn((1, -2, 0.5), 2.4), [30.0, -7.0, 12.0])
# name: options of estimate(), options of evo, options of slammot
CASES = {
    "noise": ({}, [], []),
    "scale": ({"scale": 0.6}, [], []),
    "drift": ({"drift": 0.05}, [], []),
    "frame": ({"frame": TURNED, "scale": 1.7, "drift": 0.03}, [], []),
    "sparse": ({"every": 3, "jitter": 0.004, "drift": 0.02}, ["--t_max_diff", "0.01"], ["--max-difference", "0.01"]),
    "late": ({"offset": 0.5, "jitter": 0.003}, ["--t_offset", "-0.5", "--t_max_diff", "0.02"], ["--time-offset", "-0.5", "--max-difference", "0.02"]),
    "flat": ({"drift": 0.02, "noise": 0.0}, [], []),
}


def write_tum(file, poses):
    file.write_text("".join(" ".join(repr(x) for x in (t, *p, *q)) + "\n" for t, p, q in poses))


def write(folder):
    for seed, (name, (options, _, _)) in enumerate(CASES.items()):
        (folder / name).mkdir(parents=True, exist_ok=True)
        poses = truth(flat=name == "flat")
        write_tum(folder / name / "truth.tum", poses)
        write_tum(folder / name / "estimate.tum", estimate(poses, seed, **options))


def commands(name):
    """Key of slammot's metric to evo's command. Poses are 1/15 s apart, or 1/5 s where every third is there."""
    both = ["tum", "truth.tum", "estimate.tum", *CASES[name][1]]
    second = str(RATE // CASES[name][0].get("every", 1))
    relative = ["evo_rpe", *both, "--delta", second, "--delta_unit", "f", "--all_pairs"]
    return {"position_rmse_m": ["evo_ape", *both], "rotation_rmse_deg": ["evo_ape", *both, "--pose_relation", "angle_deg"],
            "ate_se3_m": ["evo_ape", *both, "--align"], "ate_sim3_m": ["evo_ape", *both, "--align", "--correct_scale"],
            "rpe_1s_position_rmse_m": relative, "rpe_1s_rotation_rmse_deg": [*relative, "--pose_relation", "angle_deg"]}


def figure(folder, command):
    results = folder / "results.zip"
    results.unlink(missing_ok=True)
    subprocess.run([*command, "--save_results", "results.zip", "--silent", "--no_warnings"], cwd=folder, check=True)
    with zipfile.ZipFile(results) as file:
        return json.loads(file.read("stats.json"))["rmse"]


def record(folder, file):
    version = subprocess.run(["evo", "pkg", "--version"], capture_output=True, text=True, check=True).stdout.strip()
    table = {name: {key: {"rmse": figure(folder / name, command), "command": " ".join(command)} for key, command in commands(name).items()}
             for name in CASES}
    file.write_text(json.dumps({"evo": version, "figures": table}, indent=1) + "\n")


if __name__ == "__main__":
    write(pathlib.Path(sys.argv[1]))
    if len(sys.argv) > 2:
        record(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
