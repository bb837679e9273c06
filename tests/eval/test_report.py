"""The report page, from a made-up comparison: drawn in headless Chromium without an error, no figure empty, nothing undefined shown,
and whatever may be absent is allowed to be absent."""
import base64
import contextlib
import copy
import functools
import html
import io
import json
import math
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
from slammot.report import compare_report, comparison, figures, metrics, page, study_figures, study_tables, tables  # noqa: E402
from slammot.report.comparison import read_variances  # noqa: E402

page.packed = functools.cache(page.packed)  # Plotly is the same on every page
CHROMIUM = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
            "--disable-component-update", "--disable-sync", "--enable-logging=stderr", "--virtual-time-budget=30000"]
FRAMES = 600


def noisy(rng, scale):
    """An error that wanders about zero."""
    value = 0.0
    for _ in range(FRAMES):
        value += 0.08 * (rng.gauss(0.0, scale) - 0.2 * value)
        yield value


def true_position(i):
    angle = 2.0 * math.pi * i / 450
    return [10.0 * math.cos(angle) - 10.0, 0.0, 10.0 * math.sin(angle)]


def nees_block(mean, dof):
    return {"dof": dof, "used": FRAMES - 1, "covariances_not_positive_definite": 0, "mean": mean, "mean_over_dof": mean / dof, "median": mean,
            "q95": 2 * mean, "single_run_interval_95": [1.237, 14.449], "fraction_inside": min(0.95, 6 / mean)}


def made_run(estimator, landmark, scale, overconfidence, seed):
    rng = random.Random(seed)
    offsets = list(zip(*[list(noisy(rng, scale)) for _ in range(3)]))
    distance = [math.dist(offset, (0, 0, 0)) for offset in offsets]
    rmse = math.sqrt(sum(d * d for d in distance) / FRAMES)
    nees = [overconfidence * rng.gammavariate(3.0, 2.0) for _ in range(FRAMES)]
    series = {"stride": 1, "timestamp": [i / 15 for i in range(FRAMES)], "position_error_m": distance,
              "position": [[p + e for p, e in zip(true_position(i), offsets[i])] for i in range(FRAMES)],
              "rotation_error_deg": [3 * d for d in distance], "nees_pose": [None, *nees[1:]], "nees_position": nees, "nees_rotation": nees}
    filtered = {
        "accuracy": {"poses": FRAMES, "position_rmse_m": rmse, "ate_sim3_m": 0.7 * rmse, "position_max_m": max(distance),
                     "position_final_m": distance[-1], "rotation_rmse_deg": 3 * rmse},
        "nees": {"pose": nees_block(6 * overconfidence, 6), "position": nees_block(3 * overconfidence, 3)}}
    smooths = estimator == "window"
    stages = ["predict", "gate", *(["build", "solve", "marginalise", "covariances"] if smooths else ["update"]), "classify", "manage"]
    cost = [{"stage": s, "median_ms": rng.uniform(0.3, 9.0 if smooths else 4.0), "p95_ms": 12.0, "total_ms": 900.0} for s in stages]
    total = sum(c["median_ms"] for c in cost)
    name = f"{estimator}-{landmark}"
    return {
        "label": name, "folder": name, "estimator": estimator, "kind": "smoother" if smooths else "filter", "landmark": landmark,
        "overrides": {"landmark": landmark}, "configuration": {"landmark": landmark, "gate": 0.95, "classifier": "thesis"},
        "metrics": {
            "diverged": False, "divergence": None, "filtered": filtered, "smoothed": copy.deepcopy(filtered) if smooths else None,
            "classification": {
                "static": {"right": 251, "wrong": 3, "undecided": 12, "misclassified": 15 / 266},
                "moving": {"right": 201, "wrong": 5, "undecided": 30, "misclassified": 35 / 236},
                "without_truth": 0, "median_frames_to_decision": 14.0},
            "path_length_m": 41.375, "nis": {"dof": 2, "mean": 1.71, "expected_mean": 1.685},
            "coverage": {"frames_offered": FRAMES, "frames_done": FRAMES},
            "runtime": {"frame_median_ms": total, "frame_p95_ms": 1.6 * total, "frames_per_second": 900 / total, "smoothing_ms": 0.0,
                        "state_size_median": 412.0, "state_size_max": 640,
                        "stages": [*cost, {"stage": "total", "median_ms": total, "p95_ms": 30.0, "total_ms": 9000.0}]}},
        "series": {**series, "frame": list(range(FRAMES)), "nis_mean": [1.7] * FRAMES, "accepted": [40] * FRAMES, "rejected": [2] * FRAMES,
                   "state_size": [412] * FRAMES, "frame_ms": [total] * FRAMES},
        "smoothed_series": copy.deepcopy(series) if smooths else None}


def metric_row(key, path, of, name, unit="", form="real", better="smaller", expected="", on_page=True):
    return {"key": key, "path": path, "of": of, "name": name, "unit": unit, "caption": f"the {name}", "form": form,
            "decimals": 3, "better": better, "expected": expected, "on_page": on_page, "pooled": "mean"}


