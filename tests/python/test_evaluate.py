"""slammot.evaluate on arrays gives the program's figures (metrics.json), and those of evo, recorded in tests/eval/evo.

usage: test_evaluate.py SLAMMOT
"""
import json
import pathlib
import sys
import unittest

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "eval" / folder) for folder in ("", "evo")]
from fixture import ROOT, WithFolder  # noqa: E402
import slammot  # noqa: E402
import trajectories  # noqa: E402

ROUNDING = 1e-12  # relative


def figure(trajectory, key):
    """By its key in `filtered` of metrics.json."""
    tree = trajectory if key.startswith("nees.") else trajectory["accuracy"]
    for part in key.split("."):
        tree = tree[part]
    return tree


class Evaluate(WithFolder):
    def test_the_figures_of_the_program(self):
        compared = 0
        for estimator, options in (("ekf", {}), ("window", {"window.frames": 3}), ("static_world", {})):
            run = self.folder / estimator
            sequence = slammot.simulate("helix", seed=4, output=run / "sequence", frames=30)
            done = slammot.run(run / "sequence", estimator, run / "run", **options)
            ours = slammot.evaluate(done.trajectory, done.covariance, sequence.truth)
            for key, value in ours.figures.items():
                theirs, compared = figure(done.metrics["filtered"], key), compared + 1
                self.assertLess(abs(value - theirs), ROUNDING * max(abs(theirs), 1e-9), key)
            series = np.array([row[2:] for row in done.metrics["filtered"]["nees"]["series"]])
            frames = ours.frames[["nees_pose", "nees_position", "nees_rotation"]].to_numpy()[1:]
            np.testing.assert_allclose(frames, series, rtol=1e-11)
        self.assertGreaterEqual(compared, 3 * 37)

    def test_the_figures_of_evo(self):
        recorded = json.loads((ROOT / "tests" / "eval" / "evo" / "figures.json").read_text())["figures"]
        trajectories.write(self.folder)
        for name, figures in recorded.items():
            poses, truth = (np.loadtxt(self.folder / name / f"{which}.tum") for which in ("estimate", "truth"))
            words = trajectories.CASES[name][2]
            options = {flag[2:].replace("-", "_"): float(value) for flag, value in zip(words[::2], words[1::2])}
            ours = slammot.evaluate(poses, None, truth, **options).figures
            for key, evos in figures.items():
                with self.subTest(trajectory=name, command=evos["command"]):
                    self.assertLess(abs(ours[key] / evos["rmse"] - 1), 1e-11)

    def test_bad_arrays_are_refused(self):
        truth = np.hstack([np.arange(4.0)[:, None], np.zeros((4, 6)), np.ones((4, 1))])
        for poses, reason in ((truth[:, :7], "n x 8"), (truth[::-1], "do not increase"), (truth + np.eye(1, 8) * 100, "half a frame")):
            with self.assertRaisesRegex(ValueError, reason):
                slammot.evaluate(poses, None, truth)
        self.assertNotIn("nees.pose.mean", slammot.evaluate(truth, np.full((4, 6, 6), np.nan), truth).figures)

    def test_a_single_pose_and_a_late_one(self):
        truth = np.hstack([np.arange(4.0)[:, None], np.zeros((4, 6)), np.ones((4, 1))])
        late = truth[1:2] + [[0.4, 0.3, 0, 0, 0, 0, 0, 0]]
        figures = slammot.evaluate(late, np.eye(6)[None], truth).figures
        self.assertEqual((figures["poses"], figures["coverage"]), (1, 0.25))
        self.assertAlmostEqual(figures["position_rmse_m"], 0.3)
        self.assertTrue(np.isnan(figures["ate_sim3_m"]))


if __name__ == "__main__":
    unittest.main()
