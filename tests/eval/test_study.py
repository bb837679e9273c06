"""slammot study, as a user runs it: the same bytes whether interrupted, on one thread or two, in one piece or in shards;
and its report drawn in headless Chromium without an error.

usage: test_study.py SLAMMOT [Study | Strangers | Page | Recordings]
"""
import csv
import json
import math
import re
import shutil
import subprocess
import time
import unittest

from fixture import SLAMMOT, WithFolder, program
from test_report import browse

STUDY = """\
format: slammot-study-1
name: small
runs: 4
scenarios:
  - {scenario: helix, set: {frames: 24}}
  - {scenario: helix, label: short helix, set: {frames: 12}}
estimators:
  - {estimator: ekf}
  - {estimator: window, label: window 3, set: {window.frames: 3}}
sweep: {classifier.static_threshold: [0.8, 1.6]}
record: {tracks: [1, 2]}
"""
FIGURES = ["camera_error", "landmark_error", "classification", "classification_against_sweep", "velocity", "trade_off",
           "anees", "landmark_anees", "anees_by_age", "error_axes", "against_sweep:position_rmse_m", "against_sweep:anees_pose",
           "against_sweep:frame_median_ms"]
LATEX = """\
latex:
  columns: [position_rmse_m, anees_pose, frame_median_ms]
  labels: {ekf: "EKF & co", position_rmse_m: "RMSE [m]"}
  caption: "100% of the runs"
"""


class WithStudy(WithFolder):
    TEXT = STUDY

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.study = cls.folder / "small.yaml"
        cls.study.write_text(cls.TEXT, encoding="utf-8")
        cls.whole = cls.folder / "whole"
        program("study", cls.study, "--jobs", 2, "--output", cls.whole)
        cls.expected = (cls.whole / "results.jsonl").read_bytes()

    def same(self, folder):
        """And what is said of them is the same, but for what made them and the clock."""
        self.assertEqual((folder / "results.jsonl").read_bytes(), self.expected)
        self.assertEqual(self.said_of(folder), self.said_of(self.whole))

    @staticmethod
    def said_of(folder):
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        del summary["provenance"]
        for group in summary["groups"]:
            for cell in group["cells"]:
                del cell["timing"]
        return json.dumps(summary)


class Study(WithStudy):
    TEXT = STUDY.replace("frames: 24", "frames: 10").replace("frames: 12", "frames: 8")  # it runs six times, also under sanitizers

    def test_every_run_is_there_once(self):
        runs = [json.loads(line) for line in self.expected.splitlines()]
        self.assertEqual([(r["cell"], r["seed"]) for r in runs], [(c, s) for c in range(8) for s in range(1, 5)])
        self.assertTrue(all(r["diverged"] is None for r in runs))

    def test_what_made_it_is_in_the_summary_and_on_the_page(self):
        made_by = json.loads((self.whole / "summary.json").read_text(encoding="utf-8"))["provenance"]
        self.assertEqual(made_by["jobs"], 2)
        self.assertIn(made_by["commit"], (self.whole / "report.html").read_text(encoding="utf-8"))
        self.assertIn(made_by["cpu"], (self.whole / "report.html").read_text(encoding="utf-8"))

    def test_one_job_or_two(self):
        program("study", self.study, "--jobs", 1, "--output", self.folder / "one_job")
        self.same(self.folder / "one_job")

    def test_three_shards_in_folders_of_their_own(self):
        folders = [self.folder / f"shard{i}" for i in (1, 2, 3)]
        for i, folder in enumerate(folders, 1):
            program("study", self.study, "--shard", f"{i}/3", "--output", folder)
        merged = self.folder / "merged"
        missing = program("study", self.study, "--output", merged, "--merge", *folders[:2], code=2)
        self.assertIn("a run is missing", missing.stderr)
        program("study", self.study, "--output", merged, "--merge", *folders)
        self.same(merged)

    def test_more_runs_are_added_to_those_there_are(self):
        folder = self.folder / "more"
        program("study", self.study, "--runs", 2, "--output", folder)
        more = program("study", self.study, "--runs", 4, "--resume", "--output", folder)
        self.assertIn("16 runs done", more.stdout)
        self.same(folder)

    def test_what_is_there_is_not_overwritten(self):
        self.assertIn("--resume", program("study", self.study, "--output", self.whole, code=2).stderr)
        other = self.folder / "other.yaml"
        other.write_text(STUDY.replace("frames: 24", "frames: 41"), encoding="utf-8")
        self.assertIn("another study", program("study", other, "--resume", "--output", self.whole, code=2).stderr)

    def test_a_bad_study_is_refused_in_one_line(self):
        bad = self.folder / "bad.yaml"
        for text, wrong in (("runs: 4", "runs: none"), ("estimator: ekf", "estimator: kalman"), ("frames: 24", "frame_count: 24"),
                            ("name: small", "nam: small"), ("window.frames: 3", "window.frame: 3"), ("slammot-study-1", "slammot-study-9"),
                            ("scenario: helix", "scenario: helicoid"), *(("record: {tracks: [1, 2]}", wrong) for wrong in (
                                "figures: [camera]", "figures: ['against_sweep:rmse']", "figures: [ranking]",
                                "latex: {columns: [rmse]}", "latex: {columns: []}"))):
            bad.write_text(STUDY.replace(text, wrong, 1), encoding="utf-8")
            error = program("study", bad, "--output", self.folder / "bad", code=2).stderr
            self.assertIn("bad.yaml", error)
            self.assertTrue("ideal_covariance" in error or "ranking" not in wrong, error)
            self.assertFalse((self.folder / "bad").exists())