# Of the table of metrics what the page shows or judges, and one that nothing but the table knows.
METRICS = [
    metric_row("position_rmse_m", "accuracy.position_rmse_m", "trajectory", "position RMSE", "m"),
    metric_row("ate_sim3_m", "accuracy.ate_sim3_m", "trajectory", "ATE Sim(3)", "m"),
    metric_row("nees.pose.dof", "nees.pose.dof", "trajectory", "dof", form="count", on_page=False),
    metric_row("nees.pose.mean", "nees.pose.mean", "trajectory", "pose NEES", better="expected", expected="nees.pose.dof"),
    metric_row("nees.pose.mean_over_dof", "nees.pose.mean_over_dof", "trajectory", "ratio", on_page=False),
    metric_row("nees.pose.fraction_inside", "nees.pose.fraction_inside", "trajectory", "interval coverage", form="ratio", better="neither"),
    metric_row("nees.pose.covariances_not_positive_definite", "nees.pose.covariances_not_positive_definite", "trajectory", "failures", on_page=False),
    metric_row("nis_expected", "nis.expected_mean", "run", "expected NIS", on_page=False),
    metric_row("nis_mean", "nis.mean", "run", "NIS", better="neither", expected="nis_expected"),
    metric_row("frame_median_ms", "runtime.frame_median_ms", "run", "time per frame", "ms"),
    *(metric_row(f"lag.{lag}.{leaf}", f"lag.{lag}.{leaf}", "run", leaf, on_page=False) for lag in (0, 1, 4)
      for leaf in ("position_rmse_m", "nees_pose", "position_rmse_ratio", "nees_pose_ratio")),
    metric_row("path_length_m", "path_length_m", "run", "length of the path", "km", better="larger"),
]


def made_comparison():
    rng = random.Random(7)
    places = [[rng.uniform(-25, 5), rng.uniform(-3, 3), rng.uniform(-15, 15)] for _ in range(300)]
    landmarks = [{"track": i, "class": "static" if i % 2 else "moving", "position": place, "last": place} for i, place in enumerate(places)]
    return {"format": "slammot-compare-1", "version": "0.1.0", "command": "slammot compare --scenario circle --seed 1",
            "sequence": {"name": "circle", "path": "slammot-out/compare-circle/sequence", "sha256": "0f" * 32, "seed": 1, "frames": FRAMES,
                         "exact_truth": True, "width": 640, "height": 480, "pixel_sigma": 1.0},
            "truth": {"timestamp": [i / 15 for i in range(FRAMES)], "position": [true_position(i) for i in range(FRAMES)], "landmarks": landmarks},
            "metrics": METRICS, "runs": [made_run("ekf", "dynamic_inverse_depth", 0.16, 3.4, 1), made_run("ekf", "scaled_velocity", 0.10, 1.5, 2),
                                         made_run("window", "dynamic_inverse_depth", 0.09, 1.3, 3), made_run("window", "scaled_velocity", 0.07, 1.1, 4)]}


def trajectories(run):
    return [trajectory for trajectory in (run["metrics"]["filtered"], run["metrics"]["smoothed"]) if trajectory]


def without_truth(comparison):
    comparison["truth"] = {"timestamp": [], "position": [], "landmarks": []}
    comparison["sequence"]["exact_truth"] = False
    for run in comparison["runs"]:
        for trajectory in trajectories(run):
            trajectory.update(accuracy=None, accuracy_reason="no ground truth", nees=None, nees_reason="no ground truth")
        for kind in ("static", "moving"):
            run["metrics"]["classification"][kind].update(right=0, wrong=0, undecided=0, misclassified=None)
        for series in filter(None, (run["series"], run["smoothed_series"])):
            series.update((name, [None] * FRAMES) for name in ("position_error_m", "rotation_error_deg", "nees_pose"))


def with_measured_truth(comparison):
    """The estimates are twice too large and turned by a right angle; the errors after alignment are known."""
    comparison["sequence"]["exact_truth"] = False
    for run in comparison["runs"]:
        series = run["series"]
        series["alignment"] = {"scale": 0.5, "rotation": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], "translation": [1, 2, 3]}
        series["aligned_position_error_m"] = [0.5 * e for e in series["position_error_m"]]
        series["nees_pose"] = [None] * FRAMES
        series["position"] = [[-2 * (z - 3), 2 * (y - 2), 2 * (x - 1)] for x, y, z in series["position"]]
        for trajectory in trajectories(run):
            trajectory.update(nees=None, nees_reason="truth is not exact")


