"""slammot study, as a user runs it: the same bytes whether interrupted, on one thread or two, in one piece or in shards;
and its report drawn in headless Chromium without an error.

usage: test_study.py SLAMMOT [Study | Strangers | Page]
"""
import csv
import json
import math
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from test_report import browse  # noqa: E402

SLAMMOT = ""
STUDY = """\
format: slammot-study-1
name: small
runs: 4
scenarios:
  - {scenario: helix, set: {frames: 24}}
  - {scenario: circle, label: short circle, set: {frames: 12}}
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


def slammot(*arguments, code=0):
    done = subprocess.run([SLAMMOT, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == code, f"exit {done.returncode}\n{done.stdout}{done.stderr}"
    return done


class WithFolder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()


class WithStudy(WithFolder):
    TEXT = STUDY

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.study = cls.folder / "small.yaml"
        cls.study.write_text(cls.TEXT, encoding="utf-8")
        cls.whole = cls.folder / "whole"
        slammot("study", cls.study, "--jobs", 2, "--output", cls.whole)
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
        slammot("study", self.study, "--jobs", 1, "--output", self.folder / "one_job")
        self.same(self.folder / "one_job")

    def test_killed_and_resumed(self):
        folder = self.folder / "killed"
        process = subprocess.Popen([SLAMMOT, "study", str(self.study), "--jobs", "1", "--output", str(folder)],
                                   stdout=subprocess.DEVNULL)
        journal = folder / "journal-1-of-1.jsonl"
        while process.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") >= 5):
            time.sleep(0.005)
        process.send_signal(signal.SIGKILL)
        process.wait()
        before = journal.read_bytes().count(b"\n") - 1  # the first line says what program this is
        self.assertLess(before, 32, "it was over before it could be killed")
        with journal.open("ab") as file:
            file.write(b'{"result": {"cell": 7, "se')  # as a kill in the middle of a write leaves it
        again = slammot("study", self.study, "--resume", "--output", folder)
        self.assertIn(f"{32 - before} runs done", again.stdout)
        self.same(folder)

    def test_three_shards_in_folders_of_their_own(self):
        folders = [self.folder / f"shard{i}" for i in (1, 2, 3)]
        for i, folder in enumerate(folders, 1):
            slammot("study", self.study, "--shard", f"{i}/3", "--output", folder)
        merged = self.folder / "merged"
        missing = slammot("study", self.study, "--output", merged, "--merge", *folders[:2], code=2)
        self.assertIn("a run is missing", missing.stderr)
        slammot("study", self.study, "--output", merged, "--merge", *folders)
        self.same(merged)

    def test_more_runs_are_added_to_those_there_are(self):
        folder = self.folder / "more"
        slammot("study", self.study, "--runs", 2, "--output", folder)
        more = slammot("study", self.study, "--runs", 4, "--resume", "--output", folder)
        self.assertIn("16 runs done", more.stdout)
        self.same(folder)

    def test_what_is_there_is_not_overwritten(self):
        self.assertIn("--resume", slammot("study", self.study, "--output", self.whole, code=2).stderr)
        other = self.folder / "other.yaml"
        other.write_text(STUDY.replace("frames: 24", "frames: 41"), encoding="utf-8")
        self.assertIn("another study", slammot("study", other, "--resume", "--output", self.whole, code=2).stderr)

    def test_report_again(self):
        (self.whole / "report.html").unlink()
        slammot("report", self.whole)
        self.assertTrue((self.whole / "report.html").exists())
        slammot("report", self.folder, code=2)

    def test_a_bad_study_is_refused_in_one_line(self):
        bad = self.folder / "bad.yaml"
        for text, reason in (("runs: 4", "runs: none"), ("record: {tracks: [1, 2]}", "figures: [camera]"),
                             ("record: {tracks: [1, 2]}", "figures: ['against_sweep:rmse']"), ("record: {tracks: [1, 2]}", "latex: {columns: [rmse]}"),
                             ("record: {tracks: [1, 2]}", "latex: {columns: []}"),
                             ("estimator: ekf", "estimator: kalman"), ("frames: 24", "frame_count: 24"),
                             ("name: small", "nam: small"), ("window.frames: 3", "window.frame: 3"),
                             ("slammot-study-1", "slammot-study-9"), ("scenario: helix", "scenario: helicoid")):
            bad.write_text(STUDY.replace(text, reason, 1), encoding="utf-8")
            error = slammot("study", bad, "--output", self.folder / "bad", code=2).stderr
            self.assertEqual(error.count("\n"), 1, error)
            self.assertIn("bad.yaml", error)
            self.assertFalse((self.folder / "bad").exists())


class Strangers(WithStudy):
    def test_two_processes_compute_no_run_twice(self):
        folder = self.folder / "two"
        command = [SLAMMOT, "study", str(self.study), "--jobs", "1", "--resume", "--output", str(folder)]
        first = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        journal = folder / "journal-1-of-1.jsonl"
        while not (journal.exists() and journal.read_bytes().count(b"\n") > 1):
            time.sleep(0.005)
        self.assertIn("another process", slammot(*command[1:], code=2).stderr)
        self.assertIn("another process", slammot("study", self.study, "--shard", "1/2", "--output", folder, code=2).stderr)
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

    def test_a_users_folder_is_left_alone(self):
        """Also where the study itself stands in it."""
        folder = self.folder / "users"
        folder.mkdir()
        study = folder / "study.yaml"
        study.write_text(STUDY, encoding="utf-8")
        for name in ("results.jsonl", "runs.csv", "report.html"):
            (folder / name).write_text("mine", encoding="utf-8")
        before = {file.name: file.read_bytes() for file in folder.iterdir()}
        for more in ([], ["--resume"], ["--merge"], ["--force"]):
            said = slammot("study", study, "--output", folder, *more, code=2).stderr
            self.assertIn("holds files that are not a study of this program", said)
            self.assertEqual({file.name: file.read_bytes() for file in folder.iterdir()}, before)

    def test_lines_that_are_no_runs_are_refused(self):
        folder = self.folder / "damaged"
        slammot("study", self.study, "--runs", 1, "--output", folder)
        journal = folder / "journal-1-of-1.jsonl"
        lines = journal.read_text(encoding="utf-8").splitlines(keepends=True)
        run = json.loads(lines[1])
        bad = [{**run, "result": {"cell": 0, "seed": 1}}, {**run, "result": {**run["result"], "diverged": 3}},
               {**run, "result": {**run["result"], "static": [1]}}, {**run, "result": {**run["result"], "warnings": [{"frame": -1, "reason": "x"}]}},
               {**run, "result": {**run["result"], "lost_at": []}, "timing": {"cell": 0, "seed": 1}}]
        deep = lines[1].rstrip()[:-1] + ',"x":' + 300_000 * "[" + 300_000 * "]" + "}\n"
        for line in [json.dumps(content) + "\n" for content in bad] + [deep]:
            journal.write_text("".join([lines[0], line, *lines[2:]]), encoding="utf-8")
            said = slammot("study", self.study, "--runs", 1, "--merge", "--output", folder, code=2).stderr
            self.assertEqual(said.count("\n"), 1, said[:300])
            self.assertRegex(said, r"(journal-1-of-1|results|timing)\.jsonl:\d+: ")

    def test_what_cannot_run_is_charged_to_nobody(self):
        impossible = self.folder / "impossible.yaml"
        for setting, reason in (("frames.first: 100", "leave no frame of"),):
            impossible.write_text(STUDY.replace("set: {window.frames: 3}", f"set: {{window.frames: 3, {setting}}}"), encoding="utf-8")
            folder = self.folder / setting.split(":")[0]
            said = slammot("study", impossible, "--runs", 1, "--output", folder, code=2).stderr
            self.assertEqual(said.count("\n"), 1, said)
            self.assertIn(reason, said)
            self.assertNotIn('"diverged":{', (folder / "journal-1-of-1.jsonl").read_text(encoding="utf-8"))

    def test_runs_of_another_configuration_are_refused(self):
        mine, other, text = self.folder / "mine", self.folder / "other", self.folder / "of_other.yaml"
        text.write_text(STUDY.replace("frames: 24", "frames: 39"), encoding="utf-8")
        slammot("study", self.study, "--shard", "1/2", "--runs", 1, "--output", mine)
        slammot("study", text, "--shard", "2/2", "--runs", 1, "--output", other)
        shutil.copy(other / "journal-2-of-2.jsonl", mine)
        for command in (["--merge"], ["--merge", "--force"], ["--resume"]):
            said = slammot("study", self.study, "--runs", 1, "--output", mine, *command, code=2).stderr
            self.assertIn("journal-2-of-2.jsonl:1: these runs are of another configuration", said)

    def test_runs_of_another_build_are_refused(self):
        folder = self.folder / "rebuilt"
        slammot("study", self.study, "--runs", 1, "--output", folder)
        journal = folder / "journal-1-of-1.jsonl"
        lines = journal.read_text(encoding="utf-8").splitlines(keepends=True)
        head = json.loads(lines[0])
        head["journal"]["program"] = "0" * 64
        journal.write_text("".join([json.dumps(head) + "\n", *lines[1:]]), encoding="utf-8")
        self.assertIn("another build", slammot("study", self.study, "--resume", "--output", folder, code=2).stderr)
        self.assertIn("another build", slammot("study", self.study, "--merge", "--output", folder, "--runs", 1, code=2).stderr)
        more = slammot("study", self.study, "--resume", "--force", "--output", folder)
        self.assertIn("24 runs done", more.stdout)
        heads = [line for line in journal.read_text(encoding="utf-8").splitlines() if line.startswith('{"journal"')]
        self.assertEqual(len(heads), 2)
        self.same(folder)


class Page(WithStudy):
    # Of one scenario and two runs: each group is a row of every figure. What is swept changes the ANEES.
    TEXT = STUDY.replace("  - {scenario: circle, label: short circle, set: {frames: 12}}\n", "").replace("runs: 4", "runs: 2")
    TEXT = TEXT.replace("classifier.static_threshold: [0.8, 1.6]", "gate.probability: [0.5, 0.99]")
    TEXT += f"figures: [{', '.join(FIGURES)}]\n{LATEX}"
    GROUPS = 2  # of two estimators

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

    def check_paper(self, latex, folder):
        """Own labels and caption, escaped; the best of each scenario in bold."""
        self.assertIn(r"\caption{100\% of the runs}", latex)
        self.assertIn("RMSE [m] & ANEES pose & time per frame [ms]", latex)
        groups = json.loads((folder / "summary.json").read_text())["groups"]
        rows = [line for line in latex.splitlines() if "EKF" in line or "window 3" in line]
        self.assertEqual(len(rows), 2 * len(groups))
        for group, (ekf, window) in zip(groups, zip(rows[::2], rows[1::2])):
            self.assertIn(r"EKF \& co", ekf)
            a, b = (cell["filtered_position_rmse_m"]["value"] for cell in group["cells"])
            self.assertEqual([r"\textbf" in row.split("&")[-3] for row in (ekf, window)], [a < b, b < a])

    def test_verdict_and_colours(self):
        text = (self.whole / "report.html").read_text(encoding="utf-8")
        self.assertLess(text.index('class="verdict"'), text.index("<table"))
        self.assertIn("Each seed is another simulation of the scenario.", text)
        verdict = text[text.index('class="verdict"'):text.index("<table")]
        self.assertRegex(verdict, r"ekf: ANEES of the pose [\d.]+ to [\d.]+ \(6 expected\), .* fewer than five runs decide nothing")
        self.assertIn("No difference is tested: fewer than five runs.", text)
        cells = [cell for group in json.loads((self.whole / "summary.json").read_text())["groups"] for cell in group["cells"]]
        # No ANEES: so few runs have no interval.
        over = sum(bool(cell["lost"]) + bool(cell["diverged"]) for cell in cells)
        over += sum(bool((cell.get("failed_silently") or {}).get("value")) for cell in cells)
        summary = text[text.index("<h2>Summary"):text.index("<h2>", text.index("<h2>Summary") + 4)]
        self.assertEqual(summary.count('<td class="over">'), over)
        self.assertEqual(summary.count('rowspan="2"'), self.GROUPS)

    def test_why_runs_warn(self):
        """A gate that is half closed is one reason. What a run says is in its line, in the summary and on the page."""
        runs = [json.loads(line) for line in self.expected.splitlines()]
        warning = [run for run in runs if run["warnings"]]
        cells = [cell for group in json.loads((self.whole / "summary.json").read_text())["groups"] for cell in group["cells"]]
        self.assertEqual([seen["warnings"] for cell in cells for seen in cell["warnings"]], [run["warnings"] for run in warning])
        self.assertEqual([cell["warned"]["value"] for cell in cells], [len(cell["warnings"]) / cell["runs"] for cell in cells])
        half_closed = [run for run in warning if any("were rejected" in w["reason"] for w in run["warnings"])]
        self.assertGreaterEqual(len(half_closed), 2)
        self.assertLess(len(warning), len(runs))
        text = (self.whole / "report.html").read_text(encoding="utf-8")
        self.assertIn("runs warn, those that diverged aside; why is in the table Warnings", text)
        table = (self.whole / "tables" / "warnings.csv").read_text(encoding="utf-8")
        for run in warning:
            self.assertIn(f'seed {run["seed"]}: from frame {run["warnings"][0]["frame"]}, {run["warnings"][0]["reason"]}', table)

    def test_ranking_needs_the_ideal_covariance(self):
        ranked = self.folder / "ranked.yaml"
        ranked.write_text(f"{STUDY}figures: [ranking]\n", encoding="utf-8")
        error = slammot("study", ranked, "--output", self.folder / "ranked", code=2).stderr
        self.assertRegex(error, r"\A.*ranked\.yaml: .*ideal_covariance.*\n\Z")

    def test_report(self):
        folder = self.whole
        for name in FIGURES:
            for ending in ("pdf", "png"):
                self.assertGreater((folder / "figures" / f"{name.replace(':', '_')}.{ending}").stat().st_size, 5000)
        for name, rows in (("summary", 2), ("consistency", 10), ("classification", 4), ("pairs", 1), ("metrics", 2), ("coverage", 2)):
            lines = (folder / "tables" / f"{name}.csv").read_text(encoding="utf-8").splitlines()
            self.assertEqual(len(lines), 1 + self.GROUPS * rows, name)
            self.assertNotIn("nan", "".join(lines).lower().replace("anees", ""))
            latex = (folder / "tables" / f"{name}.tex").read_text(encoding="utf-8")
            for part in (r"\begin{tabular}", r"\toprule", r"\midrule", r"\bottomrule"):
                self.assertIn(part, latex)
            self.assertNotIn(r"\hline", latex)
        self.check_paper((folder / "tables" / "paper.tex").read_text(encoding="utf-8"), folder)
        page = (folder / "report.html").read_text(encoding="utf-8")
        dom = self.opened(page)
        self.assertNotIn("data-console-errors", dom)
        errors = self.opened("<!doctype html><html><head></head><script>console.error('said')</script><script>oops()</script></html>")
        self.assertRegex(errors, 'data-console-errors="said.*oops')
        self.assertIn('data-drawn="1"', dom)
        self.assertNotIn("data-error", dom)
        landmarks = int(dom.split('data-landmarks="')[1].split('"')[0])
        self.assertGreater(landmarks, 10)
        self.assertGreater(int(dom.split('data-marks="')[1].split('"')[0]), landmarks)  # what Plotly holds
        self.assertEqual(dom.count('<img src="data:image/png;base64,'), len(FIGURES))

    def test_poses_at_a_lag(self):
        """Of the estimators that keep past poses, judged over the same frames at each lag; the others have none."""
        study = self.folder / "lag.yaml"
        study.write_text("""format: slammot-study-1
