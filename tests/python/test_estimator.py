"""An estimator written in Python, driven and judged by the program; and scripts that fail.

usage: test_estimator.py SLAMMOT
"""
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
SLAMMOT = os.environ["SLAMMOT"] = sys.argv.pop(1)
sys.path.insert(0, str(ROOT / "python"))
import slammot  # noqa: E402

EXAMPLES = ROOT / "examples/python/estimators.py"

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


def program(*words):
    return subprocess.run([SLAMMOT, *map(str, words)], capture_output=True, text=True, check=False)


class PythonEstimator(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.sequence = slammot.simulate("helix", seed=1, output=cls.folder / "helix", frames=40)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def script(self, fault="pass", text=SCRIPT):
        file = self.folder / "mine.py"
        file.write_text(text.format(fault=fault), encoding="utf-8")
        return file

    def run_mine(self, fault, *words, name="Mine", text=SCRIPT):
        return program("run", self.sequence.folder, "--estimator", f"python:{self.script(fault, text)}:{name}",
                       "--output", self.folder / "run", "--force", *words)

    def uneven(self):
        """The sequence, with measurements that are not equally exact."""
        folder = self.folder / "uneven"
        shutil.copytree(self.sequence.folder, folder)
        table = self.sequence.observations
        relative = np.linspace(0.5, 2.0, len(table))
        table.assign(relative_sigma=relative).to_csv(folder / "observations.csv", index=False)
        return slammot.read_sequence(folder)

    def test_numbers_cross_unchanged(self):
        """The harness judges what the script computes alone, to the last digit."""
        even, uneven = (self.check_numbers(sequence) for sequence in (self.sequence, self.uneven()))
        self.assertFalse(np.array_equal(even, uneven))

    def check_numbers(self, sequence):
        class_text = EXAMPLES.read_text(encoding="utf-8")
        run = slammot.run(sequence.folder, f"python:{EXAMPLES}:KnownPoints", self.folder / f"known-{sequence.folder.name}")
        scope = {"__name__": "examples"}
        exec(compile(class_text, str(EXAMPLES), "exec"), scope)  # pylint: disable=exec-used
        known, initial = sequence.known, sequence.initial
        sigma = initial["sigma"]
        parts = ("position", "rotation", "velocity", "angular_velocity")
        sigmas = np.repeat([float(sigma[part]) for part in parts], 3)
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
        return run.covariance

    def test_it_is_as_good_as_the_ekf_where_both_have_the_known_points(self):
        mine = slammot.run(self.sequence.folder, f"python:{EXAMPLES}:KnownPoints", self.folder / "known2")
        ekf = slammot.run(self.sequence.folder, "ekf", self.folder / "ekf")
        errors = [run.metrics["filtered"]["accuracy"]["position_rmse_m"] for run in (mine, ekf)]
        self.assertLess(errors[0], 1.2 * errors[1])
        self.assertLess(mine.metrics["filtered"]["nees"]["pose"]["mean"], 12.0)
        self.assertAlmostEqual(mine.metrics["nis"]["mean"], mine.metrics["nis"]["expected_mean"], delta=0.3)

    def test_compare_shows_it_once(self):
        out = self.folder / "compare"
        done = program("compare", self.sequence.folder, "--estimator", "ekf", "--estimator",
                       f"python:{EXAMPLES}:DeadReckoning", "--output", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        runs = json.loads((out / "compare.json").read_text(encoding="utf-8"))["runs"]
        self.assertEqual([run["label"] for run in runs],
                         ["ekf-dynamic_inverse_depth", "ekf-scaled_velocity", "DeadReckoning"])
        self.assertEqual(runs[2]["landmark"], "-")
        page = (out / "report.html").read_text(encoding="utf-8")
        self.assertRegex(page, r"DeadReckoning is (not )?(the most accurate|conservative|consistent|overconfident)")
        self.assertNotIn("DeadReckoning · -", page)

    def test_compare_with_settings_of_its_own(self):
        out = self.folder / "settings"
        name = f"python:{EXAMPLES}:KnownPoints"
        done = program("compare", self.sequence.folder, "--estimator", f"{name}:gate.probability=0.5", "--estimator", name,
                       "--output", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        runs = json.loads((out / "compare.json").read_text(encoding="utf-8"))["runs"]
        self.assertEqual([run["label"] for run in runs], ["KnownPoints-gate.probability=0.5", "KnownPoints"])
        accepted = [run["metrics"]["coverage"]["accepted"] for run in runs]
        self.assertLess(accepted[0], accepted[1])

    def test_a_stored_run_is_judged_again(self):
        out = self.folder / "stored"
        slammot.run(self.sequence.folder, f"python:{EXAMPLES}:KnownPoints", out)
        done = program("evaluate", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("dynamic_inverse_depth", done.stdout)
        done = program("report", out, "--output", self.folder / "judged")
        self.assertEqual(done.returncode, 0, done.stderr)
        content = json.loads((self.folder / "judged" / "compare.json").read_text(encoding="utf-8"))
        self.assertEqual(content["runs"][0]["landmark"], "-")
        self.assertIn("commit", content["provenance"])

    def test_what_is_not_reported_is_no_warning(self):
        done = self.run_mine("pass")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn(", from frame ", done.stderr)

    def test_study_on_two_threads_has_the_same_numbers(self):
        study = self.folder / "study.yaml"
        study.write_text(
            "format: slammot-study-1\nname: mine\nruns: 2\nscenarios: [{scenario: helix, set: {frames: 15}}]\n"
            f"estimators: [{{estimator: ekf}}, {{estimator: 'python:{EXAMPLES}:KnownPoints', label: known}}]\n"
            "sweep: {python.options: ['{}', '{\"probability\": 0.5}']}\n", encoding="utf-8")
        for jobs in (1, 2):
            done = program("study", study, "--jobs", jobs, "--output", self.folder / f"jobs{jobs}")
            self.assertEqual(done.returncode, 0, done.stderr)
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
        self.assertEqual(program("study", study, "--output", out).returncode, 0)
        self.assertEqual(program("study", study, "--resume", "--output", out).returncode, 0)
        self.assertEqual(program("study", out / "study.yaml", "--resume", "--output", out).returncode, 0)
        self.script("frame.index")
        changed = program("study", study, "--resume", "--output", out)
        self.assertEqual(changed.returncode, 2)
        self.assertIn("holds another study", changed.stderr)

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
        done = self.run_mine("", text=text)
        self.assertEqual(done.returncode, 0, done.stderr)
        run = slammot.read_run(self.folder / "run")
        self.assertEqual(len(run.smoothed), 40)
        self.assertGreaterEqual(len(run.landmarks), 5)
        self.assertEqual(set(run.landmarks["label"]), {"moving"})
        self.assertTrue(run.landmarks["v11"].isna().all())

    def test_without_a_covariance_there_is_no_nees(self):
        done = self.run_mine("P = None", text=SCRIPT.replace("P = np.eye(6) * 0.01", "P = None"))
        self.assertEqual(done.returncode, 0, done.stderr)
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
                done = self.run_mine(fault)
                self.assertEqual(done.returncode, 1, done.stderr)
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
                done = self.run_mine("pass", name=name, text=text)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertRegex(done.stderr, rf"^slammot: .*{reason}.*\n$")
        done = self.run_mine("pass", "--set", "python.options=[1]")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        done = program("run", self.sequence.folder, "--estimator", "python:nowhere.py:Mine")
        self.assertEqual((done.returncode, done.stderr), (2, "slammot: nowhere.py: no such file\n"))

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

    def test_what_a_script_prints_is_no_answer(self):
        done = self.run_mine("print('hello'); os.write(1, b'world')")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("hello", done.stderr)
        self.assertNotIn("hello", done.stdout)

    def test_another_interpreter(self):
        environment = os.environ | {"SLAMMOT_PYTHON": "/nowhere/python"}
        done = subprocess.run([SLAMMOT, "run", self.sequence.folder, "--estimator", f"python:{EXAMPLES}:DeadReckoning"],
                              capture_output=True, text=True, check=False, env=environment)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"^slammot: .*/nowhere/python: No such file or directory\n$")


if __name__ == "__main__":
    unittest.main()
