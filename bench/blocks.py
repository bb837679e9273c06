#!/usr/bin/python3
"""blocks.py STUDY [RUNS]: how far ANEES and the part of the frames inside its interval scatter between blocks of RUNS (50) seeds.

Of each cell of a finished study: over all runs the mean NEES with its standard error, a run's mean being one sample; and block by
block the mean and the part inside, of the pose by chi-square's interval, of landmarks by drawing runs again, as the report does.
"""
import json
import pathlib
import sys

import numpy
from scipy.stats import chi2

DRAWINGS = 500
PARTS = [("pose", "nees_pose", None, 6), ("landmark position", "nees_landmark_position", "landmark_position_count", 3),
         ("landmark velocity", "nees_landmark_velocity", "landmark_velocity_count", 3)]


def samples(runs, nees, count):
    """Sums of NEES and how many they are of, runs x frames."""
    values = numpy.array([[numpy.nan if v is None else v for v in run["frames"][nees]] for run in runs], dtype=float)
    counts = numpy.array([run["frames"][count] for run in runs], dtype=float) if count else numpy.ones_like(values)
    counts[numpy.isnan(values)] = 0.0
    return numpy.nan_to_num(values) * counts, counts


def limits(sums, counts, dof, is_landmark):
    """Lower and upper by frame, to hold the mean (pose) or `dof` (landmarks)."""
    runs = len(sums)
    if not is_landmark:
        return [chi2.ppf(q, dof * runs) / runs for q in (0.025, 0.975)]
    drawn = numpy.random.default_rng(1).integers(runs, size=(DRAWINGS, runs))
    means = numpy.array([sums[d].sum(axis=0) / counts[d].sum(axis=0) for d in drawn])
    return numpy.nanquantile(means, [0.025, 0.975], axis=0)


def block(sums, counts, dof, is_landmark):
    lower, upper = limits(sums, counts, dof, is_landmark)
    mean = sums.sum(axis=0) / counts.sum(axis=0)
    held = dof if is_landmark else mean
    return numpy.nanmean(mean), numpy.mean((lower <= held) & (held <= upper))


def main(folder, size=50):
    cells = {}
    with (pathlib.Path(folder) / "results.jsonl").open(encoding="utf-8") as lines:
        for run in map(json.loads, lines):
            cells.setdefault(run["cell"], []).append(run)
    for cell, runs in cells.items():
        for name, nees, count, dof in PARTS:
            sums, counts = samples(runs, nees, count)
            means = sums.sum(axis=1) / counts.sum(axis=1)
            print(f"cell {cell} {name}: {sums.sum() / counts.sum():.3f} for {dof}, standard error {means.std(ddof=1) / len(runs) ** 0.5:.3f}, {len(runs)} runs")
            starts = range(0, len(runs) - int(size) + 1, int(size))
            made = [block(sums[i:i + int(size)], counts[i:i + int(size)], dof, count is not None) for i in starts]
            print("   " + "; ".join(f"{mean:.2f} {100 * inside:.0f}%" for mean, inside in made))


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__.splitlines()[0])
    main(*sys.argv[1:])