def estimator(name, rmse, anees, runs=12, failed=0):
    def interval(value):
        return {"value": value, "lower": 0.9 * value, "upper": 1.1 * value, "runs": runs}
    part = {"dof": 6, "mean": anees, "largest": 2 * anees, "lower": 0.9 * anees, "upper": 1.1 * anees, "runs": runs, "inside": 0.5, "infinite": 0}
    times = [i / 15 for i in range(1, FRAMES)]
    return {"name": name, "runs": runs, "diverged": 0, "failed": failed,
            "values": {"position_rmse_m": interval(rmse), "coverage": interval(0.97)}, "anees": {"pose": part},
            "per_frame": {"timestamp": times, "position_rmse_m": [rmse * (1 + 0.1 * math.sin(t)) for t in times],
                          "position_sigma_m": [rmse * (1 + 0.1 * math.cos(t)) for t in times],
                          "anees_pose": [anees * (1 + 0.1 * math.sin(t)) for t in times],
                          "anees_pose_lower": [4.0] * len(times), "anees_pose_upper": [8.0] * len(times)}}


def pooled(comparison):
    names = ["ekf", "ekf", "mine", "mine"]
    for i, (run, name) in enumerate(zip(comparison["runs"], names)):
        run.update(label=f"{name}-{i}", folder=f"{name}-{i}", estimator=name, landmark="", pooled=name, kind="foreign")
    comparison["sequence"].update(count=12, names=[f"circle-{seed}" for seed in range(1, 13)])
    comparison["estimators"] = [estimator("ekf", 0.12, 6.2), estimator("mine", 0.2, 9.0, failed=2)]
    comparison["pairs"] = [{"a": "ekf", "b": "mine", "metric": "position_rmse_m", "pairs": 12, "wins_a": 11, "wins_b": 1, "p": 1e-4, "p_holm": 1e-4,
                            "difference": {"value": -0.08, "lower": -0.1, "upper": -0.06, "runs": 12}}]


def diverged(run):
    run["metrics"].update(diverged=True, divergence={"frame": 120, "reason": "covariance <not> positive"})
    run["metrics"]["coverage"]["frames_done"] = 120
    run["metrics"]["filtered"]["nees"]["pose"].update(mean=None, mean_over_dof=None, covariances_not_positive_definite=3)
    for name in ("position_error_m", "nees_pose"):
        run["series"][name] = [e if e is None else e * 1.05 ** i for i, e in enumerate(run["series"][name])]


def write_run_files(folder, run, comparison):
    folder.mkdir(parents=True)
    rng = random.Random(run["label"])
    spread = rng.uniform(2e-4, 2e-3)
    names = [f"p{i}{j}" for i in range(1, 7) for j in range(i, 7)]
    with (folder / "pose_covariance.csv").open("w") as out:
        out.write("# covariance of the error\ntimestamp," + ",".join(names) + "\n")
        for time in run["series"]["timestamp"]:
            variances = {"p11": spread, "p22": 0.3 * spread, "p33": spread}
            out.write(f"{time!r}," + ",".join(str(variances.get(n, 0.0)) for n in names) + "\n")
    with (folder / "landmarks.csv").open("w") as out:
        out.write("track,frame,label,x,y,z,vx,vy,vz\n")
        for entry in comparison["truth"]["landmarks"]:
            x, y, z = (c + rng.gauss(0.0, 0.2) for c in entry["last"])
            label = "unknown" if entry["track"] % 9 == 0 else entry["class"]
            out.write(f"{entry['track']},599,{label},{x},{y},{z},nan,nan,nan\n")
        out.write("999,599,unknown,nan,nan,nan,nan,nan,nan\n")


def text_of(page):
    """What a reader sees of a page before its figures are drawn."""
    seen = re.sub(r"(?s)<(script|style)\b.*?</\1>", " ", page)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]*>", " ", seen)))


def generate(output):
    """As the program `compare_report.py OUTPUT`, in this process: the exit code, and what it says."""
    said = io.StringIO()
    with mock.patch.object(sys, "argv", ["compare_report", str(output)]), contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        return page.run_report("compare_report", compare_report.page, "compare.json", table={"action": "store_true"}), said.getvalue()


def browse(page, *arguments):
    """What Chromium makes of a page. It hangs at its start now and then, whatever the page: it is started again."""
    for patience in (60, 120, 240):
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
            try:
                return subprocess.run([*CHROMIUM, f"--user-data-dir={profile}", *arguments, page.as_uri()],
                                      capture_output=True, text=True, timeout=patience)
            except subprocess.TimeoutExpired:
                print(f"chromium hung for {patience} s", file=sys.stderr)
    raise TimeoutError(f"chromium did not open {page.name} three times")


def one_run(comparison):
    del comparison["runs"][1:]


def of_first_run(**metrics):
    return lambda comparison: comparison["runs"][0]["metrics"].update(metrics)


def every_run(change):
    return lambda comparison: [change(run) for run in comparison["runs"]]


def with_accuracies(key, *values):
    def change(comparison):
        for run, value in zip(comparison["runs"], values):
            run["metrics"]["filtered"]["accuracy"][key] = value
    return change


def made_elsewhere(comparison):
    """So that nobody counted its measurements."""
    one_run(comparison)
    run = comparison["runs"][0]
    run.update(kind="foreign", landmark="-", label="mine", estimator="mine", configuration={})
    run["metrics"]["coverage"].update(accepted=0, landmarks_admitted=0)


