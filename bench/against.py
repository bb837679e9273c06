"""against.py COMMIT OUTPUT [SEQUENCE ...] [--runs 20] [--seed 66701] [--jobs 1]: is build/release better than an earlier commit, and what does it cost?

EKF and window, at the defaults of each, run the same sequences by both programs, one after the other: the scenes of believable.yaml with `runs` seeds, which the
present program writes, or the sequences named. The commit is built in slammot-out/against-COMMIT; that takes minutes. OUTPUT keeps a file for each pair,
belongs to one build of the program and is not computed again. For each scene and family: the geometric mean of now / before, pair by pair, with its 95%
interval (none from fewer than five pairs), of position RMSE, of the ATE after Sim(3), of the pose's mean NEES, and of the CPU time of a whole run, over
pairs of which neither diverged; the runs that failed, diverged ones among them, and that warned; the labels of landmarks, wrong or undecided. Times are
of use only where `--jobs 1` and nothing else run; each program is the first of every other pair. OpenBLAS has one thread and Haswell's kernels.
"""
import argparse
import collections
import concurrent.futures
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys

import scipy.stats

from real_images import claim

ROOT = pathlib.Path(__file__).resolve().parents[1]
NOW = ROOT / "build/release/slammot"
SCENES = {"circle": ["circle"], "square": ["square"], "circle with 3 in 10": ["circle", "--set", "moving=600", "--set", "first_moving=14"]}


def built(commit):
    """The program of that commit."""
    tree = ROOT / "slammot-out" / f"against-{commit}"
    if not tree.exists():
        subprocess.run(["git", "-C", ROOT, "worktree", "add", "--detach", tree, commit], check=True)
    subprocess.run(["cmake", "-S", tree, "--preset", "release"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", tree / "build/release", "--parallel", "--target", "slammot"], check=True, stdout=subprocess.DEVNULL)
    return tree / "build/release/slammot"


def cpu_seconds(arguments, log):
    """CPU time of a program, which may fail: what it wrote is looked at afterwards."""
    environment = {**os.environ, "OPENBLAS_CORETYPE": "Haswell", "OPENBLAS_NUM_THREADS": "1"}
    with open(log, "wb") as text:
        process = subprocess.Popen([str(a) for a in arguments], env=environment, stdout=text, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) == 2:
        sys.exit(f"{' '.join(map(str, arguments))} is refused: {log.read_text(encoding='utf-8')}")
    return used.ru_utime + used.ru_stime


def measured(program, sequence, estimator, folder):
    """What is compared, of one run."""
    run = folder / "run"
    seconds = cpu_seconds([program, "run", sequence, "--estimator", estimator, "--output", run], folder / "run.log")
    metrics = json.loads((run / "metrics.json").read_text(encoding="utf-8"))
    shutil.rmtree(run)
    judged = metrics["filtered"] or {}
    accuracy = judged.get("accuracy") or {}
    nees = ((judged.get("nees") or {}).get("pose") or {}).get("mean")
    labels = metrics.get("classification") or {}
    return {"rmse": accuracy.get("position_rmse_m"), "sim3": accuracy.get("ate_sim3_m"), "nees": nees, "cpu": seconds, "diverged": bool(metrics["diverged"]),
            "failed": bool(metrics["failed"] or metrics["diverged"]), "warned": bool(metrics["warnings"]),
            "labels": [labels[kind][verdict] for kind in ("static", "moving") for verdict in ("right", "wrong", "undecided")] if labels else None}


def pair(case, programs, output):
    """Both programs on one sequence, by one family; a case that OUTPUT has is read."""
    scene, seed, sequence, estimator = case
    name = f"{scene} {seed} {estimator}".replace(" ", "_")
    stored = output / f"{name}.json"
    if stored.exists():
        return json.loads(stored.read_text(encoding="utf-8"))
    folder = output / f"{name}.work"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    if sequence is None:
        sequence = folder / "sequence"
        subprocess.run([NOW, "simulate", *SCENES[scene], "--seed", str(seed), "--output", sequence], check=True, stdout=subprocess.DEVNULL)
    found = {"scene": scene, "estimator": estimator}
    for age in sorted(programs, reverse=seed % 2 == 1):
        found[age] = measured(programs[age], sequence, estimator, folder)
    shutil.rmtree(folder)
    stored.write_text(json.dumps(found), encoding="utf-8")
    return found


def ratio(pairs, key):
    """The geometric mean of now / before, and its interval by Student's t; of how many pairs, where not of all."""
    logs = [math.log(p["now"][key] / p["before"][key]) for p in pairs
            if p["now"][key] and p["before"][key] and not p["now"]["diverged"] and not p["before"]["diverged"]]
    if not logs:
        return "-"
    text = f"{math.exp(statistics.mean(logs)):.3g}" + (f" of {len(logs)}" if len(logs) < len(pairs) else "")
    if len(logs) < 5:
        return text
    half = scipy.stats.t.ppf(0.975, len(logs) - 1) * statistics.stdev(logs) / math.sqrt(len(logs))
    return f"{text} [{math.exp(statistics.mean(logs) - half):.3g}, {math.exp(statistics.mean(logs) + half):.3g}]"


def labels_of(pairs, age):
    """Static ones and moving ones that are wrong or undecided, in per cent."""
    counts = [p[age]["labels"] for p in pairs if p["before"]["labels"] and p["now"]["labels"]]
    if not counts:
        return "-"
    sums = [sum(column) for column in zip(*counts)]
    return ", ".join(f"{100 * (1 - of[0] / sum(of)):.1f}" if sum(of) else "-" for of in (sums[:3], sums[3:]))


def table(pairs):
    cells = collections.defaultdict(list)
    for p in pairs:
        cells[p["scene"], p["estimator"]].append(p)
    print("| scene | estimator | pairs | RMSE | ATE Sim(3) | NEES | NEES before, now | failed | warned | labels before | now [%] | CPU |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for (scene, estimator), found in cells.items():
        counts = {what: " to ".join(str(sum(p[age][what] for p in found)) for age in ("before", "now")) for what in ("failed", "warned")}
        nees = [[p[age]["nees"] for p in found if p[age]["nees"]] for age in ("before", "now")]
        means = ", ".join(f"{statistics.mean(n):.3g}" if n else "-" for n in nees)
        print(f"| {scene} | {estimator} | {len(found)} | {ratio(found, 'rmse')} | {ratio(found, 'sim3')} | {ratio(found, 'nees')} | {means} | {counts['failed']} | {counts['warned']} | "
              f"{labels_of(found, 'before')} | {labels_of(found, 'now')} | {ratio(found, 'cpu')} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("commit")
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("sequences", nargs="*", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=66701)
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    if len({path.name for path in given.sequences}) < len(given.sequences):
        sys.exit("two sequences have the same name")
    output = given.output / subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", given.commit], check=True, capture_output=True, text=True).stdout.strip()
    claim(output, NOW)
    programs = {"before": built(given.commit), "now": NOW}
    drawn = [(scene, given.seed + i, None) for i in range(given.runs) for scene in SCENES]
    named = [(path.name, i, path) for i, path in enumerate(given.sequences)]
    cases = [(*case, estimator) for case in named or drawn for estimator in ("ekf", "window")]
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as workers:
        table(list(workers.map(lambda case: pair(case, programs, output), cases)))


if __name__ == "__main__":
    main()