class Strangers(WithStudy):
    def test_two_processes_compute_no_run_twice(self):
        folder = self.folder / "two"
        command = [SLAMMOT, "study", str(self.study), "--jobs", "1", "--resume", "--output", str(folder)]
        first = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        journal = folder / "journal-1-of-1.jsonl"
        while not (journal.exists() and journal.read_bytes().count(b"\n") > 1):
            time.sleep(0.005)
        self.assertIn("another process", program(*command[1:], code=2).stderr)
        self.assertIn("another process", program("study", self.study, "--shard", "1/2", "--output", folder, code=2).stderr)
        self.assertEqual(first.wait(), 0)
        self.assertEqual(journal.read_bytes().count(b"\n"), 1 + 32)
        self.same(folder)

    def test_processes_that_begin_at_once(self):
        """In a folder that is not there, or empty but for the name that another one tries whether it can write there."""
        for attempt in range(4):
            folder = self.folder / f"at_once_{attempt}" / "new"
            if attempt % 2:
                (folder / ".slammot-abcdef").mkdir(parents=True)
            shards = [subprocess.Popen([SLAMMOT, "study", str(self.study), "--runs", "1", "--resume", "--shard", f"{i}/6", "--output", str(folder)],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for i in range(1, 7)]
            for shard in shards:
                self.assertEqual((shard.communicate()[1], shard.returncode), ("", 0))

    def test_a_line_that_is_no_run_is_refused(self):
        folder = shutil.copytree(self.whole, self.folder / "damaged")
        journal = folder / "journal-1-of-1.jsonl"
        journal.write_text(journal.read_text(encoding="utf-8").replace('"static":[', '"static":[1,', 1), encoding="utf-8")
        self.assertRegex(program("study", self.study, "--merge", "--output", folder, code=2).stderr, r"results\.jsonl:\d+: ")

    def test_what_cannot_run_is_charged_to_nobody(self):
        impossible, folder = self.folder / "impossible.yaml", self.folder / "frames.first"
        impossible.write_text(STUDY.replace("set: {window.frames: 3}", "set: {window.frames: 3, frames.first: 100}"), encoding="utf-8")
        self.assertIn("leave no frame of", program("study", impossible, "--runs", 1, "--output", folder, code=2).stderr)
        self.assertNotIn('"diverged":{', (folder / "journal-1-of-1.jsonl").read_text(encoding="utf-8"))

    def test_runs_of_another_configuration_are_refused(self):
        mine, other, text = self.folder / "mine", self.folder / "other", self.folder / "of_other.yaml"
        text.write_text(STUDY.replace("frames: 24", "frames: 39"), encoding="utf-8")
        program("study", self.study, "--shard", "1/2", "--runs", 1, "--output", mine)
        program("study", text, "--shard", "2/2", "--runs", 1, "--output", other)
        shutil.copy(other / "journal-2-of-2.jsonl", mine)
        for command in (["--merge"], ["--merge", "--force"], ["--resume"]):
            said = program("study", self.study, "--runs", 1, "--output", mine, *command, code=2).stderr
            self.assertIn("journal-2-of-2.jsonl:1: these runs are of another configuration", said)

    def test_runs_of_another_build_are_refused(self):
        folder = shutil.copytree(self.whole, self.folder / "rebuilt")
        journal = folder / "journal-1-of-1.jsonl"
        lines = journal.read_text(encoding="utf-8").splitlines(keepends=True)
        head = json.loads(lines[0])
        head["journal"]["program"] = "0" * 64
        journal.write_text("".join([json.dumps(head) + "\n", *lines[1:9]]), encoding="utf-8")
        for command in ("--resume", "--merge"):
            self.assertIn("another build", program("study", self.study, command, "--output", folder, code=2).stderr)
        more = program("study", self.study, "--resume", "--force", "--output", folder)
        self.assertIn("24 runs done", more.stdout)
        heads = [line for line in journal.read_text(encoding="utf-8").splitlines() if line.startswith('{"journal"')]
        self.assertEqual(len(heads), 2)
        self.same(folder)


class Page(WithStudy):
    # Of one scenario and two runs: each group is a row of every figure. What is swept changes the ANEES.
    TEXT = STUDY.replace("  - {scenario: helix, label: short helix, set: {frames: 12}}\n", "").replace("runs: 4", "runs: 2")
    TEXT = TEXT.replace("classifier.static_threshold: [0.8, 1.6]", "gate.probability: [0.5, 0.99]")
    TEXT += f"figures: [{', '.join(FIGURES)}, lag]\n{LATEX}"
    GROUPS = 2  # of two estimators

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.page = (cls.whole / "report.html").read_text(encoding="utf-8")
        cls.groups = json.loads((cls.whole / "summary.json").read_text(encoding="utf-8"))["groups"]
        cls.cells = [cell for group in cls.groups for cell in group["cells"]]

    def table(self, name):
        return (self.whole / "tables" / name).read_text(encoding="utf-8")

    def opened(self, page):
        """The page's elements as headless Chromium leaves them. Its log does not tell errors from remarks: the page is made to."""
        listener = """<head><script>{
          const note = (text) => { document.documentElement.dataset.consoleErrors = (document.documentElement.dataset.consoleErrors ?? "") + text; };
          console.error = note;
          addEventListener("error", (event) => note(event.message));
          addEventListener("unhandledrejection", (event) => note(event.reason));
        }</script>"""
        self.assertEqual(page.count("<head>"), 1)
        file = self.folder / "opened.html"
        file.write_text(page.replace("<head>", listener), encoding="utf-8")
        done = browse(file, "--dump-dom")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_a_table_for_a_paper_has_own_labels_and_the_best_of_each_scenario_in_bold(self):
        latex = self.table("paper.tex")
        self.assertIn(r"\caption{100\% of the runs}", latex)
        self.assertIn("RMSE [m] & ANEES pose & time per frame [ms]", latex)
        rows = [line for line in latex.splitlines() if "EKF" in line or "window 3" in line]
        self.assertEqual(len(rows), 2 * self.GROUPS)
        for group, ekf, window in zip(self.groups, rows[::2], rows[1::2]):
            self.assertIn(r"EKF \& co", ekf)
            a, b = (cell["filtered_position_rmse_m"]["value"] for cell in group["cells"])
            self.assertEqual([r"\textbf" in row.split("&")[-3] for row in (ekf, window)], [a < b, b < a])

    def test_verdict_and_colours(self):
        self.assertLess(self.page.index('class="verdict"'), self.page.index("<table"))
        self.assertIn("Each seed is another simulation of the scenario.", self.page)
        verdict = self.page[self.page.index('class="verdict"'):self.page.index("<table")]
        self.assertRegex(verdict, r"ekf: ANEES of the pose [\d.]+ to [\d.]+ \(6 expected\), .* fewer than five runs decide nothing")
        self.assertIn("No difference is tested: fewer than five runs.", self.page)
        # No ANEES: so few runs have no interval.
        over = sum(bool(cell["lost"]) + bool(cell["diverged"]) + bool((cell.get("failed_silently") or {}).get("value")) for cell in self.cells)
        summary = self.page[self.page.index("<h2>Summary"):self.page.index("<h2>", self.page.index("<h2>Summary") + 4)]
        self.assertEqual(summary.count('<td class="over">'), over)
        self.assertEqual(summary.count('rowspan="2"'), self.GROUPS)

    def test_why_runs_warn(self):
        """A gate that is half closed is one reason. What a run says is in its line, in the summary and on the page."""
        runs = [json.loads(line) for line in self.expected.splitlines()]
        warning = [run for run in runs if run["warnings"]]
        self.assertEqual([seen["warnings"] for cell in self.cells for seen in cell["warnings"]], [run["warnings"] for run in warning])
        self.assertEqual([cell["warned"]["value"] for cell in self.cells], [len(cell["warnings"]) / cell["runs"] for cell in self.cells])
        half_closed = [run for run in warning if any("were rejected" in w["reason"] for w in run["warnings"])]
        self.assertGreaterEqual(len(half_closed), 2)
        self.assertLess(len(warning), len(runs))
        self.assertIn("runs warn, those that diverged aside; why is in the table Warnings", self.page)
        table = self.table("warnings.csv")
        for run in warning:
            self.assertIn(f'seed {run["seed"]}: from frame {run["warnings"][0]["frame"]}, {run["warnings"][0]["reason"]}', table)

    def test_figures_and_tables(self):
        for name in ("distributions", *FIGURES):
            for ending in ("pdf", "svg", "png"):
                self.assertGreater((self.whole / "figures" / f"{name.replace(':', '_')}.{ending}").stat().st_size, 5000)
        for name, rows in (("summary", 2), ("consistency", 10), ("classification", 4), ("pairs", 1), ("metrics", 2), ("coverage", 2)):
            lines, latex = self.table(f"{name}.csv").splitlines(), self.table(f"{name}.tex")
            self.assertEqual(len(lines), 1 + self.GROUPS * rows, name)
            self.assertNotIn("nan", "".join(lines).lower().replace("anees", ""))
            for part in (r"\begin{tabular}", r"\toprule", r"\midrule", r"\bottomrule"):
                self.assertIn(part, latex)
            self.assertNotIn(r"\hline", latex)

    def test_the_page_is_drawn_without_an_error(self):
        dom = self.opened(self.page)
        self.assertNotIn("data-console-errors", dom)
        errors = self.opened("<!doctype html><html><head></head><script>console.error('said')</script><script>oops()</script></html>")
        self.assertRegex(errors, 'data-console-errors="said.*oops')
        self.assertIn('data-drawn="1"', dom)
        self.assertNotIn("data-error", dom)
        landmarks, marks = (int(re.search(f'data-{what}="([0-9]+)', dom)[1]) for what in ("landmarks", "marks"))
        self.assertGreater(landmarks, 10)
        self.assertGreater(marks, landmarks)  # what Plotly holds
        self.assertEqual(dom.count('<img src="data:image/svg+xml;base64,'), len(FIGURES) + 1)  # the distributions, unasked

    def test_poses_at_a_lag(self):
        """Of the estimators that keep past poses, judged over the same frames at each lag; the others have none."""
        study = self.folder / "lag.yaml"
        study.write_text("""format: slammot-study-1
name: lag
runs: 2
scenarios: [{scenario: helix, set: {frames: 50}}]
estimators:
  - {estimator: ekf}
  - {estimator: ekf, label: ekf lag 3, set: {ekf.lag: 3}}
  - {estimator: window, label: window 3, set: {window.frames: 3}}
figures: [lag]
""", encoding="utf-8")
        folder = self.folder / "lag"
        program("study", study, "--output", folder)
        kept = list(csv.DictReader((folder / "runs.csv").read_text(encoding="utf-8").splitlines()))
        for cell in json.loads((folder / "summary.json").read_text(encoding="utf-8"))["groups"][0]["cells"][1:]:
            for quantity, ratio in (("position_rmse_m", "position_rmse_ratio"), ("nees_pose", "nees_pose_ratio")):
                of_runs = [float(run[f"lag.2.{quantity}"]) / float(run[f"lag.0.{quantity}"]) for run in kept if run["label"] == cell["label"]]
                self.assertEqual(len(of_runs), 2)
                self.assertAlmostEqual(cell[f"lag.2.{ratio}"]["value"], sum(of_runs) / 2, delta=1e-9)
        rows = [line.split(",")[1:3] for line in (folder / "tables" / "lags.csv").read_text(encoding="utf-8").splitlines()]
        self.assertEqual(rows, [["estimator", "lag [frames]"], *([label, lag] for label in ("ekf lag 3", "window 3") for lag in "012")])
        self.assertNotIn("lag", (folder / "tables" / "metrics.csv").read_text(encoding="utf-8").splitlines()[0])
        self.assertGreater((folder / "figures" / "lag.png").stat().st_size, 5000)
        self.assertIn("<h2>Poses at a lag</h2>", (folder / "report.html").read_text(encoding="utf-8"))

    def test_without_lags_none_are_drawn(self):
        """The runs are shorter than the longest."""
        self.assertFalse((self.whole / "figures" / "lag.png").exists())
        self.assertFalse((self.whole / "tables" / "lags.csv").exists())
        self.assertNotIn("Poses at a lag", self.page)


class Recordings(WithFolder):
    @classmethod
    def setUpClass(cls):
        """A sequence as recorded: without the truth of its points, so that its poses count as measured, and these of twice the size."""
        super().setUpClass()
        cls.recorded = cls.folder / "recorded"
        program("simulate", "helix", "--set", "frames=30", "--output", cls.recorded)
        (cls.recorded / "landmarks.csv").unlink()
        truth = cls.recorded / "groundtruth.tum"
        poses = [line.split() for line in truth.read_text().splitlines()]
        truth.write_text("".join(" ".join([pose[0], *(repr(2 * float(x)) for x in pose[1:4]), *pose[4:]]) + "\n" for pose in poses))

    def recorded_study(self, name, scenarios, figures=""):
        study = self.folder / f"{name}.yaml"
        study.write_text(f"""format: slammot-study-1
name: {name}
runs: 3
scenarios: [{scenarios}]
estimators:
  - {{estimator: ekf}}
  - {{estimator: window, label: window 3, set: {{window.frames: 3}}}}
  - {{estimator: window, label: window 5, set: {{window.frames: 5}}}}
figures: [{figures}]
""", encoding="utf-8")
        return study

    def test_a_recording_is_one_run_or_draws_of_noise(self):
        study = self.recorded_study("recordings", "{sequence: recorded}, {sequence: recorded, label: noisy, set: {noise: 0.5}}",
                                    "camera_error, anees, trade_off")
        folder = self.folder / "recordings"
        program("study", study, "--output", folder)
        runs = [json.loads(line) for line in (folder / "results.jsonl").read_text().splitlines()]
        self.assertEqual([(r["cell"], r["seed"]) for r in runs], [(c, 1) for c in range(3)] + [(c, s) for c in range(3, 6) for s in (1, 2, 3)])
        noisy = [r["filtered"]["ate_sim3_m"] for r in runs if r["cell"] == 3]
        self.assertEqual(len(set(noisy)), 3)
        self.assertTrue(all(r["aligned"] and "nees_pose" not in r["frames"] for r in runs))
        groups = json.loads((folder / "summary.json").read_text())["groups"]
        self.assertEqual([g["seeds"] for g in groups], ["one run", "noise"])
        self.assertEqual([c["runs"] for g in groups for c in g["cells"]], [1] * 3 + [3] * 3)
        text = (folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("recorded: a recording to which no noise is added is one run", text)
        self.assertIn("noisy: each seed is another draw of the noise", text)
        self.assertIn("errors are after similarity alignment", text)
        self.assertLess(text.index("ATE Sim(3) [m]"), text.index("position RMSE [m]"))
        self.assertNotIn("ANEES", (folder / "tables" / "summary.csv").read_text().splitlines()[0])
        for run in json.loads((folder / "view.json").read_text())["runs"]:  # in the frame and scale of the truth
            self.assertLess(max(math.dist(a, b) for a, b in zip(run["path"], run["truth_path"])), 0.5)
        self.assertGreater(runs[0]["filtered"]["position_rmse_m"], 1.0)
        self.assertAlmostEqual(runs[0]["filtered"]["sim3_scale"], 2.0, delta=0.2)
        self.assertIn("0 runs done", program("study", study, "--shard", "1/2", "--resume", "--output", folder).stdout)  # nothing is missing

    def test_a_recording_that_has_changed_is_refused(self):
        shutil.copytree(self.recorded, self.folder / "changing")
        study = self.recorded_study("changes", "{sequence: changing}")
        folder = self.folder / "changes"
        begun = program("study", study, "--shard", "1/2", "--output", folder).stdout
        self.assertIn("one run of each (recordings without added noise)", begun)
        observations = self.folder / "changing" / "observations.csv"
        lines = observations.read_text().splitlines(keepends=True)
        observations.write_text("".join(lines[:-1]))
        program("study", study, "--shard", "2/2", "--resume", "--output", self.folder / "changes2")
        shutil.copy(self.folder / "changes2" / "journal-2-of-2.jsonl", folder)
        for command in ("--resume", "--merge"):
            said = program("study", study, command, "--output", folder, code=2).stderr
            self.assertRegex(said, r"journal-1-of-2\.jsonl:1: a recorded sequence has changed.*--force")
        program("study", study, "--merge", "--force", "--output", folder)

    def test_bad_recordings_are_refused_in_one_line(self):
        images, blind = self.folder / "images", shutil.copytree(self.recorded, self.folder / "blind")
        images.mkdir()
        (images / "rgb.txt").write_text("0.0 rgb/0.png\n")
        (blind / "groundtruth.tum").unlink()
        for scenarios, reason in (("{sequence: nowhere}", "nowhere"), ("{sequence: blind}", "no true poses"), ("{sequence: images}", "slammot track"),
                                  ("{sequence: recorded, scenario: circle}", "scenario"), ("{sequence: recorded, set: {frames: 3}}", "no parameter 'frames'"),
                                  ("{sequence: recorded, set: {noise: -1}}", "noise"), ("{sequence: recorded, set: {noise: nan}}", "noise")):
            study = self.recorded_study("bad_recording", scenarios)
            self.assertIn(reason, program("study", study, "--output", self.folder / "bad", code=2).stderr)

    def test_settings_of_one_estimator_in_a_comparison(self):
        output = self.folder / "settings"
        program("compare", self.recorded, "--estimator", "window:window.frames=3", "--estimator", "window:window.frames=4,gate.probability=0.99",
                "--estimator", "ekf", "--landmark", "dynamic_inverse_depth", "--output", output)
        runs = json.loads((output / "compare.json").read_text())["runs"]
        self.assertEqual([r["label"] for r in runs], ["window-window.frames=3-dynamic_inverse_depth",
                                                      "window-window.frames=4-gate.probability=0.99-dynamic_inverse_depth", "ekf-dynamic_inverse_depth"])
        self.assertEqual([r["configuration"]["window.frames"] for r in runs[:2]], ["3", "4"])
        self.assertIn("window, window.frames = 3 · dynamic_inverse_depth", (output / "report.html").read_text())
        for bad, reason in ((["window:window.frame=3"], "window.frames"), (["window:"], "key=value"), (["ekf", "windw:window.frames=3"], "unknown estimator"),
                            (["ekf", "ekf"], "compared with itself"), (["ekf", "--landmark=scaled_velocity", "--landmark=cube"], "cube")):
            words = [word if word.startswith("-") else f"--estimator={word}" for word in bad]
            self.assertIn(reason, program("compare", self.recorded, *words, "--output", self.folder / "bad", code=2).stderr)
            self.assertEqual([*(self.folder / "bad").glob("*/*")], [])  # before the first run


if __name__ == "__main__":
    unittest.main()