def ended_before_its_first_frame(comparison):
    run = comparison["runs"][0]
    diverged(run)
    run["metrics"].update(filtered={"accuracy": None, "nees": None}, nis={"mean": None}, runtime={"stages": [], "frame_median_ms": None})
    run["series"] = {name: [] if isinstance(values, list) else values for name, values in run["series"].items()}


def few_runs(comparison):
    pooled(comparison)
    comparison["estimators"] = [estimator("ekf", 0.12, 16.2, runs=3), estimator("mine", 0.2, 9.0, runs=3)]
    for e in comparison["estimators"]:
        for estimate in (*e["values"].values(), e["anees"]["pose"]):
            estimate.update(lower=None, upper=None)
    comparison["pairs"][0]["difference"].update(runs=3, lower=None, upper=None)


def some_warn(comparison):
    of_first_run(warnings=[{"frame": 12, "reason": "it is lost"}])(comparison)
    pooled(comparison)
    comparison["estimators"][0]["warned"] = 1


def on_sequences(*names):
    def change(comparison):
        pooled(comparison)
        comparison["sequence"].update(count=len(names), names=names)
    return change


def few_poses(comparison):
    """8 of 600, and the best of all by these."""
    of_first_run(failed=True, failed_at=8)(comparison)
    with_accuracies("coverage", 8 / 600)(comparison)
    with_accuracies("position_rmse_m", 1e-4)(comparison)


def in_force(comparison):
    on = {"name": "scale kept", "key": "gauge", "state": "on", "because": "", "acted": 17}
    stated = [[on], [{**on, "state": "off", "because": "ekf.iterations=3", "acted": 0}], []]
    for run, mechanisms in zip(comparison["runs"], stated):  # the last run was made elsewhere
        run["metrics"]["in_force"] = mechanisms


# A law, how a comparison is made so that it applies, what the page then says, and what it does not.
SAID = (
    ("filter and smoother are asked of both", lambda comparison: None, ["Filter or smoother? circle"], ["In force", "Frame by frame"]),
    ("one run is judged alone", one_run, [
        "Estimator judged: circle", "1 estimator on 600 frames.", "ekf · dynamic_inverse_depth has a position RMSE of"], []),
    ("a run that failed is named", of_first_run(failed=True, failed_at=77), [
        "ekf · dynamic_inverse_depth failed at frame 77: its error exceeds a tenth of the path so far, "
        "and a metre or a tenth of the whole path, whichever is less."], []),
    ("a run that failed is not called the best", of_first_run(failed=True, failed_at=77), [
        "is the most accurate"], ["ekf · dynamic_inverse_depth is the most accurate", "ekf · dynamic_inverse_depth are equally"]),
    ("a run with poses of few frames is named, and the others are compared", few_poses, [
        "has poses of 1.3% of the frames: a failed run.", "is the most accurate"], ["Not compared"]),
    ("where every run failed none is called the best", every_run(lambda run: run["metrics"].update(failed=True, failed_at=5)), [
        "Not compared: every run failed."], ["most accurate"]),
    ("few poses give no verdict of consistency", every_run(lambda run: run["metrics"]["filtered"]["nees"]["pose"].update(used=5)), [
        "over 5 poses: too few for a verdict."], ["is near what is expected", "is overconfident"]),
    ("a run that warns is named", of_first_run(warnings=[{"frame": 12, "reason": "it is lost"}]), [
        "Warned ekf · dynamic_inverse_depth, from frame 12: it is lost."], []),
    ("all runs may diverge", every_run(diverged), ["diverged at frame 120"], []),
    ("a run may end before its first frame", ended_before_its_first_frame, ["diverged at frame 120"], []),
    ("runs over other frames are not ranked", with_accuracies("coverage", 1.0, 0.95, 0.5, 1.0), [
        "Not compared, as the frames that have poses differ."], ["most accurate"]),
    ("equal runs are not ranked", with_accuracies("position_rmse_m", 0.05, 0.05), [
        "ekf · scaled_velocity are equally accurate, within 3%: position RMSE of"], ["most accurate"]),
    ("a run made elsewhere is judged", made_elsewhere, ["mine has a position RMSE of"], []),
    ("what is in force is told of each run that states it", in_force, [
        "In force", "scale kept", "on, 17", "ekf.iterations=3", "states nothing"], []),
    ("runs of an estimator are put together", pooled, [
        "4 runs of 2 estimators on 12 sequences", "Estimators judged: 12 sequences: circle-1 to circle-12 4 runs", "0.120 0.108 to 0.132",
        "More accurate (paired t tests, 5%): ekf than mine (in 11 of 12 runs).", "mine: 2 of 12 runs failed",
        "ekf is neither shown consistent nor inconsistent: ANEES of the pose 6.2 [5.58, 6.82] (6 expected)",
        "mine is overconfident: ANEES of the pose 9 [8.1, 9.9]"], ["Poses at a lag"]),
    ("few runs decide nothing", few_runs, [
        "95% interval over runs (fewer than five runs have no interval): ekf 0.12 m; mine 0.2 m.",
        "ekf: ANEES of the pose 16.2 (6 expected); fewer than five runs decide nothing.",
        "No difference is tested: fewer than five runs."], ["More accurate"]),
    ("runs that warn are counted", some_warn, ["Warned ekf: 1 of 12 runs warn. ekf-0, from frame 12: it is lost."], []),
    *((f"the title of sequences is {title}", on_sequences(*names), [f"Estimators judged: {title} 4 runs"], []) for names, title in (
        (["circle-1"], "circle"), (["circle-1", "circle-2", "circle-3"], "3 sequences: circle-1 to circle-3"),
        (["circle-3", "circle-1"], "2 sequences: circle-3, circle-1"), (["kitti", "kitti"], "2 sequences: kitti"),
        (["a-1", "a-2", "a-4", "a-5"], "4 sequences: a-1, a-2, a-4 and 1 more"))))


