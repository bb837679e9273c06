"""slammot.evaluate(.., align=..): the gauge of a run does not matter, and NEES is what `Alignment` says of independent errors."""
import gzip
import pathlib
import sys
import tempfile
import unittest

import numpy as np
from scipy.spatial.transform import Rotation

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
import slammot  # noqa: E402

PARTS = ("pose", "position", "rotation")
SIGMA = 1e-4  # small: what is expected is to first order


def truth_of(n):
    s = np.linspace(0.0, 5.0, n)
    turn = Rotation.from_rotvec(np.column_stack([0.3 * np.sin(s), s, 0.2 * np.cos(s)]))
    return np.column_stack([s, 3.0 * np.sin(s), np.cos(1.7 * s), 2.0 * np.cos(s), turn.as_quat()])


def covariances_of(n, rng, first=1.0):
    """Full ones, different in every frame; the first times `first`."""
    A = rng.normal(size=(n, 6, 6))
    P = SIGMA**2 * (A @ A.swapaxes(1, 2) + np.eye(6)) * (1.0 + np.arange(n) / n)[:, None, None]
    P[0] *= first
    return P


def with_errors(truth, e):
    turn = Rotation.from_quat(truth[:, 4:]) * Rotation.from_rotvec(-e[:, 3:])
    return np.column_stack([truth[:, 0], truth[:, 1:4] - e[:, :3], turn.as_quat()])


def drawn(truth, P, rng):
    return with_errors(truth, np.einsum("kij,kj->ki", np.linalg.cholesky(P), rng.normal(size=(len(P), 6))))


def in_gauge(poses, P, rng, scaled):
    """Another world, and scale where `scaled`; with the covariances that are stated there."""
    s, Q, t = rng.uniform(0.1, 9.0) if scaled else 1.0, Rotation.random(random_state=int(rng.integers(1 << 30))), rng.normal(size=3) * 50.0
    B = np.eye(6)
    B[:3, :3] = s * Q.as_matrix()
    return np.column_stack([poses[:, 0], s * Q.apply(poses[:, 1:4]) + t, (Q * Rotation.from_quat(poses[:, 4:])).as_quat()]), B @ P @ B.T


def ensemble(by, n, runs, rng, first=1.0):
    """Mean NEES of each of many runs that state the covariances of which they are drawn; the last run's Alignment."""
    truth, P, means = truth_of(n), covariances_of(n, rng, first), []
    for _ in range(runs):
        judged = slammot.evaluate(*in_gauge(drawn(truth, P, rng), P, rng, by == "sim3"), truth, align=by)
        means.append([judged.figures[f"nees.{part}.mean"] for part in PARTS])
    return np.array(means), judged.alignment