name: lag
runs: 2
scenarios: [{scenario: circle, set: {frames: 50}}]
estimators:
  - {estimator: ekf}
  - {estimator: ekf, label: ekf lag 3, set: {ekf.lag: 3}}
  - {estimator: window, label: window 3, set: {window.frames: 3}}
figures: [lag]
""", encoding="utf-8")
        folder = self.folder / "lag"
        slammot("study", study, "--output", folder)
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
        study = self.folder / "no_lag.yaml"
        study.write_text(f"{STUDY}figures: [lag]\n", encoding="utf-8")  # shorter than the longest lag
        folder = self.folder / "no_lag"
        slammot("study", study, "--runs", 1, "--output", folder)
        self.assertFalse((folder / "figures" / "lag.png").exists())
        self.assertFalse((folder / "tables" / "lags.csv").exists())
        self.assertNotIn("Poses at a lag", (folder / "report.html").read_text(encoding="utf-8"))


class Recordings(WithFolder):
    def recorded(self):
        """A sequence as recorded: without the truth of its points, so that its poses count as measured, and these of twice the size."""
        sequence = self.folder / "recorded"
        if not sequence.exists():
            slammot("simulate", "circle", "--set", "frames=30", "--output", sequence)
            (sequence / "landmarks.csv").unlink()
            poses = [line.split() for line in (sequence / "groundtruth.tum").read_text().splitlines()]
            (sequence / "groundtruth.tum").write_text("".join(
                " ".join([pose[0], *(repr(2 * float(x)) for x in pose[1:4]), *pose[4:]]) + "\n" for pose in poses))
        return sequence

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
        self.recorded()
        study = self.recorded_study("recordings", "{sequence: recorded}, {sequence: recorded, label: noisy, set: {noise: 0.5}}",
                                    "camera_error, anees, trade_off")
        folder = self.folder / "recordings"
        slammot("study", study, "--output", folder)
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
        summary = (folder / "tables" / "summary.csv").read_text()
        self.assertNotIn("ANEES", summary.splitlines()[0])
        for run in json.loads((folder / "view.json").read_text())["runs"]:  # in the frame and scale of the truth
            self.assertLess(max(math.dist(a, b) for a, b in zip(run["path"], run["truth_path"])), 0.5)
        self.assertGreater(runs[0]["filtered"]["position_rmse_m"], 1.0)
        self.assertAlmostEqual(runs[0]["filtered"]["sim3_scale"], 2.0, delta=0.2)
        self.assertIn("0 runs done", slammot("study", study, "--shard", "1/2", "--resume", "--output", folder).stdout)  # nothing is missing

    def test_a_recording_that_has_changed_is_refused(self):
        shutil.copytree(self.recorded(), self.folder / "changing")
        study = self.recorded_study("changes", "{sequence: changing}")
        folder = self.folder / "changes"
        begun = slammot("study", study, "--shard", "1/2", "--output", folder).stdout
        self.assertIn("one run of each (recordings without added noise)", begun)
        observations = self.folder / "changing" / "observations.csv"
        lines = observations.read_text().splitlines(keepends=True)
        observations.write_text("".join(lines[:-1]))
        slammot("study", study, "--shard", "2/2", "--resume", "--output", self.folder / "changes2")
        shutil.copy(self.folder / "changes2" / "journal-2-of-2.jsonl", folder)
        for command in ("--resume", "--merge"):
            said = slammot("study", study, command, "--output", folder, code=2).stderr
            self.assertRegex(said, r"\A[^\n]*journal-1-of-2\.jsonl:1: a recorded sequence has changed[^\n]*--force[^\n]*\n\Z")
        slammot("study", study, "--merge", "--force", "--output", folder)

    def test_bad_recordings_are_refused_in_one_line(self):
        self.recorded()
        images = self.folder / "images"
        if not images.exists():
            images.mkdir()
            (images / "rgb.txt").write_text("0.0 rgb/0.png\n")
        blind = self.folder / "blind"
        if not blind.exists():
            slammot("simulate", "circle", "--set", "frames=5", "--output", blind)
            for name in ("groundtruth.tum", "landmarks.csv"):
                (blind / name).unlink()
        for scenarios, reason in (("{sequence: nowhere}", "nowhere"), ("{sequence: blind}", "no true poses"), ("{sequence: images}", "slammot track"),
                                  ("{sequence: recorded, scenario: circle}", "scenario"), ("{sequence: recorded, set: {frames: 3}}", "no parameter 'frames'"),
                                  ("{sequence: recorded, set: {noise: -1}}", "noise"), ("{sequence: recorded, set: {noise: nan}}", "noise")):
            error = slammot("study", self.recorded_study("bad_recording", scenarios), "--output", self.folder / "bad", code=2).stderr
            self.assertRegex(error, rf"\A[^\n]*{reason}[^\n]*\n\Z")

    def test_settings_of_one_estimator_in_a_comparison(self):
        output = self.folder / "settings"
        slammot("compare", self.recorded(), "--estimator", "window:window.frames=3", "--estimator", "window:window.frames=4,gate.probability=0.99",
                "--estimator", "ekf", "--landmark", "dynamic_inverse_depth", "--output", output)
        runs = json.loads((output / "compare.json").read_text())["runs"]
        self.assertEqual([r["label"] for r in runs], ["window-window.frames=3-dynamic_inverse_depth",
                                                      "window-window.frames=4-gate.probability=0.99-dynamic_inverse_depth", "ekf-dynamic_inverse_depth"])
        self.assertEqual([r["configuration"]["window.frames"] for r in runs[:2]], ["3", "4"])
        self.assertIn("window, window.frames = 3 · dynamic_inverse_depth", (output / "report.html").read_text())
        for bad, reason in (("window:window.frame=3", "window.frames"), ("window:", "key=value"), ("windw:window.frames=3", "unknown estimator")):
            self.assertIn(reason, slammot("compare", self.recorded(), "--estimator", bad, "--output", self.folder / "bad", code=2).stderr)
        self.assertIn("compared with itself", slammot("compare", self.recorded(), "--estimator", "ekf", "--estimator", "ekf", "--output",
                                                      self.folder / "same", code=2).stderr)


if __name__ == "__main__":
    SLAMMOT = sys.argv.pop(1)
    unittest.main()
