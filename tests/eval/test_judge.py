"""slammot evaluate and report on runs made elsewhere: poses drawn from a stated covariance have the NEES they must have, in
every error convention; the example of docs/judge.md runs; and what is wrong with a file is said in one line.

usage: test_judge.py SLAMMOT
"""
import itertools
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

SLAMMOT = ""
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
from slammot.report.verdict import failure_bound  # noqa: E402

FRAMES, RUNS = 300, 20
CONVENTIONS = [",".join(words) for words in itertools.product(("position-first", "rotation-first"), ("right", "left"),
                                                              ("global", "local", "spatial")) if words[1:] != ("right", "spatial")]


def slammot(*arguments, code=0):
    done = subprocess.run([SLAMMOT, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == code, f"exit {done.returncode}\n{done.stdout}{done.stderr}"
    return done


def hat(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def exp_so3(a):
    angle = np.linalg.norm(a)
    if angle < 1e-9:
        return np.eye(3) + hat(a)
    return np.eye(3) + np.sin(angle) / angle * hat(a) + (1 - np.cos(angle)) / angle**2 * hat(a) @ hat(a)


def rotation(q):
    x, y, z, w = q
    return np.eye(3) + 2 * w * hat([x, y, z]) + 2 * hat([x, y, z]) @ hat([x, y, z])


def quaternion(R):
    """x, y, z, w of a turn by less than half."""
    w = np.sqrt(max(0.0, 1 + np.trace(R))) / 2
    if w > 0.1:
        return np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 4 * w * w]) / (4 * w)
    values, vectors = np.linalg.eigh(np.array([  # of the largest eigenvalue (Bar-Itzhack 2000)
        [R[0, 0] - R[1, 1] - R[2, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[2, 1] - R[1, 2]],
        [0, R[1, 1] - R[0, 0] - R[2, 2], R[1, 2] + R[2, 1], R[0, 2] - R[2, 0]],
        [0, 0, R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
        [0, 0, 0, np.trace(R)]]), UPLO="U")
    return vectors[:, 3]


def disturbed(R, r, error, convention):
    """The estimate of which (R, r) is the truth when this is its error in this convention."""
    order, turn, place = convention.split(",")
    dr, dtheta = (error[:3], error[3:]) if order == "position-first" else (error[3:], error[:3])
    E = exp_so3(dtheta)
    R_est = R @ E.T if turn == "right" else E.T @ R
    if place == "global":
        return R_est, r - dr
    if place == "local":
        return R_est, r - R_est @ dr
    V_dr = dr + np.cross(dtheta, dr) / 2  # the series of exp's translation; what is left out is third order
    return R_est, E.T @ (r - V_dr)


def ours_of(convention, R, r):
    """J of e_ours = J e_theirs, written independently of the program."""
    order, turn, place = convention.split(",")
    p, t = (slice(0, 3), slice(3, 6)) if order == "position-first" else (slice(3, 6), slice(0, 3))
    J = np.zeros((6, 6))
    J[:3, p] = R if place == "local" else np.eye(3)
    if place == "spatial":
        J[:3, t] = -hat(r)
    J[3:, t] = R.T if turn == "left" else np.eye(3)
    return J


def write_tum(file, times, poses):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("".join(f"{t!r} " + " ".join(f"{x:.17g}" for x in (*r, *quaternion(R))) + "\n"
                            for t, (R, r) in zip(times, poses)))


def write_covariances(file, times, covariances):
    rows = ["timestamp," + ",".join(f"p{i}{j}" for i in range(1, 7) for j in range(i, 7))]
    rows += [",".join(f"{x:.17g}" for x in (t, *P[np.triu_indices(6)])) for t, P in zip(times, covariances)]
    file.write_text("\n".join(rows) + "\n")


def pooled(page):
    return json.loads((page / "pooled.json").read_text())


def anees(page, estimator=0, part="pose"):
    return pooled(page)["estimators"][estimator]["anees"][part]


class Judge(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.sequence = cls.folder / "sequence"
        slammot("simulate", "circle", "--set", f"frames={FRAMES}", "--output", cls.sequence)
        rows = np.loadtxt(cls.sequence / "groundtruth.tum")
        cls.times = [float(t) for t in rows[:, 0]]
        cls.truth = [(rotation(row[4:]), row[1:4]) for row in rows]
        rng = np.random.default_rng(5)
        A = rng.normal(size=(6, 6))
        cls.P = 1e-6 * (A @ A.T + np.eye(6))  # small: conversions are to first order

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def setUp(self):
        self.here = self.folder / self.id().split(".")[-1]
        self.here.mkdir()

    def draw(self, name, runs, convention=CONVENTIONS[0], stated=1.0, seed=1):
        rng = np.random.default_rng(seed)
        root = np.linalg.cholesky(self.P)
        folders = []
        for i in range(runs):
            folders.append(self.here / f"{name}-{i + 1:02}")
            poses = [disturbed(R, r, root @ rng.normal(size=6), convention) for R, r in self.truth]
            write_tum(folders[-1] / "trajectory.tum", self.times, poses)
            write_covariances(folders[-1] / "pose_covariance.csv", self.times, [stated * self.P] * FRAMES)
        return folders

    def report(self, runs, *more):
        page = self.here / "page"
        done = slammot("report", *runs, "--against", self.sequence, "--output", page, *more)
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
        content = json.loads((page / "compare.json").read_text())
        for key in ("position_rmse_m", "rotation_rmse_deg", "ate_se3_m", "ate_sim3_m", "rpe_1s_position_rmse_m"):
            of_runs = [run["metrics"]["filtered"]["accuracy"][key] for run in content["runs"][:RUNS]]
            of_all = pooled(page)["estimators"][0]["values"][key]["value"]
            self.assertAlmostEqual(of_all, np.sqrt(np.mean(np.square(of_runs))), places=12)

    def test_errors_drawn_in_each_convention_have_anees_6(self):
        for convention in CONVENTIONS:
            with self.subTest(convention=convention):
                runs, file = self.draw(convention.replace(",", "-"), RUNS, convention), self.here / "metrics.json"
                slammot("evaluate", *runs, "--against", self.sequence, "--error-convention", convention, "--json", file, "--force")
                nees = [run["filtered"]["nees"]["pose"]["mean"] for run in json.loads(file.read_text()).values()]
                self.assertEqual(len(nees), RUNS)
                self.assertAlmostEqual(np.mean(nees), 6.0, delta=0.1)

    def test_each_convention_of_one_covariance_gives_the_same_nees(self):
        run, = self.draw("run", 1)
        rows = np.loadtxt(run / "trajectory.tum")
        expected = None
        for convention in CONVENTIONS:
            J = [np.linalg.inv(ours_of(convention, rotation(row[4:]), row[1:4])) for row in rows]
            write_covariances(run / "pose_covariance.csv", self.times, [j @ self.P @ j.T for j in J])
            nees = self.errors(run, "--error-convention", convention)["nees"]
            found = [nees[part]["mean"] for part in ("pose", "position", "rotation")]
            expected = expected or found
            np.testing.assert_allclose(found, expected, rtol=1e-6)
        # Taken for what it is not, it is something else.
        self.assertGreater(abs(self.errors(run)["nees"]["pose"]["mean"] - expected[0]), 0.5)
        for wrong, reason in (("rotation-first,right,spatial", "goes with a left"), ("position-first,right", "ORDER,ROTATION,POSITION"),
                              ("position-first,up,global", "'up' .* is none of right, left")):
            error = slammot("evaluate", run, "--against", self.sequence, "--error-convention", wrong, code=2).stderr
            self.assertRegex(error, rf"\A.*{reason}.*\n\Z")

    def test_what_a_report_writes_can_be_reported_again(self):
        run, = self.draw("mine", 1, "rotation-first,left,local")
        page, _ = self.report([run], "--error-convention", "rotation-first,left,local")
        again = self.here / "again"
        slammot("report", page / "mine-01", "--output", again)
        self.assertAlmostEqual(anees(again)["mean"], anees(page)["mean"], delta=1e-9)
        self.assertEqual(pooled(again)["estimators"][0]["name"], "mine")
        self.assertIn("would write over the run", slammot("report", page / "mine-01", "--output", page, "--force", code=2).stderr)

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
            "kitti": [" ".join(f"{x:.17g}" for x in np.column_stack([rotation(row[4:]), row[1:4]]).ravel()) for row in rows],
            "euroc": ["#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z", *euroc.splitlines()]}
        return run, lines

    def errors(self, run, *more, code=0):
        file = self.here / "metrics.json"
        done = slammot("evaluate", run, "--against", self.sequence, "--json", file, "--force", *more, code=code)
        return json.loads(file.read_text())[str(run)]["filtered"] if code == 0 else done.stderr

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

    def assert_refused(self, run, reason, *more):
        error = self.errors(run, *more, code=2)
        self.assertEqual(error.count("\n"), 1, error)
        self.assertRegex(error, reason)

    def test_bad_files_are_refused_in_one_line(self):
        _, lines = self.files()
        for name, rows in lines.items():
            head = len(rows) - FRAMES
            separator = "," if name == "euroc" else " "
            cells = rows[head + 7].split(separator)
            moved = separator.join(["1e12" if name != "euroc" else "10" * 9, *cells[1:]])
            at = rf"bad\.txt:{head + 8}: "
            broken = {
                "truncated": (rows[:-1] + [rows[-1][:len(rows[-1]) // 2]], rf"bad\.txt:{len(rows)}: "),
                "nan": (rows[:head + 7] + [separator.join([*cells[:2], "nan", *cells[3:]])] + rows[head + 8:], at + ".*nan"),
                "a column less": ([separator.join(row.split(separator)[:-1]) for row in rows], rf"bad\.txt:{head + 1}: .*columns"),
                "a column less in a row": (rows[:head + 7] + [separator.join(cells[:-1])] + rows[head + 8:], at + "expected"),
                "a word": (rows[:head + 7] + [separator.join([*cells[:2], "x1", *cells[3:]])] + rows[head + 8:], at),
                "no rotation": (rows[:head + 7] + [separator.join([cells[0], *["9"] * (len(cells) - 1)])] + rows[head + 8:], at),
                "far": (rows[:head + 7] + [separator.join([*cells[:3], "1e300", *cells[4:]])] + rows[head + 8:], at + "'1e300' is not plausible"),
                "empty": (rows[:head], r"bad\.txt: holds no pose"),
            }
            if name == "kitti":
                broken["rows missing"] = (rows[:-5], r"bad\.txt: 295 rows without times, but the sequence has 300 frames")
            else:
                swapped = rows[:head + 7] + [rows[head + 8], rows[head + 7]] + rows[head + 9:]
                broken["unsorted"] = (swapped, rf"bad\.txt:{head + 9}: timestamp .* does not follow")
                late = [separator.join([str(int(c) + 10**12) if name == "euroc" else str(float(c) + 1000.0), *rest])
                        for c, *rest in (row.split(separator) for row in rows[head:])]
                broken["another sequence's times"] = (late, r"bad\.txt: no pose is within .* s of a frame")
            for what, (text, reason) in broken.items():
                with self.subTest(format=name, what=what):
                    self.assertNotEqual(text, rows, moved)
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
        error = slammot("evaluate", run, code=2).stderr
        self.assertRegex(error, r"\Aslammot: .*run-01: names no sequence: give one with --against\n\Z")
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
        rows = [row.split(" ", 1) for row in (run / "trajectory.tum").read_text().splitlines()]
        file = self.here / "late.tum"
        file.write_text("".join(f"{float(t) + 5.02!r} {rest}\n" for t, rest in rows))
        expected = self.errors(run)["accuracy"]
        self.assertEqual(self.errors(file, "--time-offset", -5.02)["accuracy"], expected)
        near = self.errors(file, "--time-offset", -5.0)["accuracy"]  # 0.02 s off, a third of a frame
        self.assertEqual(near["poses"], FRAMES)
        warning = "the times of poses and frames differ by 0.02 s (median), of 0.0667 s between frames; see --time-offset"
        told = slammot("evaluate", file, "--against", self.sequence, "--time-offset", -5.0).stderr
        self.assertEqual(told, f"slammot: warning: late: {warning}\n")
        self.assertEqual(slammot("evaluate", file, "--against", self.sequence, "--time-offset", -5.018).stderr, "")
        page, _ = self.report([file], "--time-offset", -5.0)
        self.assertTrue(f"late: {warning}." in (page / "report.html").read_text())
        self.assert_refused(file, "within 0.01 s of a frame", "--time-offset", -5.0, "--max-difference", 0.01)
        self.assertLess(self.errors(file)["accuracy"]["coverage"], 0.8)
        file.write_text("".join(f"{round(1e9 * (float(t) + 1.4e9))} {rest}\n" for t, rest in rows))  # as ORB-SLAM3 writes EuRoC
        self.assert_refused(file, "are these nanoseconds")

    def test_a_frame_is_judged_once_however_dense_the_poses(self):
        run, = self.draw("run", 1)
        expected = self.errors(run)["accuracy"]
        rows = [row.split(" ", 1) for row in (run / "trajectory.tum").read_text().splitlines()]
        dense = self.here / "dense.tum"
        far = " 99 99 99 0 0 0 1"
        dense.write_text("".join(f"{float(t)!r} {rest}\n{float(t) + 0.01!r}{far}\n{float(t) + 0.02!r}{far}\n" for t, rest in rows))
        self.assertEqual(self.errors(dense)["accuracy"], expected)

    def test_an_earlier_page_is_replaced_only_when_forced(self):
        run, = self.draw("run", 1)
        page, _ = self.report([run])
        before = {file: file.read_bytes() for file in page.rglob("*") if file.is_file()}
        error = slammot("report", run, "--against", self.sequence, "--output", page, code=2).stderr
        self.assertRegex(error, r"\Aslammot: .* holds a comparison already: --force replaces it\n\Z")
        self.assertEqual({file: file.read_bytes() for file in page.rglob("*") if file.is_file()}, before)
        slammot("report", run, "--against", self.sequence, "--output", page, "--force")
        foreign = self.here / "foreign"
        foreign.mkdir()
        (foreign / "notes.txt").write_text("mine")
        self.assertIn("not replaced", slammot("report", run, "--against", self.sequence, "--output", foreign, "--force", code=2).stderr)

    def test_a_covariance_that_is_not_positive_definite_is_said(self):
        run, = self.draw("run", 1)
        rows = (run / "pose_covariance.csv").read_text().splitlines()
        cells = rows[8].split(",")
        rows[8] = ",".join([cells[0], "-" + cells[1], *cells[2:]])
        (run / "pose_covariance.csv").write_text("\n".join(rows) + "\n")
        reason = f"from frame 7: covariances of the pose that are not positive definite: 1 of {FRAMES - 1}"
        self.assertIn(f"slammot: warning: run-01, {reason}", slammot("evaluate", run, "--against", self.sequence).stderr)
        page, out = self.report([run])
        self.assertRegex(out, r"(?m)^run +1 +100\.0% +0 +0 +1 ")
        self.assertIn(reason, (page / "report.html").read_text())
        self.assertTrue("<td>∞</td>" in (page / "report.html").read_text())

    def test_a_covariance_of_a_run_of_this_program_is_looked_at_again(self):
        run = self.here / "ekf"
        slammot("run", self.sequence, "--estimator", "ekf", "--set", "frames.last=20", "--output", run)
        rows = (run / "pose_covariance.csv").read_text().splitlines()
        cells = rows[-3].split(",")
        rows[-3] = ",".join([cells[0], "-" + cells[1], *cells[2:]])
        (run / "pose_covariance.csv").write_text("\n".join(rows) + "\n")
        error = slammot("evaluate", run).stderr
        self.assertIn("from frame 18: covariances of the pose that are not positive definite: 1 of 20", error)
        self.assertIn(f"21 of {FRAMES} frames have a pose", error)

    def edited(self, name):
        """A run of this program whose folder has this name, and a function that changes its metrics.json."""
        made, run = self.here / "made", self.here / name
        slammot("run", self.sequence, "--estimator", "ekf", "--set", "frames.last=20", "--output", made)
        made.rename(run)
        good = json.loads((run / "metrics.json").read_text())
        return run, lambda change: (run / "metrics.json").write_text(json.dumps(good | change(good)))

    def test_text_of_a_folder_moves_no_cursor_and_forges_no_line(self):
        run, edit = self.edited("ev\x1b[31m\x07")
        edit(lambda good: {"divergence": {"frame": 3, "reason": "gone\x07"}, "warnings": [
            {"frame": 3, "reason": "x\nslammot: all is well \x1b[32m"}]})
        text, forged = re.subn(r"(?m)^( +sha256: ).*$", r'\1"\\e[31m"', (run / "run.yaml").read_text())
        self.assertEqual(forged, 1)
        (run / "run.yaml").write_text(text)
        done = slammot("evaluate", run, "--force-sequence")
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

    def test_no_run_that_is_read_is_written_over(self):
        runs = self.draw("mine", 3)
        page = self.here / "page"
        inputs = [self.here / "x" / "mine", self.here / "y" / "mine"]
        for run, folder in zip(runs, inputs):
            shutil.copytree(run, folder)
        slammot("report", *inputs, "--against", self.sequence, "--output", page)
        shutil.copytree(runs[2], page / "x-mine", dirs_exist_ok=True)
        before = (page / "x-mine" / "trajectory.tum").read_bytes()
        error = slammot("report", *inputs, page / "x-mine", "--against", self.sequence, "--output", page, "--force", code=2).stderr
        self.assertIn("would write over the run", error)
        self.assertEqual((page / "x-mine" / "trajectory.tum").read_bytes(), before)

    def test_runs_that_share_one_pose_are_two(self):
        runs = self.draw("mine", 2)
        for i, run in enumerate(runs):
            rows = (run / "trajectory.tum").read_text().splitlines()
            rows[0] = rows[0].split(" ", 1)[0] + " 0 0 0 0 0 0 1"
            (self.here / f"n-{i}.tum").write_text("".join(f"{1e9 * float(t):.17g} {rest}\n" for t, rest in (row.split(" ", 1) for row in rows)))
        _, out = self.report(sorted(self.here.glob("n-*.tum")))
        self.assertRegex(out, r"(?m)^n +2 +0\.3% +0 +0 +2 ")

    def test_equal_runs_are_no_wins(self):
        runs = self.draw("mine", 12)
        for run in runs:
            other = self.here / run.name.replace("mine", "same")
            shutil.copytree(run, other)
            rows = [row.split() for row in (run / "trajectory.tum").read_text().splitlines()]
            (other / "trajectory.tum").write_text("".join(
                " ".join([row[0], f"{float(row[1]) * (1 + 1e-15):.17g}", *row[2:]]) + "\n" for row in rows))
        page, _ = self.report([*runs, *sorted(self.here.glob("same-*"))])
        pair, = pooled(page)["pairs"]
        self.assertEqual((pair["pairs"], pair["wins_a"], pair["wins_b"]), (12, 0, 0))
        self.assertEqual([pair["difference"][key] for key in ("value", "lower", "upper")], [0.0, 0.0, 0.0])

    def test_poses_of_few_frames_warn_and_are_not_compared(self):
        runs = self.draw("mine", 12)
        for run in runs:
            rows = [row.split(" ", 1) for row in (run / "trajectory.tum").read_text().splitlines()]
            for name, scale in (("nano", 1e9), ("slow", 1.0)):
                (self.here / name).mkdir(exist_ok=True)
                (self.here / name / f"{name}-{run.name}.tum").write_text("".join(f"{scale * float(t):.17g} {rest}\n" for t, rest in rows))
        nano, slow = (sorted((self.here / name).iterdir()) for name in ("nano", "slow"))
        done = slammot("evaluate", nano[0], "--against", self.sequence)
        self.assertIn(f"1 of {FRAMES} frames have a pose", done.stderr)
        self.assertRegex(done.stdout, r"(?m)^nano-mine-01 +nano-mine +0\.3% +\S+ +\S+ +- +- +- ")  # nothing to align
        page, _ = self.report([*nano, *slow])
        text = (page / "report.html").read_text()
        self.assertIn("nano-mine and slow-mine are not compared: they have poses of 0% and 100% of the frames.", text)
        self.assertNotIn("is more accurate than", text)
        pair, = pooled(page)["pairs"]
        self.assertEqual(pair["pairs"], 0)

    def test_runs_on_two_sequences_are_not_ranked(self):
        run, = self.draw("mine", 1)
        other, ekf = self.here / "other", self.here / "ekf"
        slammot("simulate", "circle", "--set", "frames=30", "--seed", 9, "--output", other)
        slammot("run", other, "--estimator", "ekf", "--output", ekf)
        page = self.here / "page"
        slammot("report", run, ekf, "--against", self.sequence, "--against", other, "--output", page)
        text = (page / "report.html").read_text()
        self.assertIn("on 2 sequences", text)
        for wrong in ("most accurate", "on the same", "Paired differences", '<td class="best"'):
            self.assertNotIn(wrong, text)
        both = [json.loads((page / "compare.json").read_text())["runs"][i]["sequence"] for i in (0, 1)]
        self.assertEqual(len({sequence["sha256"] for sequence in both}), 2)
        for sequence in both:
            self.assertTrue(f"<small>{sequence['name']}</small>" in text)
        table = slammot("evaluate", run, ekf, "--against", self.sequence, "--against", other).stdout
        self.assertRegex(table, r"(?m)^run +estimator +landmark model +sequence +coverage ")

    def test_settings_that_each_sequence_decides_make_no_other_estimator(self):
        """Pooled where what was given is the same, however the scenes differ in their priors."""
        runs = []
        for name, speed in (("slow", 0.5), ("fast", 2.0)):
            slammot("simulate", "circle", "--set", "frames=20", "--set", f"max_speed={speed}", "--output", self.here / name)
            for given in ([], ["--set", "prior.max_speed=1"]):
                runs.append(self.here / f"{name}{len(given)}")
                slammot("run", self.here / name, "--estimator", "ekf", "--output", runs[-1], *given)
        page = self.here / "page"
        slammot("report", *runs, "--output", page)
        estimators = pooled(page)["estimators"]
        self.assertEqual([(e["name"], e["runs"]) for e in estimators], [("ekf slow0", 2), ("ekf slow2", 2)])

    def test_a_sequence_that_is_gone_is_named(self):
        run = self.here / "run"
        slammot("run", self.sequence, "--estimator", "ekf", "--set", "frames.last=5", "--output", run)
        file = run / "run.yaml"
        file.write_text(file.read_text().replace(str(self.sequence), str(self.here / "gone")))
        error = slammot("evaluate", run, code=2).stderr
        self.assertRegex(error, r"\Aslammot: .*run\.yaml: its sequence .*gone is not there: give it with --against\n\Z")

    def test_a_run_counts_once(self):
        runs = self.draw("mine", 2)
        shutil.copytree(runs[0], self.here / "mine-07")
        for twice in ([runs[0], runs[0]], [*runs, self.here / "mine-07"]):
            error = slammot("report", *twice, "--against", self.sequence, "--output", self.here / "twice", code=2).stderr
            self.assertRegex(error, r"\Aslammot: .* are the same run of mine: give it once\n\Z")
            self.assertFalse((self.here / "twice").exists())

    def test_footnotes_are_of_columns_that_are_there(self):
        run, = self.draw("run", 1)
        bare = self.here / "bare.tum"
        shutil.copy(run / "trajectory.tum", bare)
        for runs, of_nees in (([bare], False), ([run, bare], True)):
            out = slammot("evaluate", *runs, "--against", self.sequence).stdout
            self.assertEqual("In parentheses" in out, of_nees, out)
            self.assertEqual("(6)" in out, of_nees, out)
            self.assertIn("No NEES (not every pose has a covariance): bare.", out)
            self.assertNotIn("NIS", out)
            self.assertNotIn("r/w/u", out)
            words = f"Failed: the error exceeds {failure_bound(False)}; where the truth is measured, {failure_bound(True)}.\n"
            self.assertIn(words, out.replace("the\ntruth", "the truth"))  # as on the page

    def test_coverage_of_few_poses(self):
        _, lines = self.files()
        (self.here / "short.tum").write_text("\n".join(lines["tum"][:8]) + "\n")
        self.assertAlmostEqual(self.errors(self.here / "short.tum")["accuracy"]["coverage"], 8 / FRAMES)
        out = slammot("evaluate", self.here / "short.tum", "--against", self.sequence).stdout
        self.assertRegex(out, r"(?m)^run +estimator +landmark model +coverage ")
        self.assertRegex(out, r"(?m)^short +short +2\.7% ")

    def test_another_sequence_than_run_yaml_states_is_refused_unless_forced(self):
        run, other = self.here / "run", self.here / "other"
        slammot("run", self.sequence, "--estimator", "ekf", "--set", "frames.last=20", "--output", run)
        slammot("simulate", "circle", "--set", f"frames={FRAMES}", "--seed", 2, "--output", other)
        done = slammot("evaluate", run, "--against", other, code=2)
        self.assertRegex(done.stderr, r"\Aslammot: .*run\.yaml: was made from a sequence with SHA-256 .* --force-sequence .*\n\Z")
        self.assertIn("was made from a sequence", slammot("evaluate", run, "--against", other, "--force-sequence").stderr)
        moved = self.here / "moved"
        shutil.copytree(self.sequence, moved)
        idle = slammot("evaluate", run, "--time-offset", 1.0, code=2).stderr
        self.assertRegex(idle, r"\Aslammot: .* are for runs made elsewhere: .*\n\Z")
        out = slammot("evaluate", run, "--against", moved).stdout  # the same content elsewhere
        self.assertRegex(out, r"(?m)^run +ekf +\S+ +7\.0% ")  # 21 of 300 frames

    def test_a_run_that_failed_says_so_everywhere(self):
        far = self.here / "far.tum"
        write_tum(far, self.times, [(R, 3.0 * r) for R, r in self.truth])
        table = slammot("evaluate", far, "--against", self.sequence).stdout
        row = next(line for line in table.splitlines() if line.startswith("far"))
        self.assertRegex(row, r" frame \d+ +no$")
        page, out = self.report([far])
        self.assertRegex(out, r"(?m)^far +1 +100\.0% +1 +0 +0 ")
        self.assertIsNotNone(re.search(r"failed at frame \d+", (page / "report.html").read_text()))

    # --- docs/judge.md -------------------------------------------------------------------------------

    def test_the_script_of_the_docs_beside_ekf_and_window(self):
        text = (ROOT / "docs" / "judge.md").read_text(encoding="utf-8")
        script = re.search(r"(?m)(?:^    .*\n|^\n)+", text[text.index("`dead_reckoning.py`:") + 20:])[0]
        self.assertLessEqual(len([line for line in script.splitlines() if line.strip()]), 20)
        file = self.here / "dead_reckoning.py"
        file.write_text(re.sub("(?m)^    ", "", script))
        against, runs = [], {"dead_reckoning": [], "ekf": [], "window": []}
        for seed in range(1, RUNS + 1):
            sequence = self.here / f"seed-{seed}"
            slammot("simulate", "model_matched", "--seed", seed, "--set", "frames=40", "--set", "visible=10", "--output", sequence)
            against += ["--against", sequence]
            for name, done in runs.items():
                done.append(self.here / "runs" / f"{name}-{seed}")
            subprocess.run(["/usr/bin/python3", str(file), str(sequence), str(runs["dead_reckoning"][-1])], check=True)
            slammot("run", sequence, "--estimator", "ekf", "--output", runs["ekf"][-1])
            slammot("run", sequence, "--estimator", "window", "--set", "window.frames=3", "--output", runs["window"][-1])
        page = self.here / "page"
        done = slammot("report", *sum(runs.values(), []), *against * 3, "--output", page)
        content = pooled(page)
        self.assertEqual([(e["name"], e["runs"]) for e in content["estimators"]], [(name, RUNS) for name in runs])
        reckoned = content["estimators"][0]["anees"]["pose"]
        self.assertAlmostEqual(reckoned["mean"], 6.0, delta=1.5, msg=done.stdout)
        pair = content["pairs"][0]  # dead reckoning and ekf
        self.assertEqual((pair["pairs"], pair["wins_b"]), (RUNS, RUNS), done.stdout)
        self.assertGreater(pair["difference"]["lower"], 0.0)
        self.assertIn("20 sequences: model_matched-1 to model_matched-20</h1>", (page / "report.html").read_text(encoding="utf-8"))
        shutil.rmtree(page / "dead_reckoning-1")
        slammot("report", page)  # again, from compare.json


if __name__ == "__main__":
    SLAMMOT = sys.argv.pop(1)
    unittest.main()
