"""An estimator written in Python, driven and judged by the program; and scripts that fail.

usage: test_estimator.py SLAMMOT
"""
import hashlib
import json
import os
import pathlib
import shutil
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "eval"))
from fixture import ROOT, WithFolder, program  # noqa: E402
import slammot  # noqa: E402

EXAMPLES = ROOT / "examples/python/estimators.py"
KNOWN_POINTS = f"python:{EXAMPLES}:KnownPoints"

# Its second frame is what is under test.
SCRIPT = """\
import numpy as np
import os
import slammot

class Mine(slammot.Estimator):
    def __init__(self, setup, **options):
        self.setup, self.options = setup, options

    def process(self, frame):
        P = np.eye(6) * 0.01
        if frame.index == 1:
            {fault}
        return slammot.CameraEstimate([0, 0, frame.index], covariance=P)

class Other:
    pass
"""


class PythonEstimator(WithFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.sequence = slammot.simulate("helix", seed=1, output=cls.folder / "helix", frames=40)
        cls.known = slammot.run(cls.sequence.folder, KNOWN_POINTS, cls.folder / "known")

    def script(self, fault="pass", text=SCRIPT):
        file = self.folder / "mine.py"
        file.write_text(text.format(fault=fault), encoding="utf-8")
        return file

    def run_mine(self, fault, *words, name="Mine", text=SCRIPT, code=0):
        return program("run", self.sequence.folder, "--estimator", f"python:{self.script(fault, text)}:{name}",
                       "--output", self.folder / "run", "--force", *words, code=code)

    def test_numbers_cross_unchanged(self):
        """The harness judges what the script computes alone, to the last digit; also of measurements that are not equally exact."""
        self.check_numbers(self.sequence, self.known)
        folder, table = shutil.copytree(self.sequence.folder, self.folder / "uneven"), self.sequence.observations
        table.assign(relative_sigma=np.linspace(0.5, 2.0, len(table))).to_csv(folder / "observations.csv", index=False)
        uneven = slammot.run(folder, KNOWN_POINTS, self.folder / "known-uneven")
        self.check_numbers(slammot.read_sequence(folder), uneven)
        self.assertFalse(np.array_equal(self.known.covariance, uneven.covariance))

    def test_odds_from_outside_are_of_the_setup(self):
        with_odds = shutil.copytree(self.sequence.folder, self.folder / "odds")
        (with_odds / "priors.csv").write_text("track,p_static\n2,0.25\n7,1\n")
        self.assertEqual(slammot.read_sequence(with_odds).priors.values.tolist(), [[2.0, 0.25], [7.0, 1.0]])
        self.assertIsNone(self.sequence.priors)
        for folder, said in ((with_odds, {2: 0.25, 7: 1.0}), (self.sequence.folder, {})):
            script = self.script(f"assert self.setup.p_static == {said}")
            program("run", folder, "--estimator", f"python:{script}:Mine", "--output", self.folder / "run", "--force")

    def check_numbers(self, sequence, run):
        scope = {"__name__": "examples"}
        exec(compile(EXAMPLES.read_text(encoding="utf-8"), str(EXAMPLES), "exec"), scope)  # pylint: disable=exec-used
        known, initial = sequence.known, sequence.initial
        parts = ("position", "rotation", "velocity", "angular_velocity")
        sigmas = np.repeat([float(initial["sigma"][part]) for part in parts], 3)
        setup = slammot.Setup(
            sequence.camera, sequence.pixel_sigma, *sequence.settings["motion"].values(), {},
            slammot.CameraEstimate(np.array(initial["position"]), np.array(initial["quaternion"]), np.diag(sigmas**2),
                                   np.array(initial["velocity"]), np.array(initial["angular_velocity"])),
            slammot.KnownLandmarks(known["track"].to_numpy(), known[["x", "y", "z"]].to_numpy(), known["sigma"].to_numpy()),
            {"gate.probability": "0.95"})
        alone = scope["KnownPoints"](setup)
        self.assertEqual(run.description["estimator_sha256"], hashlib.sha256(EXAMPLES.read_bytes()).hexdigest())
        for i, frame in enumerate(sequence):
            camera, _ = alone.process(frame)
            np.testing.assert_array_equal(camera.position, run.trajectory.loc[i, ["x", "y", "z"]])
            np.testing.assert_array_equal(camera.covariance[np.triu_indices(6)], run.covariance[i][np.triu_indices(6)])

    def test_it_is_as_good_as_the_ekf_where_both_have_the_known_points(self):
        ekf = slammot.run(self.sequence.folder, "ekf", self.folder / "ekf")
        errors = [run.metrics["filtered"]["accuracy"]["position_rmse_m"] for run in (self.known, ekf)]
        self.assertLess(errors[0], 1.2 * errors[1])
        self.assertLess(self.known.metrics["filtered"]["nees"]["pose"]["mean"], 12.0)
        self.assertAlmostEqual(self.known.metrics["nis"]["mean"], self.known.metrics["nis"]["expected_mean"], delta=0.3)

    def test_compare_shows_it_once_and_with_settings_of_its_own(self):
        out = self.folder / "compare"
        estimators = ["ekf", f"python:{EXAMPLES}:DeadReckoning", f"{KNOWN_POINTS}:gate.probability=0.5", KNOWN_POINTS]
        program("compare", self.sequence.folder, *(word for name in estimators for word in ("--estimator", name)), "--output", out)
        runs = json.loads((out / "compare.json").read_text(encoding="utf-8"))["runs"]
        self.assertEqual([run["label"] for run in runs], ["ekf-dynamic_inverse_depth", "ekf-scaled_velocity", "DeadReckoning",
                                                          "KnownPoints-gate.probability=0.5", "KnownPoints"])
        self.assertEqual(runs[2]["landmark"], "-")
        page = (out / "report.html").read_text(encoding="utf-8")
        self.assertRegex(page, r"KnownPoints is (near what is expected|conservative|consistent|overconfident)")
        self.assertIn("DeadReckoning failed at frame", page)
        self.assertNotIn("DeadReckoning · -", page)
        accepted = [run["metrics"]["coverage"]["accepted"] for run in runs]
        self.assertLess(accepted[3], accepted[4])

    def test_a_stored_run_is_judged_again(self):
        self.assertNotIn("dynamic_inverse_depth", program("evaluate", self.folder / "known").stdout)
        program("report", self.folder / "known", "--output", self.folder / "judged")
        content = json.loads((self.folder / "judged" / "compare.json").read_text(encoding="utf-8"))
        self.assertEqual(content["runs"][0]["landmark"], "-")
        self.assertIn("commit", content["provenance"])

    def test_study_on_two_threads_has_the_same_numbers(self):
        study = self.folder / "study.yaml"
        study.write_text(
            "format: slammot-study-1\nname: mine\nruns: 2\nscenarios: [{scenario: helix, set: {frames: 15}}]\n"
            f"estimators: [{{estimator: ekf}}, {{estimator: '{KNOWN_POINTS}', label: known}}]\n"
            "sweep: {python.options: ['{}', '{\"probability\": 0.5}']}\n", encoding="utf-8")
        for jobs in (1, 2):
            program("study", study, "--jobs", jobs, "--output", self.folder / f"jobs{jobs}")
        texts = [(self.folder / f"jobs{jobs}" / "results.jsonl").read_bytes() for jobs in (1, 2)]
        self.assertEqual(*texts)
        runs = slammot.read_study(self.folder / "jobs1")
        known = runs[runs["label"] == "known"].groupby("python.options")["nis_mean"].mean()
        self.assertEqual(len(known), 2)
        self.assertLess(known['{"probability": 0.5}'], known["{}"])  # the option reached the class
        summary = json.loads((self.folder / "jobs1" / "summary.json").read_text(encoding="utf-8"))
        rmse = summary["groups"][0]["cells"][1]["filtered_position_rmse_m"]
        self.assertEqual((rmse["runs"], rmse["lower"], rmse["upper"]), (2, None, None))  # too few for an interval

    def test_a_study_notices_that_its_script_has_changed(self):
        study, out = self.folder / "script.yaml", self.folder / "script"
        study.write_text("format: slammot-study-1\nname: mine\nruns: 1\nscenarios: [{scenario: helix, set: {frames: 5}}]\n"
                         f"estimators: [{{estimator: 'python:{self.script()}:Mine'}}]", encoding="utf-8")
        program("study", study, "--output", out)
        program("study", out / "study.yaml", "--resume", "--output", out)
        self.script("frame.index")
        self.assertIn("holds another study", program("study", study, "--resume", "--output", out, code=2).stderr)

    def test_landmarks_and_smoothing(self):
        text = """\
import numpy as np
import slammot

class Mine(slammot.Estimator):
    kind = "smoother"
    def __init__(self, setup):
        self.cameras, self.frame = [], None
    def process(self, frame):
        self.frame = frame
        self.cameras.append(slammot.CameraEstimate(np.zeros(3), covariance=np.eye(6), timestamp=frame.timestamp))
        return self.cameras[-1]
    def landmarks(self):
        return [slammot.LandmarkEstimate(int(t), [1, 2, 3], "moving", np.eye(3), velocity=[0, 0, 1], decision_frame=0,
                                         last_frame=self.frame.index, observations=2) for t in self.frame.tracks[:5]]
    def smoothed(self):
        return self.cameras
"""
        self.run_mine("", text=text)
        run = slammot.read_run(self.folder / "run")
        self.assertEqual(len(run.smoothed), 40)
        self.assertGreaterEqual(len(run.landmarks), 5)
        self.assertEqual(set(run.landmarks["label"]), {"moving"})
        self.assertTrue(run.landmarks["v11"].isna().all())

    def test_without_a_covariance_there_is_no_nees(self):
        self.run_mine("P = None", text=SCRIPT.replace("P = np.eye(6) * 0.01", "P = None"))
        metrics = slammot.read_run(self.folder / "run").metrics
        self.assertIsNone(metrics["filtered"]["nees"])
        self.assertGreater(metrics["filtered"]["accuracy"]["position_rmse_m"], 0.0)

    def test_a_script_that_fails_ends_its_run_in_one_line(self):
        for fault, reason in (("frame.nothing", r"mine\.py:12: AttributeError: .*nothing"),
                              ("os._exit(3)", r"mine\.py: the process ended with exit code 3"),
                              ("os.kill(os.getpid(), 11)", r"mine\.py: the process ended by signal 11"),
                              ("raise slammot.Diverged('far off')", "far off"),
                              ("P = np.full((6, 6), np.inf); P[0, 0] = 1", "covariance is not a number"),
                              ("P = np.eye(4)", r"covariance has 16 numbers, not \(36, 144\)"),
                              ("return 1", "a slammot.CameraEstimate is expected, not int")):
            with self.subTest(fault=fault):
                done = self.run_mine(fault, code=1)
                self.assertRegex(done.stderr, rf"^slammot: diverged at frame 1: .*{reason}.*\n$")
                self.assertEqual(len(slammot.read_run(self.folder / "run").trajectory), 1)

    def test_a_run_that_diverged_is_returned_and_one_that_never_began_is_not(self):
        out = self.folder / "run"
        run = slammot.run(self.sequence.folder, f"python:{self.script('raise slammot.Diverged')}:Mine", out, force=True)
        self.assertEqual((len(run.trajectory), run.metrics["diverged"]), (1, True))
        with self.assertRaisesRegex(RuntimeError, "^slammot: .*no class Nobody"):
            slammot.run(self.sequence.folder, f"python:{self.script()}:Nobody", out, force=True)

    def test_a_script_that_cannot_begin_is_refused_in_one_line(self):
        for name, text, reason in (("Mine", SCRIPT + "\n)", r"mine\.py:\d+: unmatched '\)'"),
                                   ("Nobody", SCRIPT, "has no class Nobody"),
                                   ("Other", SCRIPT, "has no class Other that derives"),
                                   ("Mine", "import nothing_such\n", r"mine\.py:1: ModuleNotFoundError"),
                                   ("Mine", SCRIPT.replace("= setup, options", "= 1 / 0"), r"mine\.py:7: ZeroDivision"),
                                   ("", SCRIPT, "python:FILE.py:Class")):
            with self.subTest(reason=reason):
                self.assertRegex(self.run_mine("pass", name=name, text=text, code=2).stderr, rf"^slammot: .*{reason}")
        self.run_mine("pass", "--set", "python.options=[1]", code=2)
        done = program("run", self.sequence.folder, "--estimator", "python:nowhere.py:Mine", code=2)
        self.assertEqual(done.stderr, "slammot: nowhere.py: no such file\n")

    def test_the_example_of_the_docs(self):
        lines = (ROOT / "docs/python.md").read_text(encoding="utf-8").splitlines()
        begin = lines.index("    import numpy as np")
        end = next(i for i in range(begin, len(lines)) if lines[i] and not lines[i].startswith("    "))
        text = "\n".join(line[4:] for line in lines[begin:end]) + "\n"
        file = self.folder / "still.py"
        file.write_text(text, encoding="utf-8")
        run = slammot.run(self.sequence.folder, f"python:{file}:Still", self.folder / "still")
        self.assertEqual(len(run.trajectory), 40)
        self.assertAlmostEqual(run.covariance[-1][0, 0] - run.covariance[0][0, 0], 39 * 0.01, delta=1e-12)

    def test_what_a_script_prints_is_no_answer_and_what_it_does_not_report_no_warning(self):
        done = self.run_mine("print('hello'); os.write(1, b'world')")
        self.assertIn("hello", done.stderr)
        self.assertNotIn("hello", done.stdout)
        self.assertNotIn(", from frame ", done.stderr)

    def test_another_interpreter(self):
        done = program("run", self.sequence.folder, "--estimator", f"python:{EXAMPLES}:DeadReckoning", code=2,
                       env=os.environ | {"SLAMMOT_PYTHON": "/nowhere/python"})
        self.assertRegex(done.stderr, r"^slammot: .*/nowhere/python: No such file or directory\n$")


if __name__ == "__main__":
    unittest.main()