class Report(unittest.TestCase):
    def setUp(self):
        self.output = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.comparison = made_comparison()

    def text_of_report(self, run_files=True):
        if run_files:
            for run in self.comparison["runs"]:
                write_run_files(self.output / run["folder"], run, self.comparison)
        (self.output / "compare.json").write_text(json.dumps(self.comparison))
        self.assertEqual(generate(self.output), (0, ""))
        text = text_of((self.output / "report.html").read_text())
        self.assertNotRegex(text, r"(?i)\b(nan|none|null|inf|infinity|undefined)\b")
        return text

    def charts(self):
        page = (self.output / "report.html").read_text()
        return json.loads(re.search(r'id="charts">(.*?)</script>', page, re.DOTALL)[1])

    def assert_drawn(self, figures, lines=4):
        done = browse(self.output / "report.html", "--dump-dom")
        self.assertNotIn(":CONSOLE", done.stderr)
        self.assertIn(f'data-drawn="{len(figures)}"', done.stdout[:2000])
        for name in figures:
            start = done.stdout.index(f'id="chart-{name}"')
            figure = done.stdout[start:done.stdout.find("<h2", start)]
            marks = re.findall(r'class="(?:js-line|box)"[^>]*\bd="M[^"]{20,}|class="point"><path d="M', figure)
            self.assertGreaterEqual(len(marks), lines, f"the figure {name} is empty")

    def test_what_the_page_says(self):
        for law, change, said, unsaid in SAID:
            with self.subTest(law):
                self.comparison = made_comparison()
                change(self.comparison)
                text = self.text_of_report(run_files=False)
                self.assertEqual([words for words in said if words not in text] + [words for words in unsaid if words in text], [], text)

    def test_four_runs(self):
        text = self.text_of_report()
        self.assertIn("window · scaled_velocity is the most accurate", text)
        self.assertIn("ekf · dynamic_inverse_depth is overconfident: mean pose NEES 20.4 (6 expected)", text)
        self.assertIn("At the camera's 15 Hz", text)
        self.assertIn("1.69 expected", text)
        self.assertIn("length of the path km", text)  # a metric that only the table knows
        self.assertIn("41.375", text)
        self.assertIn("0f" * 32, text)
        self.assert_drawn(["trajectory", "position_error", "axis_errors", "error_path", "nees", "runtime"])

    def test_where_nothing_measures_the_scale_the_shape_in_the_last_one_is_beside(self):
        self.assertNotIn("last scale", self.text_of_report())
        run = self.comparison["runs"][0]
        run["metrics"]["last_scale"] = copy.deepcopy(run["metrics"]["filtered"])
        run["metrics"]["last_scale"]["accuracy"]["ate_sim3_m"] = 0.0123
        run["last_scale_series"] = copy.deepcopy(run["series"])
        text = self.text_of_report(run_files=False)
        self.assertRegex(text, r"in the last scale [0-9. –]*0\.012")
        self.assertIn("Nothing measures the scale", text)
        for chart in ("trajectory", "position_error"):
            line, = (t for t in self.charts()[chart]["data"] if "last scale" in t["name"])
            self.assertEqual((line["name"], line["visible"]), ("ekf · dynamic_inverse_depth, in the last scale", "legendonly"))

    def test_without_truth_and_without_run_files(self):
        without_truth(self.comparison)
        text = self.text_of_report(run_files=False)
        self.assertIn("Not known: the sequence has no ground truth.", text)
        self.assertIn("Not judged: no ground truth.", text)
        self.assert_drawn(["trajectory", "runtime"])

    def test_on_measured_truth_the_similarity_alignment_comes_first(self):
        with_measured_truth(self.comparison)
        text = self.text_of_report()
        self.assertIn("is the most accurate: ATE Sim(3) ", text)
        self.assertIn("images of one camera tell neither frame nor scale", text)
        self.assertLess(text.index("ATE Sim(3) m"), text.index("position RMSE m"))
        charts = self.charts()
        path = next(t for t in charts["trajectory"]["data"] if t["name"] == "ekf · scaled_velocity")
        for i in (0, 100, 300):  # where it is in the frame of the truth
            self.assertAlmostEqual(path["x"][i], true_position(i)[0], delta=0.5)
            self.assertAlmostEqual(path["y"][i], true_position(i)[2], delta=0.5)
        self.assertFalse([t for t in charts["position_error"]["data"] if "2σ" in t["name"]])
        self.assert_drawn(["trajectory", "position_error", "axis_errors", "error_path", "runtime"])

    def bold_columns(self):
        """Run to the names of the columns in which it is the best."""
        (self.output / "compare.json").write_text(json.dumps(self.comparison))
        read = comparison.read_comparison(self.output)
        names = [name for name, *_ in tables.summary_head(read)]
        return {run.label: {name for name, cell in zip(names, cells) if cell.best} for run, cells, *_ in tables.summary(read)}

    def test_no_failed_run_and_no_unaligned_error_of_measured_truth_is_bold(self):
        self.assertLessEqual({"position RMSE", "ATE Sim(3)", "pose NEES"}, self.bold_columns()["window-scaled_velocity"])
        of_last = self.comparison["runs"][-1]["metrics"]
        of_last.update(failed=True, failed_at=1)
        bold = self.bold_columns()
        self.assertEqual(bold["window-scaled_velocity"], set())
        self.assertIn("position RMSE", bold["window-dynamic_inverse_depth"])
        of_last.update(failed=False, failed_at=None)
        self.comparison["sequence"]["exact_truth"] = False
        bold = set.union(*self.bold_columns().values())
        self.assertIn("ATE Sim(3)", bold)
        self.assertFalse(bold & {"position RMSE", "pose NEES"})

    def test_no_cell_with_failed_runs_is_bold_in_a_paper(self):
        self.assertTrue(study_tables.competes({"diverged": [], "lost": []}))
        self.assertFalse(study_tables.competes({"diverged": [], "lost": [{"seed": 1, "frame": 7}]}))
        table = metrics.read_table(METRICS)
        values = [{"value": 0.1}, {"value": 0.2}]
        self.assertEqual(study_tables.best_of("position_rmse_m", values, table), 0.1)
        self.assertIsNone(study_tables.best_of("position_rmse_m", values, table, aligned=True))
        self.assertEqual(study_tables.best_of("ate_sim3_m", values, table, aligned=True), 0.1)

    def test_poses_at_a_lag_of_who_keeps_them(self):
        pooled(self.comparison)
        kept = self.comparison["estimators"][1]["values"]
        for key, value in (("0.position_rmse_m", 0.2), ("4.position_rmse_m", 0.19), ("1.position_rmse_ratio", 0.9), ("4.position_rmse_ratio", 0.5),
                           ("4.nees_pose_ratio", 1.1)):
            kept[f"lag.{key}"] = {"value": value, "lower": 0.9 * value, "upper": 1.2 * value, "runs": 12}
        self.assertIn("Poses at a lag", self.text_of_report())
        of_mine = [t for t in self.charts()["lag"]["data"] if t["name"] == "mine"]
        self.assertEqual([(t["x"], t["y"], t["xaxis"]) for t in of_mine], [([2, 5], [0.9, 0.5], "x"), ([5], [1.1], "x3")])
        self.assertAlmostEqual(of_mine[0]["error_y"]["array"][1], 0.1)
        self.assertFalse([t for t in self.charts()["lag"]["data"] if t["name"] == "ekf"])
        self.assert_drawn(["distribution", "trajectory", "position_error", "axis_errors", "error_path", "nees", "lag", "runtime"], lines=2)
        with_measured_truth(self.comparison)
        self.assertNotIn("Poses at a lag", self.text_of_report(run_files=False))

    def test_what_is_in_force_in_some_runs_of_a_cell_is_counted(self):
        mechanism = {"name": "scale kept", "key": "gauge", "on": 3, "runs": 10, "because": "", "acted": 40}
        off = {**mechanism, "on": 0, "because": "ekf.iterations=3"}
        group = {"cells": [{"in_force": [mechanism]}, {"in_force": [off]}, {"in_force": []}, {}]}
        self.assertEqual(study_tables.in_force(group), [("scale kept", "gauge", [
            ("on in 3 of 10, 40", ""), ("off", "ekf.iterations=3"), ("states nothing", ""), ("–", "")])])

    def test_settings_of_one_estimator_are_told_apart(self):
        ekf, window, more = self.comparison["runs"][:3]
        for run, estimator, error in ((ekf, "ekf", 0.04), (window, "window", 0.03), (more, "ekf", 0.08)):
            run.update(estimator=estimator, landmark="scaled_velocity")
            run["metrics"]["filtered"]["accuracy"]["position_rmse_m"] = error
        more["overrides"] = {"ekf.iterations": "3", "landmark": "scaled_velocity"}
        self.comparison["runs"] = [ekf, window, more]
        self.assertIn("With scaled_velocity, the error of window is 25% smaller than that of ekf, each with the best of its settings.",
                      self.text_of_report())
        ekf["metrics"]["filtered"]["accuracy"]["position_rmse_m"] = 0.1
        self.assertIn("With scaled_velocity, the error of window is 62% smaller than that of ekf (ekf.iterations = 3), each",
                      self.text_of_report(run_files=False))
        self.comparison["runs"] = [ekf, more]
        self.assertNotIn("With scaled_velocity", self.text_of_report(run_files=False))

    def test_labels_are_counted_where_no_truth_is_known(self):
        without_truth(self.comparison)
        folder = self.output / self.comparison["runs"][0]["folder"]
        folder.mkdir()
        rows = ["1,-,static,4,4", "2,-,static,5,5", "3,-,moving,5,5", "4,-,unknown,,9"]
        (folder / "classification.csv").write_text("\n".join(["track,truth,label,frame,observations", *rows]) + "\n")
        text = self.text_of_report(run_files=False)
        self.assertIn("static moving unknown truth not known 2 1 1", text)

    def test_the_map_frames_the_path_not_the_farthest_point(self):
        self.comparison["truth"]["landmarks"][0]["last"] = [600.0, 0.0, -600.0]
        self.text_of_report()
        trajectory = self.charts()["trajectory"]
        for name in ("xaxis", "yaxis"):
            low, high = trajectory["layout"][name]["range"]
            self.assertGreater(low, -40.0)
            self.assertLess(high, 40.0)
        marks = [t for t in trajectory["data"] if t["mode"] == "markers"]
        self.assertTrue(all(t["marker"]["size"] >= 6 and len(set(t["marker"]["symbol"])) > 1 for t in marks))

    def test_a_diverged_run_is_named_and_does_not_set_the_scale(self):
        diverged(self.comparison["runs"][0])
        text = self.text_of_report()
        self.assertIn("ekf · dynamic_inverse_depth diverged at frame 120 (covariance <not> positive)", text)
        errors = self.comparison["runs"][1]["series"]["position_error_m"]
        top = self.charts()["position_error"]["layout"]["yaxis"]["range"][1]
        self.assertLess(top, 3 * max(errors))
        self.assert_drawn(["trajectory", "position_error", "axis_errors", "error_path", "nees", "runtime"])

    def test_each_axis_stands_beside_what_is_stated_of_it(self):
        self.text_of_report()
        run = self.comparison["runs"][1]
        data = self.charts()["axis_errors"]["data"]
        for k, panel in enumerate(("y", "y2", "y3")):
            error, bounds = (next(t for t in data if t["name"] == name and t["yaxis"] == panel) for name in ("ekf · scaled_velocity", "ekf · scaled_velocity: 3σ"))
            for i in (1, 77, 599):
                self.assertAlmostEqual(error["y"][i], true_position(i)[k] - run["series"]["position"][i][k])
            variances = read_variances(self.output / run["folder"] / "pose_covariance.csv")[run["series"]["timestamp"][77]]
            self.assertAlmostEqual(bounds["y"][77], 3 * math.sqrt(variances[k]))
            self.assertAlmostEqual(bounds["y"][77 + FRAMES + 1], -3 * math.sqrt(variances[k]))  # after a gap, below zero
        rotation = next(t for t in data if t["yaxis"] == "y4")
        self.assertEqual(rotation["y"], self.comparison["runs"][0]["series"]["rotation_error_deg"])
        self.assertEqual(sum(t["showlegend"] for t in data), 4)  # one entry a run

    def test_errors_of_another_sequence_than_the_first_are_not_measured_by_its_truth(self):
        pooled(self.comparison)
        for other in ({"name": "circle-2", "sha256": "0f" * 32}, {"name": "circle", "sha256": "1e" * 32}):
            for run in self.comparison["runs"]:
                run["sequence"] = {"name": "circle", "sha256": "0f" * 32} if run["pooled"] == "ekf" else other
            self.text_of_report(run_files=False)
            for name in ("axis_errors", "error_path"):
                self.assertEqual({t["name"] for t in self.charts()[name]["data"]} - {"truth"}, {"ekf-0"})

    def test_a_path_has_the_colours_of_its_error(self):
        run = self.comparison["runs"][0]
        run["metrics"].update(failed=True, failed_at=50)
        run["series"]["position_error_m"] = [100.0 * e for e in run["series"]["position_error_m"]]
        self.text_of_report(run_files=False)
        figure = self.charts()["error_path"]
        paths = [t for t in figure["data"] if t["mode"] == "markers"]
        self.assertEqual([t["marker"]["color"] for t in paths], [run["series"]["position_error_m"] for run in self.comparison["runs"]])
        self.assertEqual(figure["layout"]["coloraxis"]["cmax"], max(e for run in self.comparison["runs"][1:] for e in run["series"]["position_error_m"]))

    def test_where_a_run_failed_is_marked_on_the_axis(self):
        failed, lost = self.comparison["runs"][1:3]
        failed["metrics"].update(failed=True, failed_at=77)
        diverged(lost)
        self.text_of_report(run_files=False)
        for name in ("position_error", "axis_errors", "nees"):
            marks = {m["hovertext"]: m for m in self.charts()[name]["layout"]["annotations"]}
            self.assertEqual({text: m["x"] for text, m in marks.items()}, {
                "ekf · scaled_velocity failed at frame 77": 77 / 15, "window · dynamic_inverse_depth diverged at frame 120": 120 / 15})
            self.assertEqual({m["y"] for m in marks.values()}, {0})
        self.comparison = made_comparison()
        self.text_of_report(run_files=False)
        self.assertNotIn("annotations", self.charts()["nees"]["layout"])

    def test_ticks_of_logarithmic_axes_are_plain_numbers(self):
        self.assertEqual(figures.log_ticks([0.3, 40.0])["ticktext"], ["0.1", "0.2", "0.5", "1", "2", "5", "10", "20", "50", "100", "200", "500"])
        self.assertEqual(figures.log_ticks([0.5, 2e4])["ticktext"], ["0.1", "1", "10", "100", "1,000", "10,000", "100,000"])
        wide = figures.log_ticks([1e-3, 1e15])
        self.assertLess(len(wide["tickvals"]), 10)
        self.assertIn("10<sup>9</sup>", wide["ticktext"])

    def test_every_run_of_an_estimator_is_a_point_of_its_box(self):
        pooled(self.comparison)
        diverged(self.comparison["runs"][1])
        self.comparison["runs"][2]["metrics"].update(failed=True, failed_at=3)
        self.text_of_report(run_files=False)
        boxes = {(t["name"], t["xaxis"]): t for t in self.charts()["distribution"]["data"]}
        of = [run["metrics"]["filtered"] for run in self.comparison["runs"]]
        self.assertEqual(boxes["ekf", "x"]["x"], [of[0]["accuracy"]["position_rmse_m"]])
        self.assertEqual(boxes["mine", "x"]["x"], [run["accuracy"]["position_rmse_m"] for run in of[2:]])
        self.assertEqual(boxes["mine", "x2"]["x"], [run["nees"]["pose"]["mean"] for run in of[2:]])
        self.assertEqual([text.endswith(", failed") for text in boxes["mine", "x"]["text"]], [True, False])
        self.comparison = made_comparison()
        self.text_of_report(run_files=False)
        self.assertNotIn("distribution", self.charts())

    def test_one_pair_of_runs_is_no_table_above_the_summary(self):
        pooled(self.comparison)
        self.assertIn("Paired differences", self.text_of_report(run_files=False))
        self.comparison["pairs"][0].update(pairs=1, wins_a=1, wins_b=0)
        self.assertNotIn("Paired differences", self.text_of_report(run_files=False))

    def test_pictures_are_carried_in_the_page(self):
        slider = self.output / self.comparison["runs"][0]["label"] / "pictures" / "slider"
        slider.mkdir(parents=True)
        for frame in (0, 12):
            (slider / f"{frame:06}.jpg").write_bytes(b"picture %d" % frame)
        self.assertIn("Frame by frame", self.text_of_report(run_files=False))
        page = (self.output / "report.html").read_text()
        self.assertIn(base64.b64encode(b"picture 12").decode(), page)

    def test_the_same_input_gives_the_same_bytes(self):
        self.text_of_report()
        first = (self.output / "report.html").read_bytes()
        done = subprocess.run(["/usr/bin/python3", "-B", "-m", "slammot.report", "compare", self.output], capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": str(ROOT / "python")})
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        self.assertEqual(first, (self.output / "report.html").read_bytes())

    def assert_refused(self, content):
        """In one line, printable."""
        if content is not None:
            (self.output / "compare.json").write_text(content)
        code, said = generate(self.output)
        self.assertEqual(code, 2)
        self.assertRegex(said, r"\Acompare_report: [ -~]*compare\.json: [ -~]*\n\Z")

    def test_what_no_comparison_is_is_refused(self):
        shapes = ({"runs": 5}, {"sequence": []}, {"metrics": "x"}, {"truth": [1]}, {"runs": [{"label": "a\n\x1b[31m"}]})
        for content in (None, "{", "[]", '{"format": "other"}', '{"format": "slammot-compare-1"}', '{"format": "slammot-compare-1", "a\n\x1b[31m',
                        "[" * 100000, *(json.dumps(self.comparison | shape) for shape in shapes)):
            with self.subTest(content=str(content)[:40]):
                self.assert_refused(content)

    def test_a_pipe_is_no_comparison_and_no_page(self):
        os.mkfifo(self.output / "compare.json")
        self.assert_refused(None)
        os.mkfifo(self.output / "report.html")
        code, said = generate(self.output)
        self.assertEqual(code, 2)
        self.assertIn("report.html: was not written by slammot", said)

    def test_a_figure_is_there_whole_or_not_at_all(self):
        file = self.output / "anees.png"
        file.write_text("before")

        def full(unfinished, **_):
            unfinished.write_text("hal")
            raise OSError(28, "No space left on device")

        with self.assertRaisesRegex(page.NotMade, "anees.png: cannot be written: No space left on device"):
            study_figures.save(mock.Mock(savefig=full), file)
        self.assertEqual([(path.name, path.read_text()) for path in self.output.iterdir()], [("anees.png", "before")])


if __name__ == "__main__":
    unittest.main()
