"""slammot evaluate --align: a run is judged whatever frame and scale it is in, and what a fit leaves of NEES is said; packed
files, and runs that state few covariances.

usage: test_aligned.py SLAMMOT
"""
import gzip
import json
import math
import pathlib
import shutil
import unittest

import numpy as np

from fixture import WithFolder, contents, program
from slammot import so3

FRAMES = 40
FITS = ("first", "se3", "sim3")
LEFT = "takes {} of the {} degrees of freedom of {} poses, and all that their errors have in common: NEES is no verdict"


def write_run(folder, times, poses, covariances):
    """poses: (quaternion, position) each."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = (" ".join(f"{x:.17g}" for x in (t, *r, *q)) for t, (q, r) in zip(times, poses))
    (folder / "trajectory.tum").write_text("\n".join(rows) + "\n")
    if covariances is not None:
        rows = (",".join(f"{x:.17g}" for x in (t, *P[np.triu_indices(6)])) for t, P in zip(times, covariances))
        (folder / "pose_covariance.csv").write_text("\n".join(rows) + "\n")
    return folder


def pack(folder):
    for file in list(folder.iterdir()):
        pathlib.Path(f"{file}.gz").write_bytes(gzip.compress(file.read_bytes()))
        file.unlink()


def leaves(tree, path=""):
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{path}{key}.")
        else:
            yield path + key, value


class Program(WithFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.sequence, cls.ekf = cls.folder / "sequence", cls.folder / "ekf"
        program("simulate", "circle", "--set", f"frames={FRAMES}", "--output", cls.sequence)
        program("run", cls.sequence, "--estimator", "ekf", "--output", cls.ekf)
        rows = np.loadtxt(cls.sequence / "groundtruth.tum")
        cls.times, cls.truth = rows[:, 0].tolist(), [(row[4:], row[1:4]) for row in rows]

    def setUp(self):
        self.here = self.folder / self.id().split(".")[-1]
        self.here.mkdir()
        self.rng = np.random.default_rng(7)

    def evaluate(self, run, *more, code=0, against=None):
        """Its metrics and what was said, or the refusal."""
        file = self.here / "metrics.json"
        done = program("evaluate", run, "--against", against or self.sequence, "--json", file, "--force", *more, code=code)
        return (*json.loads(file.read_text()).values(), done.stdout + done.stderr) if code == 0 else done.stderr

    def drawn(self, name="mine", stated=1.0, first=1.0):
        """Poses with errors of full covariances, of which `stated` times as much is stated; the first has `first` times as much."""
        A = self.rng.normal(size=(FRAMES, 6, 6))
        P = 1e-6 * (A @ A.swapaxes(1, 2) + np.eye(6))
        P[0] *= first
        poses = []
        for (q, r), error in zip(self.truth, np.einsum("kij,kj->ki", np.linalg.cholesky(P), self.rng.normal(size=(FRAMES, 6)))):
            poses.append((so3.multiply(q, so3.exp(-error[3:])), r - error[:3]))
        return write_run(self.here / name, self.times, poses, stated * P), poses, stated * P

    def moved(self, poses, P, scale):
        """The same run in another gauge."""
        q, t = so3.exp(np.array([1.1, -0.4, 0.8])), np.array([30.0, -7.0, 12.0])
        B = np.eye(6)
        B[:3, :3] = scale * so3.matrix(q)
        return write_run(self.here / "moved", self.times, [(so3.multiply(q, x), B[:3, :3] @ r + t) for x, r in poses], B @ P @ B.T)


class Align(Program):
    def assert_same(self, found, expected, but=()):
        found, expected = dict(leaves(found)), dict(leaves(expected))
        self.assertEqual(set(found), set(expected))
        for key, value in expected.items():
            if isinstance(value, float) and not key.startswith(but):
                self.assertAlmostEqual(found[key], value, delta=2e-6 * max(1.0, abs(value)), msg=key)
            elif not isinstance(value, (float, list)):
                self.assertEqual(found[key], value, key)

    def test_the_gauge_of_a_run_does_not_matter(self):
        run, poses, P = self.drawn()
        for by in FITS:
            scale = 0.3 if by == "sim3" else 1.0
            expected, _ = self.evaluate(run, "--align", by)
            found, said = self.evaluate(self.moved(poses, P, scale), "--align", by)
            self.assert_same(found["filtered"], expected["filtered"])
            self.assertAlmostEqual(found["alignment"]["scale"] * scale, expected["alignment"]["scale"], places=9)
            self.assertNotIn("warning", said)
            plain, said = self.evaluate(self.here / "moved")
            self.assertGreater(plain["filtered"]["accuracy"]["position_rmse_m"], 1.0)
            if scale == 1.0:
                self.assertIn("another world", said)

    def test_a_run_of_this_program_too_with_its_landmarks(self):
        """Moved by hand: the alignment undoes it."""
        plain, _ = self.evaluate(self.ekf)
        held, _ = self.evaluate(self.ekf, "--align", "first")
        self.assert_same(held["filtered"], plain["filtered"])  # its first pose is the true one already
        self.assertTrue(held["alignment"]["verdict"])
        run = shutil.copytree(self.ekf, self.here / "run")
        q, scale, t = so3.exp(np.array([1.1, -0.4, 0.8])), 0.5, np.array([30.0, -7.0, 12.0])
        sR = scale * so3.matrix(q)
        rows = np.loadtxt(run / "trajectory.tum")
        for row in rows:
            row[1:4], row[4:] = sR @ row[1:4] + t, so3.multiply(q, row[4:])
        np.savetxt(run / "trajectory.tum", rows, fmt="%.17g")
        head, *lines = [line for line in (run / "landmarks.csv").read_text().splitlines() if not line.startswith("#")]
        columns, upper = head.split(","), np.triu_indices(3)
        position, velocity, p, v = (columns.index(name) for name in ("x", "vx", "p11", "v11"))
        for i, line in enumerate(lines):
            cells = line.split(",")
            for begin, offset in ((position, t), (velocity, np.zeros(3))):
                cells[begin:begin + 3] = map(repr, (sR @ [float(x) for x in cells[begin:begin + 3]] + offset).tolist())
            for begin in (p, v):
                C = np.zeros((3, 3))
                C[upper] = [float(x) for x in cells[begin:begin + 6]]
                cells[begin:begin + 6] = map(repr, (sR @ (C + np.triu(C, 1).T) @ sR.T)[upper].tolist())
            lines[i] = ",".join(cells)
        (run / "landmarks.csv").write_text("\n".join([head, *lines]) + "\n")
        expected, _ = self.evaluate(self.ekf, "--align", "sim3")
        found, _ = self.evaluate(run, "--align", "sim3")
        self.assertGreater(expected["landmark_nees"]["position"]["used"], 0)
        for block in ("landmark_errors", "landmark_nees"):
            self.assert_same(found[block], expected[block])

    def test_none_is_the_default_and_says_nothing(self):
        run, *_ = self.drawn()
        files = [self.here / "plain.json", self.here / "none.json"]
        said = [program("evaluate", run, "--against", self.sequence, "--json", file, *more).stdout
                for file, more in zip(files, ([], ["--align", "none"]))]
        self.assertEqual(said[0], said[1])
        self.assertEqual(files[0].read_bytes(), files[1].read_bytes())
        self.assertNotIn("aligned by", said[0] + files[0].read_text())
        self.assertRegex(self.evaluate(run, "--align", "yaw", code=2), "--align: yaw not in .*")

    def test_what_a_fit_leaves_is_said_on_terminal_file_and_page(self):
        runs = [self.drawn(f"mine-{i}", stated=0.25)[0] for i in range(1, 7)]  # overconfident
        for by, fitted in (("se3", 6), ("sim3", 7)):
            note = f"aligned by {by}, a fit to the truth that " + LEFT.format(fitted, 6 * FRAMES, FRAMES)
            metrics, said = self.evaluate(runs[0], "--align", by)
            self.assertIn(f"mine-1: {note}.", said)
            self.assertEqual(metrics["alignment"]["note"], note)
            self.assertEqual(metrics["alignment"]["degrees_of_freedom_left"], 6 * FRAMES - fitted)
            self.assertFalse(metrics["alignment"]["verdict"])
            for judged in (runs[:1], runs):
                page = self.here / f"{by}-{len(judged)}"
                program("report", *judged, "--against", self.sequence, "--align", by, "--output", page)
                text = (page / "report.html").read_text()
                self.assertIn(note, text)
                self.assertNotRegex(text, r"is (over|near|cons)[a-z ]+: |class=\"over\"")
        page = self.here / "none"
        program("report", *runs, "--against", self.sequence, "--output", page)
        self.assertRegex((page / "report.html").read_text(), "mine is overconfident: ")

    def test_the_first_pose_decides_where_it_is_held_fixed(self):
        held, _, _ = self.drawn("held", 0.25, first=1e-6)
        loose, _, _ = self.drawn("loose", 0.25)
        for run, verdict in ((held, True), (loose, False)):
            metrics, _ = self.evaluate(run, "--align", "first")
            self.assertEqual(metrics["alignment"]["verdict"], verdict)
            page = self.here / f"{run.name}-page"
            program("report", run, "--against", self.sequence, "--align", "first", "--output", page)
            text = (page / "report.html").read_text()
            self.assertEqual(f"{run.name} is overconfident" in text, verdict)
            self.assertIn(metrics["alignment"]["note"], text)

    def test_a_run_that_a_report_has_aligned_says_so_and_is_not_aligned_again(self):
        run, *_ = self.drawn()
        page = self.here / "page"
        program("report", run, "--against", self.sequence, "--align", "sim3", "--output", page)
        again, said = self.evaluate(page / "mine")
        self.assertIn("mine: aligned by sim3, ", said)
        self.assertEqual(again["alignment"], json.loads((page / "mine" / "metrics.json").read_text())["alignment"])
        self.assertRegex(self.evaluate(page / "mine", "--align", "se3", code=2), r"mine: is stored aligned by sim3, ")
        good = json.loads((page / "mine" / "metrics.json").read_text())
        for wrong in ({"poses": -1}, {"rotation": [1, 2]}, {"verdict": "no"}, {"scale": None}, {"translation": {}}):
            (page / "mine" / "metrics.json").write_text(json.dumps(good | {"alignment": good["alignment"] | wrong}))
            self.assertRegex(self.evaluate(page / "mine", code=2), r"metrics\.json: ")

    def test_what_shows_no_rotation_is_refused(self):
        line = [(q, (1.0 + 0.1 * t) * np.array([1.0, 2.0, 3.0])) for t, (q, _) in zip(self.times, self.truth)]
        still = [(q, np.ones(3)) for q, _ in self.truth]
        for name, poses in (("line", line), ("still", still), ("two", self.truth[:2])):
            run = write_run(self.here / name, self.times, poses, None)
            for by in ("se3", "sim3"):
                self.assertRegex(self.evaluate(run, "--align", by, code=2), rf"{name}: no rotation is seen in positions")
            self.assertNotIn("NEES is no verdict but", self.evaluate(run, "--align", "first")[1])

    def test_other_orders_are_still_hinted_at(self):
        _, poses, P = self.drawn()
        run = self.moved(poses, P, 0.5)
        rows = np.loadtxt(run / "trajectory.tum")
        np.savetxt(run / "trajectory.tum", rows[:, [0, 1, 2, 3, 7, 4, 5, 6]], fmt="%.17g")
        self.assertIn("with w first in the quaternions", self.evaluate(run, "--align", "sim3")[1])


class Packed(Program):
    def test_a_packed_sequence_and_a_packed_run_are_as_plain_ones(self):
        run, *_ = self.drawn()
        expected, table = self.evaluate(run)
        sequence = shutil.copytree(self.sequence, self.here / "sequence")
        pack(sequence)
        pack(run)
        self.assertEqual(self.evaluate(run, against=sequence), (expected, table))
        ekf, again = shutil.copytree(self.ekf, self.here / "ekf"), self.here / "again"
        plain, _ = self.evaluate(self.ekf)
        pack(ekf)
        self.assertEqual(self.evaluate(ekf, against=sequence)[0], plain)  # its SHA-256 is that of what is in it
        program("run", sequence, "--estimator", "ekf", "--output", again)
        self.assertEqual((again / "trajectory.tum").read_bytes(), (self.ekf / "trajectory.tum").read_bytes())
        page = self.here / "page"
        program("report", run, ekf, "--against", sequence, "--output", page)
        self.assertTrue((page / "ekf" / "run.yaml").is_file())

    def test_a_packed_file_of_each_format(self):
        run, *_ = self.drawn()
        expected = self.evaluate(run / "trajectory.tum")[0]["filtered"]
        for name, packed in (("mine.tum.gz", gzip.compress), ("two_parts.gz", lambda text: gzip.compress(text[:500]) + gzip.compress(text[500:]))):
            file = self.here / name
            file.write_bytes(packed((run / "trajectory.tum").read_bytes()))
            self.assertEqual(self.evaluate(file)[0]["filtered"], expected)

    def test_a_damaged_file_is_refused_in_one_line(self):
        run, *_ = self.drawn()
        file = self.here / "bad.gz"
        whole = gzip.compress((run / "trajectory.tum").read_bytes())
        for bad in (whole[:-9], whole[:len(whole) // 2], whole[:60] + bytes(40) + whole[100:], whole[:3]):
            file.write_bytes(bad)
            self.assertRegex(self.evaluate(file, code=2), r"bad\.gz: cannot be unpacked: damaged or cut off")
        file.write_bytes(gzip.compress(b"1 2 3\n"))
        self.assertRegex(self.evaluate(file, code=2), r"bad\.gz:1: 3 columns")

    def test_the_plain_file_is_taken_where_both_are_there(self):
        run, *_ = self.drawn()
        expected, _ = self.evaluate(run)
        (run / "trajectory.tum.gz").write_bytes(b"\x1f\x8b no")
        self.assertEqual(self.evaluate(run)[0], expected)


class FewCovariances(Program):
    """A run made elsewhere states what it can; the rest is null with its reason."""

    def assert_reasons(self, metrics):
        """Nothing is NaN, and beside a block that is null stands why."""
        def walk(tree):
            for key, value in tree.items():
                self.assertFalse(isinstance(value, float) and math.isnan(value), key)
                if isinstance(value, dict):
                    walk(value)
                    if value.get("used") == 0 and "mean" in value:
                        self.assertIsNone(value["mean"])
                        self.assertTrue(value["reason"])
                elif value is None and f"{key}_reason" in tree:
                    self.assertTrue(tree[f"{key}_reason"])
        walk(metrics)
        self.assertNotIn("NaN", (self.here / "metrics.json").read_text())
        for block in ("nees", "landmark_nees", "landmark_errors"):
            where = metrics["filtered"] if block == "nees" else metrics
            self.assertTrue(where[block] is not None or where[f"{block}_reason"])

    def test_poses_alone_and_poses_with_covariances(self):
        run, poses, P = self.drawn()
        with_P, _ = self.evaluate(run)
        self.assert_reasons(with_P)
        self.assertEqual(with_P["landmark_errors_reason"], "no estimated landmarks")
        without, said = self.evaluate(write_run(self.here / "bare", self.times, poses, None))
        self.assert_reasons(without)
        self.assertIn("No NEES (not every pose has a covariance)", said)
        self.assertEqual(without["filtered"]["accuracy"], with_P["filtered"]["accuracy"])
        page = self.here / "page"
        program("report", self.here / "bare", "--against", self.sequence, "--output", page)
        self.assertIn("Not judged: not every pose has a covariance", (page / "report.html").read_text())

    def test_landmarks_with_and_without_velocities_and_covariances(self):
        run, *_ = self.drawn()
        lines = [line.split(",") for line in (self.ekf / "landmarks.csv").read_text().splitlines() if line[:1].isdigit()]
        columns = {"all": range(21), "velocity covariances left out": range(15), "velocities and their covariances left out": [*range(6), *range(9, 15)],
                   "all covariances left out": range(9), "positions only": range(6)}
        found = {}
        for name, kept in columns.items():
            (run / "landmarks.csv").write_text("".join(",".join(line[i] for i in kept) + "\n" for line in lines))
            found[name], _ = self.evaluate(run)
            self.assert_reasons(found[name])
            for key in ("static_position_m", "moving_position_m"):
                self.assertEqual(found[name]["landmark_errors"][key], found["all"]["landmark_errors"][key], name)
            for part, states in (("position", len(kept) > 9), ("velocity", len(kept) == 21)):
                nees = found[name]["landmark_nees"][part]
                self.assertEqual(nees["mean"] == found["all"]["landmark_nees"][part]["mean"] and nees["used"] > 0,
                                 states and found["all"]["landmark_nees"][part]["used"] > 0, (name, part))
            moving = found[name]["landmark_errors"]["moving_velocity_m_s"]
            self.assertEqual(moving["used"], found["all"]["landmark_errors"]["moving_velocity_m_s"]["used"] if len(kept) not in (6, 12) else 0)
        self.assertGreater(found["all"]["landmark_nees"]["position"]["used"], 0)
        (run / "landmarks.csv").write_text("".join(",".join(line[:8]) + "\n" for line in lines))
        self.assertRegex(self.evaluate(run, code=2), r"landmarks\.csv:1: expected 21 fields, found 8")

    def test_a_body_without_covariances_or_with_some(self):
        """Neighbours of --extrinsics: no covariance, one of ov_eval's kind, and of a run that is aligned too."""
        run, poses, P = self.drawn()
        q, t = so3.exp(np.array([0.4, -1.1, 0.7])), np.array([0.1, -0.2, 0.3])
        file = self.here / "T_BC.txt"
        file.write_text(" ".join(f"{x:.17g}" for x in (*t, *q)) + "\n")
        body = []
        for q_camera, r in poses:
            q_body = so3.multiply(q_camera, so3.conjugate(q))
            body.append((q_body, r - so3.matrix(q_body) @ t))
        expected = self.evaluate(run)[0]["filtered"]["accuracy"]
        bare = write_run(self.here / "body", self.times, body, None)
        found, _ = self.evaluate(bare, "--extrinsics", file)
        self.assert_reasons(found)
        for key, value in leaves(expected):
            if isinstance(value, float):
                self.assertAlmostEqual(dict(leaves(found["filtered"]["accuracy"]))[key], value, places=8, msg=key)
        aligned = self.evaluate(run, "--align", "se3")[0]["filtered"]["accuracy"]["rotation_rmse_deg"]
        self.assertAlmostEqual(self.evaluate(bare, "--extrinsics", file, "--align", "se3")[0]["filtered"]["accuracy"]["rotation_rmse_deg"], aligned, places=8)
        upper = np.triu_indices(3)
        rows = (" ".join(f"{x:.17g}" for x in (time, *r, *x, *C[3:, 3:][upper], *C[:3, :3][upper])) for time, (x, r), C in zip(self.times, body, P))
        (self.here / "ov.txt").write_text("\n".join(rows) + "\n")
        metrics, _ = self.evaluate(self.here / "ov.txt", "--extrinsics", file)
        self.assert_reasons(metrics)

    def test_a_convention_of_the_run_holds_beside_other_options(self):
        """Neighbours of error_convention: before a word of the command line, with an alignment, and packed."""
        run, poses, P = self.drawn()
        expected = {by: self.evaluate(run, "--align", by)[0]["filtered"]["nees"]["pose"]["mean"] for by in ("none", "se3")}
        local = []
        for (q, _), C in zip(poses, P):
            J = np.block([[np.zeros((3, 3)), np.eye(3)], [so3.matrix(q).T, np.zeros((3, 3))]])
            local.append(J @ C @ J.T)
        write_run(run, self.times, poses, np.array(local))
        (run / "run.yaml").write_text("error_convention: rotation-first,right,local\n")
        for words in ([], ["--error-convention", "position-first,left,global"]):
            for by, mean in expected.items():
                found, _ = self.evaluate(run, "--align", by, *words)
                self.assertAlmostEqual(found["filtered"]["nees"]["pose"]["mean"], mean, delta=1e-9 * mean)
        pack(run)
        self.assertAlmostEqual(self.evaluate(run)[0]["filtered"]["nees"]["pose"]["mean"], expected["none"], delta=1e-9)
        self.assertEqual(contents(run).keys(), {pathlib.Path(name) for name in ("run.yaml.gz", "trajectory.tum.gz", "pose_covariance.csv.gz")})


if __name__ == "__main__":
    unittest.main()