class Alignment(unittest.TestCase):
    def test_the_gauge_of_a_run_does_not_matter(self):
        rng = np.random.default_rng(1)
        truth, P = truth_of(30), covariances_of(30, rng)
        poses = drawn(truth, P, rng)
        for by in ("first", "se3", "sim3"):
            expected = slammot.evaluate(poses, P, truth, align=by).figures
            for _ in range(5):
                moved, stated = in_gauge(poses, P, rng, by == "sim3")
                found = slammot.evaluate(moved, stated, truth, align=by).figures
                self.assertEqual(set(found), set(expected))
                for key in set(found) - {"sim3_scale"}:
                    tolerance = 1e-6 if by == "sim3" or not key.startswith("ate_sim3") else 1e-5
                    self.assertAlmostEqual(found[key], expected[key], delta=tolerance * max(1.0, abs(expected[key])), msg=f"{by} {key}")
                # Taken where it stands, or with the covariance of elsewhere, it is something else.
                self.assertGreater(slammot.evaluate(moved, stated, truth).figures["position_rmse_m"], 1.0)
                other = slammot.evaluate(moved, P, truth, align=by).figures["nees.position.mean"]
                self.assertGreater(abs(other / expected["nees.position.mean"] - 1.0), 0.01)

    def test_none_is_the_default_and_a_fit_is_that_of_the_ate(self):
        rng = np.random.default_rng(2)
        truth, P = truth_of(30), covariances_of(30, rng)
        poses, stated = in_gauge(drawn(truth, P, rng), P, rng, True)
        plain = slammot.evaluate(poses, stated, truth)
        self.assertIsNone(plain.alignment)
        self.assertEqual(slammot.evaluate(poses, stated, truth, align="none").figures, plain.figures)
        for by in ("se3", "sim3"):
            self.assertAlmostEqual(slammot.evaluate(poses, None, truth, align=by).figures["position_rmse_m"], plain.figures[f"ate_{by}_m"], places=12)
        first = slammot.evaluate(poses, None, truth, align="first")
        self.assertLess(first.frames["position_error_m"][0] + first.frames["rotation_error_deg"][0], 1e-10)
        scale = slammot.evaluate(poses, stated, truth, align="sim3").alignment.similarity.scale
        self.assertAlmostEqual(scale, plain.figures["sim3_scale"], places=12)

    def test_nees_of_independent_errors_is_what_is_expected_after_each_alignment(self):
        runs = 150
        for by, n in (("se3", 6), ("se3", 20), ("sim3", 6), ("first", 6)):
            means, alignment = ensemble(by, n, runs, np.random.default_rng([3, n, len(by)]))
            half = 3.3 * means.std(0, ddof=1) / np.sqrt(runs)  # three parts: 99.7% for all of a case
            for part, mean, interval in zip(PARTS, means.mean(0), half):
                self.assertAlmostEqual(mean, alignment.expected[part], delta=interval, msg=f"{by} {n} {part}")
            self.assertFalse(alignment.verdict)
            self.assertEqual(alignment.left, 6 * n - alignment.fitted)
            if n == 6:  # the test can tell: without the alignment's part it would be 3
                self.assertGreater(abs(means.mean(0)[1] - 3.0), 2.0 * half[1])

    def test_positions_of_equal_spheres_lose_the_degrees_of_freedom_of_the_fit(self):
        """3 n - 6 or 7 of 3 n: the law of linear least squares."""
        n = 7
        P = np.tile(SIGMA**2 * np.eye(6), (n, 1, 1))
        for by, fitted in (("se3", 6), ("sim3", 7)):
            orders = ([k, *range(k), *range(k + 1, n)] for k in range(n))  # each pose is once the first, which is left out
            total = sum(slammot.expected_nees(truth_of(n)[order], P, by)["position"] for order in orders)
            self.assertAlmostEqual(total, 3 * n - fitted, places=9)

    def test_what_all_poses_share_is_taken_away(self):
        """Hence no verdict: this estimator states what it errs, but its errors are of its frame."""
        rng = np.random.default_rng(4)
        truth, P = truth_of(30), covariances_of(30, rng)
        shared = in_gauge(truth, P, rng, False)[0]
        judged = slammot.evaluate(shared, P, truth, align="se3")
        self.assertLess(judged.figures["nees.pose.mean"], 1e-6)
        self.assertFalse(judged.alignment.verdict)

    def test_a_first_pose_that_is_held_leaves_nees_as_it_is(self):
        means, alignment = ensemble("first", 8, 200, np.random.default_rng(5), first=1e-8)
        half = 3.3 * means.std(0, ddof=1) / np.sqrt(200)
        for mean, dof, interval in zip(means.mean(0), (6, 3, 3), half):
            self.assertAlmostEqual(mean, dof, delta=interval)
        self.assertTrue(alignment.verdict)
        self.assertAlmostEqual(alignment.expected["pose"], 6.0, places=4)

    def test_what_is_not_known_stays_unknown_and_spoils_nothing(self):
        rng = np.random.default_rng(6)
        truth, P = truth_of(20), covariances_of(20, rng)
        poses, stated = in_gauge(drawn(truth, P, rng), P, rng, True)
        whole = slammot.evaluate(poses, stated, truth, align="sim3").figures
        stated[:, :3, 3:] = stated[:, 3:, :3] = np.nan  # as ov_eval
        judged = slammot.evaluate(poses, stated, truth, align="sim3").figures
        self.assertNotIn("nees.pose.mean", judged)
        for part in ("position", "rotation"):
            self.assertEqual(judged[f"nees.{part}.mean"], whole[f"nees.{part}.mean"])

    def test_what_shows_no_rotation_is_refused(self):
        truth = truth_of(9)
        line = np.column_stack([truth[:, 0], np.outer(truth[:, 0], [1.0, 2.0, 3.0]), truth[:, 4:]])
        for poses, true in ((line, truth), (truth, line), (truth[:2], truth[:2]), (truth * [1, 0, 0, 0, 1, 1, 1, 1], truth)):
            for by in ("se3", "sim3"):
                with self.assertRaisesRegex(ValueError, "no rotation is seen"):
                    slammot.evaluate(poses, None, true, align=by)
            slammot.evaluate(poses, None, true, align="first")
        with self.assertRaisesRegex(ValueError, "align is none, first, se3, sim3, not 'yaw'"):
            slammot.evaluate(truth, None, truth, align="yaw")


class Packed(unittest.TestCase):
    def test_packed_files_are_read_as_plain_ones(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            np.savetxt(folder / "trajectory.tum", truth_of(5))
            (folder / "run.yaml").write_text("estimator: mine\n")
            plain = slammot.read_run(folder)
            for file in list(folder.iterdir()):
                pathlib.Path(f"{file}.gz").write_bytes(gzip.compress(file.read_bytes()))
                file.unlink()
            packed = slammot.read_run(folder)
            self.assertTrue(packed.trajectory.equals(plain.trajectory))
            self.assertEqual(packed.description, {"estimator": "mine"})
            file = folder / "trajectory.tum.gz"
            file.write_bytes(file.read_bytes()[:-9])
            with self.assertRaisesRegex(ValueError, r"trajectory\.tum\.gz: "):
                slammot.read_run(folder)


if __name__ == "__main__":
    unittest.main()
