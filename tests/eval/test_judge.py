"""slammot evaluate and report on runs made elsewhere: poses drawn from a stated covariance have the NEES they must have, in
every error convention; the example of docs/judge.md runs; and what is wrong with a file is said in one line.

usage: test_judge.py SLAMMOT
"""
import itertools
import json
import re
import shutil
import subprocess
import unittest

import numpy as np

from fixture import ROOT, WithFolder, contents, program
from slammot import so3
from slammot.report.verdict import failure_bound

FRAMES, RUNS = 100, 20
CONVENTIONS = [",".join(words) for words in itertools.product(("position-first", "rotation-first"), ("right", "left"),
                                                              ("global", "local", "spatial")) if words[1:] != ("right", "spatial")]


def disturbed(q, r, error, convention):
    """The estimate of which (q, r) is the truth when this is its error in this convention."""
    order, turn, place = convention.split(",")
    dr, dtheta = (error[:3], error[3:]) if order == "position-first" else (error[3:], error[:3])
    back = so3.exp(-dtheta)
    q_est = so3.multiply(q, back) if turn == "right" else so3.multiply(back, q)
    if place == "global":
        return q_est, r - dr
    if place == "local":
        return q_est, r - so3.matrix(q_est) @ dr
    V_dr = dr + np.cross(dtheta, dr) / 2  # the series of exp's translation; what is left out is third order
    return q_est, so3.matrix(back) @ (r - V_dr)


def ours_of(convention, R, r):
    """J of e_ours = J e_theirs, written independently of the program."""
    order, turn, place = convention.split(",")
    p, t = (slice(0, 3), slice(3, 6)) if order == "position-first" else (slice(3, 6), slice(0, 3))
    J = np.zeros((6, 6))
    J[:3, p] = R if place == "local" else np.eye(3)
    if place == "spatial":
        J[:3, t] = -so3.hat(r)
    J[3:, t] = R.T if turn == "left" else np.eye(3)
    return J


def write_tum(file, times, poses):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("".join(f"{t!r} " + " ".join(f"{x:.17g}" for x in (*r, *q)) + "\n" for t, (q, r) in zip(times, poses)))


def write_covariances(file, times, covariances):
    rows = ["timestamp," + ",".join(f"p{i}{j}" for i in range(1, 7) for j in range(i, 7))]
    rows += [",".join(f"{x:.17g}" for x in (t, *P[np.triu_indices(6)])) for t, P in zip(times, covariances)]
    file.write_text("\n".join(rows) + "\n")


def timed(run):
    """The time and what follows it, of each pose."""
    return [(float(time), rest) for time, rest in (row.split(" ", 1) for row in (run / "trajectory.tum").read_text().splitlines())]


def break_covariance(run, row):
    """Its first variance is negative from now on."""
    rows = (run / "pose_covariance.csv").read_text().splitlines()
    rows[row] = rows[row].replace(",", ",-", 1)
    (run / "pose_covariance.csv").write_text("\n".join(rows) + "\n")


def pooled(page):
    return json.loads((page / "pooled.json").read_text())


def anees(page, estimator=0):
    return pooled(page)["estimators"][estimator]["anees"]["pose"]


