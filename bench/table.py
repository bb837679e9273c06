"""One table of the benchmarks' figures, ratios of one run where not said otherwise, beside bars.

scripts/bench calls it. What the benchmarks printed is kept in slammot-out/bench.json.
"""
import argparse
import json
import os
import pathlib
import subprocess
import tempfile
import time

STUDY = """
format: slammot-study-1
name: bench
title: bench
runs: 64
scenarios: [{scenario: circle}]
estimators: [{estimator: ekf}]
"""


def run_benchmarks(build):
    """name -> counters, of slammot_bench."""
    output = subprocess.run([build / "slammot_bench", "--benchmark_filter=-large_map",
                             "--benchmark_format=json"], check=True,
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    bench = {b["run_name"].split("/iterations")[0]: b for b in json.loads(output)["benchmarks"]}
    for name, b in bench.items():
        if b.get("error_occurred"):
            raise SystemExit(f"{name}: {b['error_message']}")
    return bench


def time_study(build, folder, jobs):
    """Seconds and megabytes of half of a study; a shard makes no report."""
    study = folder / "study.yaml"
    study.write_text(STUDY)
    begin = time.monotonic()
    process = subprocess.Popen([build / "slammot", "study", study, "--jobs", str(jobs),
                                "--shard", "1/2", "--output", folder / f"jobs-{jobs}"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise RuntimeError(f"the study ended with status {status}")
    return time.monotonic() - begin, usage.ru_maxrss / 1024


def studies(build):
    """How much faster two jobs are than one, and the megabytes of a job."""
    with tempfile.TemporaryDirectory() as name:
        (one, _), (two, megabytes) = (time_study(build, pathlib.Path(name), jobs)
                                      for jobs in (1, 2))
    return one / two, megabytes / 2


# Of a window on `circle` that keeps a dense prior, counted for windows of 10 and 20 frames, on average a frame [Mflop].
NEEDED = {"window": 77, "window_20": 145}


def rows(bench, speed_up, megabytes):
    """(what, measured, relation, bar or None)."""
    for n in (300, 600, 1000, 2000, 3000):
        b = bench[f"ekf_frame/{n}"]
        yield (f"EKF frame / dsyrk, n = {b['n']:.0f}, m = {b['m']:.0f}", b["ratio"], "<=", 1.5)
    ekf, window = bench["circle/ekf"], bench["circle/window"]
    yield "classification / frame, EKF, circle", ekf["classification_share"], "<=", 0.02
    yield "velocity marginals / frame, window, circle", window["classification_share"], "<=", 0.15
    yield "what becomes static / frame, EKF, circle", ekf["collapse_share"], "", None
    yield "what becomes static / frame, window, circle", window["collapse_share"], "", None
    yield ("window 10 / EKF, circle, default map", window["real_time"] / ekf["real_time"], "<=", 10)
    for name, megaflops in NEEDED.items():
        bound = megaflops / bench["dgemm"]["megaflops_per_ms"]
        frames = bench[f"circle/{name}"]["real_time"]
        yield f"{name.replace('_', ' ')}, circle: frame / {megaflops} Mflop at dgemm's rate", frames / bound, "<=", 2.5
    lengths = {k: bench[f"window_frame/30/{k}"] for k in (5, 10, 20, 40)}
    yield "window 10 / EKF, 30 in view, no map", lengths[10]["ratio"], "<=", 10
    for short in (5, 10, 20):
        growth = lengths[2 * short]["total"] / lengths[short]["total"]
        yield f"window {2 * short} / window {short}", growth, "<=", 2
    for visible in (17, 30):
        b = bench[f"static_window/{visible}"]
        yield (f"static window, {visible} in view: RMSE / converged",
               b["rmse"] / b["rmse_converged"], "<=", 1.05)
    yield "circle, EKF: frames a second", ekf["frames_per_second"], ">=", 300
    yield "circle, window 10: frames a second", window["frames_per_second"], ">=", 60
    for estimator in ("ekf", "window"):
        base = bench[f"map_size/{estimator}/50"]["total"]
        for size in (100, 200, 500, 1000):
            b = bench[f"map_size/{estimator}/{size}"]
            yield f"{estimator}, map of {size} / map of 50", b["total"] / base, "", None
    yield "study, 2 jobs: times as fast as 1", speed_up, ">=", 1.8
    yield "study: MB a job", megabytes, "<", 200


def verdict(value, relation, bar):
    if bar is None:
        return ""
    met = {"<=": value <= bar, ">=": value >= bar, "<": value < bar}[relation]
    return "met" if met else "NOT MET"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, required=True, help="with slammot_bench")
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path("slammot-out"))
    arguments = parser.parse_args()
    bench = run_benchmarks(arguments.build)
    table = list(rows(bench, *studies(arguments.build)))
    arguments.output.mkdir(parents=True, exist_ok=True)
    kept = arguments.output / "bench.json"
    kept.write_text(json.dumps({"load": os.getloadavg(), "benchmarks": bench,
                                "table": table}, indent=1))
    print(f"{'':58}{'measured':>10}  {'bar':>8}")
    for what, value, relation, bar in table:
        limit = f"{relation} {bar:g}" if bar is not None else ""
        print(f"{what:58}{value:10.3g}  {limit:>8}  {verdict(value, relation, bar)}")
    print(kept)


if __name__ == "__main__":
    main()
