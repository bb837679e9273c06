"""recordings.py SLAMMOT DATA OUTPUT [--jobs 2]: real recordings, several draws of each, as one table: results/recordings/table.md is made of it.

DATA holds `kitti_klt` (drives with other people's tracks, of one camera and of both as a rig), `kitti00` and `kitti_traffic` (images, tracked here with --points 50, 60, 70 and 100). Stated are
camera and first velocity; settings are the defaults. A draw is a drive, or a set of tracks of one recording. Errors are geometric means over the draws with
the least and the largest; ATE after Sim(3) in per cent of the true path, of the smoothed path too, and after SE(3), which judges the metres; rotation
relative to the first pose. NIS of 30 innovations of a track: 2 where its errors do not last. What is in
OUTPUT is not computed again; OUTPUT belongs to one build of the program.
"""
import argparse
import concurrent.futures
import json
import math
import pathlib
import subprocess
import sys

import yaml

from real_images import claim

POINTS = (50, 60, 70, 100)
IMAGES = ("kitti00", "kitti_traffic")
ESTIMATORS = ("ekf", "window", "static_world", "five_point")


def call(arguments, log):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, check=False)
    log.write_text(done.stdout + done.stderr, encoding="utf-8")


def rig_of(drive, output):
    """The drive with its right camera beside the left one, as a rig in slammot's format."""
    rig = output / "rigs" / drive.name
    rig.mkdir(parents=True, exist_ok=True)
    for name in ("frames.csv", "groundtruth.tum", "initial.yaml"):
        (rig / name).write_bytes((drive / name).read_bytes())
    mounted = yaml.safe_load((drive / "extrinsics.yaml").read_text(encoding="utf-8"))
    settings = yaml.safe_load((drive / "sequence.yaml").read_text(encoding="utf-8"))
    settings["cameras"] = [settings.pop("camera"), {**mounted["camera_right"], "T_C0_C": mounted["T_left_right"]}]
    (rig / "sequence.yaml").write_text(yaml.safe_dump(settings, sort_keys=False), encoding="utf-8")
    rows = ["frame,track,u,v,camera"]
    for camera, name in enumerate(("observations.csv", "observations_right.csv")):
        rows += [f"{row},{camera}" for row in (drive / name).read_text(encoding="utf-8").split()[1:]]
    (rig / "observations.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return rig


def draws(program, data, output):
    """Folders of sequences by the name of their row."""
    found = {"drives": sorted(p for p in (data / "kitti_klt").glob("*_drive_*"))}
    found["drives, both cameras"] = [rig_of(drive, output) for drive in found["drives"]]
    for name in IMAGES:
        found[name] = []
        for points in POINTS:
            tracked = output / "tracks" / f"{name}_{points}"
            if not tracked.exists():
                tracked.parent.mkdir(exist_ok=True)
                call([program, "track", data / name, "--velocity-sigma", 0.3, "--points", points, "--output", tracked],
                     output / f"{tracked.name}.log")
            found[name].append(tracked)
    return found


def path_length(sequence):
    rows = (line.split() for line in (sequence / "groundtruth.tum").read_text(encoding="utf-8").splitlines() if line[:1] not in ("#", ""))
    positions = [tuple(map(float, row[1:4])) for row in rows]
    return sum(math.dist(a, b) for a, b in zip(positions, positions[1:]))


def run(program, sequence, estimator, output):
    place = output / f"{sequence.parent.name}-{sequence.name}-{estimator}"
    if not (place / "metrics.json").exists():
        call([program, "run", sequence, "--estimator", estimator, "--output", place], output / f"{place.name}.log")
    if not (place / "metrics.json").exists():
        return None
    return json.loads((place / "metrics.json").read_text(encoding="utf-8"))


def accuracy(metrics, kind, key):
    part = metrics.get(kind) or {}
    return (part.get("accuracy") or {}).get(key)


def spread(values):
    """Geometric mean [least, largest] of what is there."""
    values = [v for v in values if v]
    if not values:
        return "-"
    mean = math.exp(sum(map(math.log, values)) / len(values))
    return f"{mean:.2g} [{min(values):.2g}, {max(values):.2g}]"


def row(name, estimator, sequences, runs):
    """One of the table; a run that ended without a result counts as failed."""
    ended = [(s, m) for s, m in zip(sequences, runs) if m]

    def ate(kind, alignment="sim3"):
        return spread([100 * a / path_length(s) for s, m in ended if (a := accuracy(m, kind, f"ate_{alignment}_m"))])

    failed = len(runs) - len(ended) + sum(bool(m["failed"] or m["diverged"]) for _, m in ended)
    silent = sum(bool(m["failed_silently"]) for _, m in ended)
    rotation = spread([accuracy(m, "filtered", "rotation_rmse_deg") for _, m in ended])
    times = [m["runtime"]["frame_median_ms"] for _, m in ended]
    return [name, estimator, str(len(runs)), ate("filtered"), ate("smoothed"), ate("filtered", "se3"), rotation, str(failed), str(silent),
            str(sum(bool(m["warned"]) for _, m in ended)), spread([m["nis"].get("lasting_mean") for _, m in ended]), spread(times)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=1)
    asked = parser.parse_args()
    claim(asked.output, asked.program)
    rows = draws(asked.program.resolve(), asked.data, asked.output)
    cells = [(name, e, s) for name, of in rows.items() for e in ESTIMATORS for s in of]
    with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        results = list(pool.map(lambda cell: run(asked.program.resolve(), cell[2], cell[1], asked.output), cells))
    print("| recording | estimator | draws | ATE Sim(3) [%] | smoothed [%] | SE(3) [%] | rotation [deg] | failed | silently | warned | NIS of 30 | ms a frame |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for name, of in rows.items():
        for e in ESTIMATORS:
            mine = [m for (n, other, _), m in zip(cells, results) if (n, other) == (name, e)]
            print("| " + " | ".join(row(name, e, of, mine)) + " |")


if __name__ == "__main__":
    sys.exit(main())