class Judge(WithFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.sequence, cls.ekf = cls.folder / "sequence", cls.folder / "ekf"
        program("simulate", "circle", "--set", f"frames={FRAMES}", "--output", cls.sequence)
        program("run", cls.sequence, "--estimator", "ekf", "--set", "frames.last=20", "--output", cls.ekf)
        rows = np.loadtxt(cls.sequence / "groundtruth.tum")
        cls.times = [float(t) for t in rows[:, 0]]
        cls.truth = [(row[4:], row[1:4]) for row in rows]
        rng = np.random.default_rng(5)
        A = rng.normal(size=(6, 6))
        cls.P = 1e-6 * (A @ A.T + np.eye(6))  # small: conversions are to first order

    def setUp(self):
        self.here = self.folder / self.id().split(".")[-1]
        self.here.mkdir()

    def made_here(self, name="run"):
        """A run of this program, to be changed."""
        return shutil.copytree(self.ekf, self.here / name)

    def draw(self, name, runs, convention=CONVENTIONS[0], stated=1.0, seed=1):
        rng = np.random.default_rng(seed)
        root = np.linalg.cholesky(self.P)
        folders = []
        for i in range(runs):
            folders.append(self.here / f"{name}-{i + 1:02}")
            poses = [disturbed(q, r, root @ rng.normal(size=6), convention) for q, r in self.truth]
            write_tum(folders[-1] / "trajectory.tum", self.times, poses)
            write_covariances(folders[-1] / "pose_covariance.csv", self.times, [stated * self.P] * FRAMES)
        return folders

    def evaluate(self, *runs_and_more, **of_program):
        return program("evaluate", *runs_and_more, "--against", self.sequence, **of_program)

    def report(self, runs, *more):
        page = self.here / "page"
        done = program("report", *runs, "--against", self.sequence, "--output", page, *more)
        return page, done.stdout

    def test_poses_drawn_from_what_is_stated_have_anees_6_and_from_four_times_it_24(self):
        honest, sure = self.draw("honest", RUNS), self.draw("sure", RUNS, stated=0.25)
        page, out = self.report(honest + sure)
        of_honest, of_sure = anees(page), anees(page, 1)
        self.assertAlmostEqual(of_honest["mean"], 6.0, delta=0.1)
        drawn = np.random.default_rng(1).normal(size=(RUNS, FRAMES, 6))[:, 1:]  # as draw() has them; the first frame is left out
        self.assertAlmostEqual(of_honest["mean"], np.mean(np.sum(drawn**2, axis=2)), delta=1e-4)
        self.assertAlmostEqual(of_sure["mean"], 4 * of_honest["mean"], delta=1e-6)
        expected = 1.96 * np.sqrt(12.0 / (RUNS * (FRAMES - 1)))  # the variance of chi-square(6) is 12
        self.assertAlmostEqual((of_honest["upper"] - of_honest["lower"]) / 2, expected, delta=0.35 * expected)
        self.assertGreater(of_honest["inside"], 0.9)
        self.assertEqual(of_sure["inside"], 0.0)
        row = next(line for line in out.splitlines() if line.startswith("honest"))
        self.assertIn(f"{of_honest['mean']:.3f} [{of_honest['lower']:.3f}, {of_honest['upper']:.3f}]", row)
        self.assertRegex(row, rf"^honest +{RUNS} +100.0%")
        self.assertTrue((page / "report.html").is_file())

    def test_an_error_in_each_convention_has_the_nees_with_which_it_was_drawn(self):
        drawn = np.random.default_rng(1).normal(size=(FRAMES, 6))[1:]
        for convention in CONVENTIONS:
            with self.subTest(convention=convention):
                run, = self.draw(convention.replace(",", "-"), 1, convention)
                found = self.errors(run, "--error-convention", convention)["nees"]["pose"]["mean"]
                turns_about_the_origin = convention.endswith("spatial")  # far away: the second order is seen
                self.assertAlmostEqual(found, np.mean(np.sum(drawn**2, axis=1)), delta=0.01 if turns_about_the_origin else 1e-4)

    def test_a_run_states_its_own_convention(self):
        run, = self.draw("stated", 1, "rotation-first,left,local")
        said = self.errors(run, "--error-convention", "rotation-first,left,local")["nees"]
        (run / "run.yaml").write_text("estimator: mine\nerror_convention: rotation-first,left,local\n")
        self.assertEqual(self.errors(run)["nees"], said)
        (run / "run.yaml").write_text("error_convention: rotation-first\n")
        self.assert_refused(run, r"run\.yaml: the error convention 'rotation-first' is not of the form")

    def test_poses_of_a_body_are_judged_as_those_of_its_camera(self):
        camera, = self.draw("camera", 1)
        expected = self.errors(camera)
        q, t = so3.exp(np.array([0.4, -1.1, 0.7])), np.array([0.1, -0.2, 0.3])  # of the camera in the body
        back = so3.exp(-np.array([0.4, -1.1, 0.7]))
        poses, covariances = [], []
        for row in np.loadtxt(camera / "trajectory.tum"):
            q_body = so3.multiply(row[4:], back)
            R = so3.matrix(q_body)
            poses.append((q_body, row[1:4] - R @ t))
            J = np.block([[np.eye(3), R @ so3.hat(t) @ so3.matrix(q)], [np.zeros((3, 3)), so3.matrix(q)]])
            covariances.append(J @ self.P @ J.T)
        body = self.here / "body"
        write_tum(body / "trajectory.tum", self.times, poses)
        write_covariances(body / "pose_covariance.csv", self.times, covariances)
        file = self.here / "T_BC.txt"
        file.write_text(" ".join(f"{x:.17g}" for x in (*t, *q)) + "\n")
        self.assertIn("a constant rotation of", self.evaluate(body).stderr)
        self.assertEqual(self.evaluate(body, "--extrinsics", file).stderr, "")
        found = self.errors(body, "--extrinsics", file)
        for part in ("pose", "position", "rotation"):
            self.assertAlmostEqual(found["nees"][part]["mean"], expected["nees"][part]["mean"], delta=1e-6)
        self.assertAlmostEqual(found["accuracy"]["rotation_rmse_deg"], expected["accuracy"]["rotation_rmse_deg"], delta=1e-9)
        file.write_text("0 0 0 0 0 0\n")
        self.assert_refused(body, r"T_BC\.txt:1: expected 7 fields", "--extrinsics", file)

    def test_all_36_numbers_of_a_covariance_are_read(self):
        run, = self.draw("whole", 1)
        upper = self.errors(run)["nees"]
        rows = [",".join(f"{x:.17g}" for x in (t, *self.P.ravel())) for t in self.times]
        (run / "pose_covariance.csv").write_text("\n".join(rows) + "\n")
        self.assertEqual(self.errors(run)["nees"], upper)
        (run / "pose_covariance.csv").write_text("\n".join([rows[0].replace(",", ",1", 2), *rows[1:]]) + "\n")
        self.assert_refused(run, r"covariance\.csv:1: the 36 numbers are no symmetric matrix")

    def test_each_convention_of_one_covariance_gives_the_same_nees(self):
        run, = self.draw("run", 1)
        rows = np.loadtxt(run / "trajectory.tum")
        expected = None
        for convention in CONVENTIONS:
            J = [np.linalg.inv(ours_of(convention, so3.matrix(row[4:]), row[1:4])) for row in rows]
            write_covariances(run / "pose_covariance.csv", self.times, [j @ self.P @ j.T for j in J])
            nees = self.errors(run, "--error-convention", convention)["nees"]
            found = [nees[part]["mean"] for part in ("pose", "position", "rotation")]
            expected = expected or found
            np.testing.assert_allclose(found, expected, rtol=1e-6)
        # Taken for what it is not, it is something else.
        self.assertGreater(abs(self.errors(run)["nees"]["pose"]["mean"] - expected[0]), 0.5)
        for wrong, reason in (("rotation-first,right,spatial", "goes with a left"), ("position-first,right", "ORDER,ROTATION,POSITION"),
                              ("position-first,up,global", "'up' .* is none of right, left")):
            self.assert_refused(run, reason, "--error-convention", wrong)

    def test_what_a_report_writes_can_be_reported_again(self):
        run, = self.draw("mine", 1, "rotation-first,left,local")
        page, _ = self.report([run], "--error-convention", "rotation-first,left,local")
        again = program("evaluate", page / "mine-01", "--json", self.here / "again.json").stdout
        self.assertRegex(again, r"(?m)^mine-01 +mine ")
        judged, = json.loads((self.here / "again.json").read_text()).values()
        self.assertAlmostEqual(judged["filtered"]["nees"]["pose"]["mean"], anees(page)["mean"], delta=1e-9)
        before = contents(page)
        self.assertIn("would write over the run", program("report", page / "mine-01", "--output", page, "--force", code=2).stderr)
        self.assertEqual(contents(page), before)

    # --- formats -------------------------------------------------------------------------------------

    def files(self):
        """The same trajectory in each format."""
        run, = self.draw("run", 1)
        rows = np.loadtxt(run / "trajectory.tum")
        upper = np.triu_indices(3)
        P = self.P
        both = " ".join(f"{x:.17g}" for x in (*P[3:, 3:][upper], *P[:3, :3][upper]))
        euroc = "\n".join(f"{round(1e9 * row[0])}," + ",".join(f"{x:.17g}" for x in (*row[1:4], row[7], *row[4:7])) for row in rows)
        lines = {
            "tum": (run / "trajectory.tum").read_text().splitlines(),
            "ov_eval": [f"{line} {both}" for line in (run / "trajectory.tum").read_text().splitlines()],
            "kitti": [" ".join(f"{x:.17g}" for x in np.column_stack([so3.matrix(row[4:]), row[1:4]]).ravel()) for row in rows],
            "euroc": ["#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z", *euroc.splitlines()]}
        return run, lines

    def errors(self, run, *more, code=0):
        file = self.here / "metrics.json"
        done = self.evaluate(run, "--json", file, "--force", *more, code=code)
        return json.loads(file.read_text())[str(run)]["filtered"] if code == 0 else done.stderr

    def assert_refused(self, run, reason, *more):
        self.assertRegex(self.errors(run, *more, code=2), reason)

    def test_every_format_is_the_same_trajectory(self):
        run, lines = self.files()
        expected = self.errors(run)
        for name, rows in lines.items():
            with self.subTest(format=name):
                file = self.here / f"{name}.txt"
                file.write_text("\n".join(rows) + "\n")
                found = self.errors(file)
                for key in ("poses", "position_rmse_m", "rotation_rmse_deg", "ate_sim3_m", "coverage"):
                    self.assertAlmostEqual(found["accuracy"][key], expected["accuracy"][key], delta=1e-9)
                if name == "ov_eval":  # says nothing of position with rotation
                    self.assertIsNone(found["nees"]["pose"]["mean"])
                    for part in ("position", "rotation"):
                        self.assertAlmostEqual(found["nees"][part]["mean"], expected["nees"][part]["mean"], delta=1e-6)
                else:
                    self.assertIsNone(found["nees"])

    def test_bad_files_are_refused_in_one_line(self):
        _, lines = self.files()
        for name, rows in lines.items():
            head, separator = len(rows) - FRAMES, "," if name == "euroc" else " "
            cells = rows[head + 7].split(separator)

            def with_row(*cells, head=head, rows=rows, separator=separator):
                return [*rows[:head + 7], separator.join(cells), *rows[head + 8:]]

            at, last = rf"bad\.txt:{head + 8}: ", rows[-1]
            broken = {
                "truncated": ([*rows[:-1], last[:len(last) // 2]], rf"bad\.txt:{len(rows)}: "),
                "nan": (with_row(*cells[:2], "nan", *cells[3:]), at + ".*nan"),
                "a column less": ([separator.join(row.split(separator)[:-1]) for row in rows], rf"bad\.txt:{head + 1}: .*columns"),
                "a column less in a row": (with_row(*cells[:-1]), at + "expected"),
                "a word": (with_row(*cells[:2], "x1", *cells[3:]), at),
                "no rotation": (with_row(cells[0], *["9"] * (len(cells) - 1)), at),
                "far": (with_row(*cells[:3], "1e300", *cells[4:]), at + "'1e300' is not plausible"),
                "empty": (rows[:head], r"bad\.txt: holds no pose")}
            if name == "kitti":
                broken["rows missing"] = (rows[:-5], rf"bad\.txt: {FRAMES - 5} rows without times, but the sequence has {FRAMES} frames")
            else:
                swapped = [*rows[:head + 7], rows[head + 8], rows[head + 7], *rows[head + 9:]]
                broken["unsorted"] = (swapped, rf"bad\.txt:{head + 9}: timestamp .* does not follow")
                late = [separator.join([str(int(c) + 10**12) if name == "euroc" else str(float(c) + 1000.0), *rest])
                        for c, *rest in (row.split(separator) for row in rows[head:])]
                broken["another sequence's times"] = (late, r"bad\.txt: no pose is within .* s of a frame")
            for what, (text, reason) in broken.items():
                with self.subTest(format=name, what=what):
                    (self.here / "bad.txt").write_text("\n".join(text) + "\n")
                    self.assert_refused(self.here / "bad.txt", reason)

    def test_bad_folders_are_refused_in_one_line(self):
        run, = self.draw("run", 1)
        good = (run / "pose_covariance.csv").read_text().splitlines()
        cells = good[5].split(",")
        for what, rows, reason in (
                ("truncated", good[:-1] + [good[-1][:60]], rf"covariance\.csv:{len(good)}: expected 22 fields"),
                ("nan", good[:5] + [",".join([*cells[:4], "nan", *cells[5:]])] + good[6:], r"covariance\.csv:6: 'nan'"),
                ("rows missing", good[:-3], rf"covariance\.csv: {FRAMES - 3} rows of {FRAMES} poses"),
                ("other times", [good[0], *good[2:], good[1]], r"covariance\.csv:2: the timestamp is not that of the pose"),
                ("columns", [row + ",0" for row in good], r"covariance\.csv:2: expected 22 fields")):
            with self.subTest(what=what):
                (run / "pose_covariance.csv").write_text("\n".join(rows) + "\n")
                self.assert_refused(run, reason)
        (run / "pose_covariance.csv").write_text("\n".join(row for row in good if row[0] in "-0123456789") + "\n")
        self.assertEqual(self.errors(run)["nees"]["pose"]["used"], FRAMES - 1)  # a heading is not needed
        (run / "pose_covariance.csv").unlink()
        self.assertIn("run-01: names no sequence: give one with --against", program("evaluate", run, code=2).stderr)
        self.assert_refused(run, "--error-convention is of a pose_covariance.csv made elsewhere: no run has one",
                            "--error-convention", "rotation-first,right,local")
        for text in ("- 1\n", "estimator: {a: 1}\n", "estimator: [\n"):
            (run / "run.yaml").write_text(text)
            self.assert_refused(run, r"run\.yaml:\d+: ")
        self.assert_refused(self.here / "nothing", "no such run")
        self.assert_refused(run.parent, r"trajectory\.tum")

    # --- times and sequences -------------------------------------------------------------------------

    def test_offset_and_largest_difference_of_times(self):
        run, = self.draw("run", 1)
        rows, file = timed(run), self.here / "late.tum"
        file.write_text("".join(f"{t + 5.02!r} {rest}\n" for t, rest in rows))
        self.assertEqual(self.errors(file, "--time-offset", -5.02)["accuracy"], self.errors(run)["accuracy"])
        near = self.errors(file, "--time-offset", -5.0)["accuracy"]  # 0.02 s off, a third of a frame
        self.assertEqual(near["poses"], FRAMES)
        warning = "the times of poses and frames differ by 0.02 s (median), of 0.0667 s between frames; see --time-offset"
        for offset, said in ((-5.0, f"slammot: warning: late: {warning}\n"), (-5.018, "")):
            self.assertEqual(self.evaluate(file, "--time-offset", offset).stderr, said)
        self.assert_refused(file, "within 0.01 s of a frame", "--time-offset", -5.0, "--max-difference", 0.01)
        self.assertLess(self.errors(file)["accuracy"]["coverage"], 0.8)
        file.write_text("".join(f"{round(1e9 * (t + 1.4e9))} {rest}\n" for t, rest in rows))  # as ORB-SLAM3 writes EuRoC
        self.assert_refused(file, "are these nanoseconds")

    def test_a_covariance_that_is_not_positive_definite_is_said(self):
        """Also of a run of this program, whose covariances are looked at again."""
        run, = self.draw("run", 1)
        ekf = self.made_here("ekf")
        reason = "from frame 7: covariances of the pose that are not positive definite: 1 of "
        for broken, row, more in ((run, 8, ["--against", self.sequence]), (ekf, -14, [])):
            break_covariance(broken, row)
            said = program("evaluate", broken, *more).stderr
            self.assertIn(f"slammot: warning: {broken.name}, {reason}", said)
        self.assertIn(f"21 of {FRAMES} frames have a pose", said)
        page, out = self.report([run])
        self.assertRegex(out, r"(?m)^run +1 +100\.0% +0 +0 +1 ")
        self.assertIn(f"{reason}{FRAMES - 1}", (page / "report.html").read_text())
        self.assertTrue("<td>∞</td>" in (page / "report.html").read_text())

    def edited(self, name):
        """A run of this program whose folder has this name, and a function that changes its metrics.json."""
        run = self.made_here(name)
        good = json.loads((run / "metrics.json").read_text())
        return run, lambda change: (run / "metrics.json").write_text(json.dumps(good | change(good)))

    def test_text_of_a_folder_moves_no_cursor_and_forges_no_line(self):
        run, edit = self.edited("ev\x1b[31m\x07")
        edit(lambda good: {"divergence": {"frame": 3, "reason": "gone\x07"}, "warnings": [
            {"frame": 3, "reason": "x\nslammot: all is well \x1b[32m"}]})
        text, forged = re.subn(r"(?m)^( +sha256: ).*$", r'\1"\\e[31m"', (run / "run.yaml").read_text())
        self.assertEqual(forged, 1)
        (run / "run.yaml").write_text(text)
        done = program("evaluate", run, "--force-sequence")
        self.assertIn(r"made from a sequence with SHA-256 \x1b[31m", done.stderr)
        self.assertIn(r"slammot: warning: ev\x1b[31m\x07, from frame 3: x\x0aslammot: all is well \x1b[32m" + "\n", done.stderr)
        self.assertNotRegex(done.stdout + done.stderr, r"[\x00-\x09\x0b-\x1f\x7f]")

    def test_numbers_of_a_folder_that_cannot_be_are_refused(self):
        run, edit = self.edited("run")
        for change in (lambda good: {"warnings": [{"frame": 1e300, "reason": "x"}]},
                       lambda good: {"warnings": [{"frame": -1, "reason": "x"}]},
                       lambda good: {"nis": good["nis"] | {"mean": 1e308}},
                       lambda good: {"nis": good["nis"] | {"joint_mean": -1e308}},
                       lambda good: {"runtime": good["runtime"] | {"smoothing_ms": 1e300}},
                       lambda good: {"coverage": good["coverage"] | {"accepted": 2**31 - 1, "rejected": 2**31 - 1}}):
            edit(change)
            self.assert_refused(run, r"metrics\.json: .*not (plausible|a count)")

    def test_a_run_counts_once_and_runs_that_share_one_pose_are_two(self):
        runs = self.draw("mine", 2)
        shutil.copytree(runs[0], self.here / "mine-07")
        for twice in ([runs[0], runs[0]], [*runs, self.here / "mine-07"]):
            error = program("report", *twice, "--against", self.sequence, "--output", self.here / "twice", code=2).stderr
            self.assertIn(" are the same run of mine: give it once", error)
            self.assertFalse((self.here / "twice").exists())
        for i, run in enumerate(runs):
            (first, _), *others = timed(run)
            rows = [(first, "0 0 0 0 0 0 1"), *others]
            (self.here / f"n-{i}.tum").write_text("".join(f"{1e9 * t:.17g} {rest}\n" for t, rest in rows))
        _, out = self.report(sorted(self.here.glob("n-*.tum")))
        self.assertRegex(out, r"(?m)^n +2 +1\.0% +2 +0 +2 ")

    def test_poses_of_few_frames_warn_and_are_not_compared(self):
        runs = {"nano": [], "slow": []}
        for run in self.draw("mine", 5):
            for (name, made), scale in zip(runs.items(), (1e9, 1.0)):
                made.append(self.here / f"{name}-{run.name}.tum")
                made[-1].write_text("".join(f"{scale * t:.17g} {rest}\n" for t, rest in timed(run)))
        done = self.evaluate(runs["nano"][0])
        self.assertIn(f"1 of {FRAMES} frames have a pose", done.stderr)
        self.assertRegex(done.stdout, r"(?m)^run +estimator +landmark model +coverage ")  # of one sequence, which is not named
        self.assertRegex(done.stdout, r"(?m)^nano-mine-01 +nano-mine +1\.0% +\S+ +\S+ +- +- +- ")  # nothing to align
        page, _ = self.report([*runs["nano"], *runs["slow"]])
        text = (page / "report.html").read_text()
        self.assertIn("nano-mine and slow-mine are not compared: they have poses of 1% and 100% of the frames.", text)
        self.assertNotIn("is more accurate than", text)
        pair, = pooled(page)["pairs"]
        self.assertEqual(pair["pairs"], 0)

    def test_runs_on_two_sequences_are_not_ranked(self):
        run, = self.draw("mine", 1)
        other, ekf = self.here / "other", self.here / "ekf"
        program("simulate", "circle", "--set", "frames=10", "--seed", 9, "--output", other)
        program("run", other, "--estimator", "ekf", "--output", ekf)
        page = self.here / "page"
        program("report", run, ekf, "--against", self.sequence, "--against", other, "--output", page)
        text = (page / "report.html").read_text()
        self.assertIn("on 2 sequences", text)
        for wrong in ("most accurate", "on the same", "Paired differences", '<td class="best"'):
            self.assertNotIn(wrong, text)
        both = [json.loads((page / "compare.json").read_text())["runs"][i]["sequence"] for i in (0, 1)]
        self.assertEqual(len({sequence["sha256"] for sequence in both}), 2)
        for sequence in both:
            self.assertTrue(f"<small>{sequence['name']}</small>" in text)
        table = program("evaluate", run, ekf, "--against", self.sequence, "--against", other).stdout
        self.assertRegex(table, r"(?m)^run +estimator +landmark model +sequence +coverage ")

    def test_settings_that_each_sequence_decides_make_no_other_estimator(self):
        """Pooled where what was given is the same, however the scenes differ in their priors."""
        runs = []
        for name, speed in (("slow", 0.5), ("fast", 2.0)):
            program("simulate", "circle", "--set", "frames=5", "--set", f"max_speed={speed}", "--output", self.here / name)
            for given in ([], ["--set", "prior.max_speed=1"]):
                runs.append(self.here / f"{name}{len(given)}")
                program("run", self.here / name, "--estimator", "ekf", "--output", runs[-1], *given)
        page = self.here / "page"
        program("report", *runs, "--output", page)
        estimators = pooled(page)["estimators"]
        self.assertEqual([(e["name"], e["runs"]) for e in estimators], [("ekf slow0", 2), ("ekf slow2", 2)])

    def test_a_sequence_that_is_gone_is_named(self):
        run = self.made_here()
        file = run / "run.yaml"
        file.write_text(file.read_text().replace(str(self.sequence), str(self.here / "gone")))
        self.assertRegex(program("evaluate", run, code=2).stderr, r"run\.yaml: its sequence .*gone is not there: give it with --against")

    def test_footnotes_are_of_columns_that_are_there(self):
        run, = self.draw("run", 1)
        bare = self.here / "bare.tum"
        shutil.copy(run / "trajectory.tum", bare)
        for runs, of_nees in (([bare], False), ([run, bare], True)):
            out = self.evaluate(*runs).stdout
            self.assertEqual("In parentheses" in out, of_nees, out)
            self.assertEqual("(6)" in out, of_nees, out)
            self.assertIn("No NEES (not every pose has a covariance): bare.", out)
            self.assertNotIn("NIS", out)
            self.assertNotIn("r/w/u", out)
            words = f"Failed: the error exceeds {failure_bound(False)}; where the truth is measured, {failure_bound(True)}.\n"
            self.assertIn(words, out.replace("the\ntruth", "the truth"))  # as on the page

    def test_another_sequence_than_run_yaml_states_is_refused_unless_forced(self):
        run, other = self.made_here(), self.here / "other"
        program("simulate", "circle", "--set", f"frames={FRAMES}", "--seed", 2, "--output", other)
        done = program("evaluate", run, "--against", other, code=2)
        self.assertRegex(done.stderr, r"\Aslammot: .*run\.yaml: was made from a sequence with SHA-256 .* --force-sequence .*\n\Z")
        self.assertIn("was made from a sequence", program("evaluate", run, "--against", other, "--force-sequence").stderr)
        moved = self.here / "moved"
        shutil.copytree(self.sequence, moved)
        self.assertIn(" are for runs made elsewhere: ", program("evaluate", run, "--time-offset", 1.0, code=2).stderr)
        out = program("evaluate", run, "--against", moved).stdout  # the same content elsewhere
        self.assertRegex(out, r"(?m)^run +ekf +\S+ +21\.0% ")

    def test_a_run_that_failed_says_so_everywhere(self):
        far = self.here / "far.tum"
        write_tum(far, self.times, [(q, 3.0 * r) for q, r in self.truth])
        table = self.evaluate(far).stdout
        row = next(line for line in table.splitlines() if line.startswith("far"))
        self.assertRegex(row, r" frame \d+ +no$")
        page, out = self.report([far])
        self.assertRegex(out, r"(?m)^far +1 +100\.0% +1 +0 +0 ")
        self.assertIsNotNone(re.search(r"failed at frame \d+", (page / "report.html").read_text()))

    # --- docs/judge.md -------------------------------------------------------------------------------

    def test_the_script_of_the_docs_beside_the_ekf(self):
        text = (ROOT / "docs" / "judge.md").read_text(encoding="utf-8")
        script = re.search(r"(?m)(?:^    .*\n|^\n)+", text[text.index("`dead_reckoning.py`:") + 20:])[0]
        self.assertLessEqual(len([line for line in script.splitlines() if line.strip()]), 20)
        file, seeds = self.here / "dead_reckoning.py", 10
        file.write_text(re.sub("(?m)^    ", "", script))
        against, reckoned, ekf = [], [], []
        for seed in range(1, seeds + 1):
            sequence = self.here / f"seed-{seed}"
            program("simulate", "model_matched", "--seed", seed, "--set", "frames=40", "--set", "visible=10", "--output", sequence)
            against += ["--against", sequence]
            for name, done in (("dead_reckoning", reckoned), ("ekf", ekf)):
                done.append(self.here / "runs" / f"{name}-{seed}")
            subprocess.run(["/usr/bin/python3", str(file), str(sequence), str(reckoned[-1])], check=True)
            program("run", sequence, "--estimator", "ekf", "--output", ekf[-1])
        page = self.here / "page"
        out = program("report", *reckoned, *ekf, *against * 2, "--output", page).stdout
        content = pooled(page)
        self.assertEqual([(e["name"], e["runs"]) for e in content["estimators"]], [("dead_reckoning", seeds), ("ekf", seeds)])
        self.assertAlmostEqual(anees(page)["mean"], 6.0, delta=1.5, msg=out)
        pair, = content["pairs"]
        self.assertEqual((pair["pairs"], pair["wins_b"]), (seeds, seeds), out)
        self.assertIsNone(pair["difference"]["value"], "dead reckoning fails, and has lost without a figure")
        self.assertIn(f"{seeds} sequences: model_matched-1 to model_matched-{seeds}</h1>", (page / "report.html").read_text(encoding="utf-8"))


if __name__ == "__main__":
    unittest.main()
