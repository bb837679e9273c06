"""The package slammot: what the program wrote comes back as the same numbers.

usage: test_package.py SLAMMOT
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "eval"))
from fixture import ROOT, WithFolder, program  # noqa: E402
import slammot  # noqa: E402
from slammot import so3  # noqa: E402

STUDY = """\
format: slammot-study-1
name: small
runs: 2
scenarios: [{scenario: helix, set: {frames: 12}}, {scenario: helix, label: 'a "quoted" one', set: {frames: 14}}]
estimators: [{estimator: ekf}, {estimator: batch, set: {window.frames: 3}}]
sweep: {classifier.static_threshold: [0.8, 1.6], labels: [one_way]}
"""


class Package(WithFolder):
    def test_simulate_gives_the_numbers_of_the_files_and_the_frames_that_an_estimator_is_given(self):
        sequence = slammot.simulate("circle", seed=3, output=self.folder / "circle", frames=15, noise=0.5)
        again = slammot.simulate("circle", seed=3, frames=15, noise=0.5)
        self.assertTrue(sequence.observations.equals(again.observations))
        with (self.folder / "circle" / "observations.csv").open(encoding="utf-8") as file:
            rows = [(int(r["frame"]), int(r["track"]), float(r["u"]), float(r["v"])) for r in csv.DictReader(file)]
        self.assertEqual(sorted(rows), list(sequence.observations.itertuples(index=False, name=None)))
        self.assertEqual((len(sequence.frames), len(sequence.truth), sequence.pixel_sigma), (15, 15, 0.5))
        self.assertFalse(sequence.observations.equals(slammot.simulate("circle", seed=4, frames=15).observations))
        frames = list(sequence)
        self.assertEqual([frame.index for frame in frames], list(range(15)))
        self.assertEqual(sum(len(frame.tracks) for frame in frames), len(sequence.observations))
        self.assertTrue(all((np.diff(frame.tracks) > 0).all() for frame in frames))

    def test_a_rig_has_its_cameras_views_and_depths(self):
        alone = slammot.simulate("circle", seed=3, frames=8)
        rig = slammot.simulate("circle", seed=3, frames=8, stereo=0.2, depth_sigma=0.1)
        self.assertEqual([list(camera.position) for camera in rig.other_cameras], [[0.2, 0.0, 0.0]])
        for frame, same in zip(rig, alone):
            self.assertTrue((frame.pixels == same.pixels).all())
            views = frame.other_views
            self.assertTrue((views.cameras == 1).all() and set(views.tracks) <= set(frame.tracks))
            left = dict(zip(frame.tracks, frame.pixels[:, 0]))
            self.assertTrue(all(left[track] + 10.0 > u for track, (u, _) in zip(views.tracks, views.pixels)))
        self.assertTrue((next(iter(rig)).depths > 0.0).all())
        self.assertEqual(len(alone.other_cameras) + len(next(iter(alone)).other_views.tracks), 0)

    def test_the_name_of_an_image_runs_to_the_end_of_its_line(self):
        folder = slammot.simulate("circle", seed=3, output=self.folder / "named", frames=2).folder
        (folder / "frames.csv").write_text("frame,timestamp,image\n0,0.5,a, \"b\".png\n1,0.6,c.png\n", encoding="utf-8")
        frames = slammot.read_sequence(folder).frames
        self.assertEqual(list(frames["image"]), ['a, "b".png', "c.png"])
        self.assertEqual(list(frames["timestamp"]), [0.5, 0.6])

    def test_truth_projects_to_the_measurements(self):
        sequence = slammot.simulate("helix", seed=1, frames=10)
        known = sequence.known.set_index("track")
        errors = []
        for row in sequence.observations.itertuples():
            if row.track in known.index:
                pose = sequence.truth.iloc[row.frame]
                R = so3.matrix(pose[["qx", "qy", "qz", "qw"]].to_numpy())
                ray = R.T @ (known.loc[row.track, ["x", "y", "z"]] - pose[["x", "y", "z"]].to_numpy()).to_numpy()
                errors.append(sequence.camera.matrix[:2] @ ray / ray[2] - [row.u, row.v])
        self.assertGreater(len(errors), 100)
        self.assertAlmostEqual(np.std(errors) / sequence.pixel_sigma, 1.0, delta=0.15)

    def test_run_folder(self):
        sequence = slammot.simulate("helix", seed=2, output=self.folder / "helix", frames=20)
        run = slammot.run(sequence.folder, "window", self.folder / "run", **{"window.frames": 5})
        self.assertEqual(run.description["estimator"], "window")
        self.assertEqual(run.description["configuration"]["window.frames"], 5)
        self.assertEqual(run.covariance.shape, (20, 6, 6))
        self.assertEqual(run.smoothed_covariance.shape, (20, 6, 6))
        self.assertIsNone(run.last_scale)
        unknown = slammot.simulate("helix", seed=2, output=self.folder / "unknown", frames=20, known=0)
        shape = slammot.run(unknown.folder, "ekf", self.folder / "shape")
        self.assertTrue((shape.last_scale.iloc[-1] == shape.trajectory.iloc[-1]).all())
        self.assertEqual(set(shape.metrics["last_scale"]), set(shape.metrics["filtered"]) | {"nees_reason"})
        self.assertTrue((run.covariance == run.covariance.transpose(0, 2, 1)).all())
        self.assertEqual(set(run.timing["frame"]), set(range(20)))
        self.assertLessEqual(set(run.classification["truth"]), {"static", "moving", "-"})
        error = (run.trajectory - sequence.truth)[["x", "y", "z"]].to_numpy()
        self.assertAlmostEqual(np.sqrt((error ** 2).sum(axis=1).mean()),
                               run.metrics["filtered"]["accuracy"]["position_rmse_m"], delta=1e-14)

    def test_an_earlier_output_is_replaced_by_force_alone(self):
        out = self.folder / "twice"
        first = slammot.simulate("helix", seed=1, output=out, frames=5)
        with self.assertRaisesRegex(RuntimeError, "holds a sequence already"):
            slammot.simulate("helix", seed=2, output=out, frames=5)
        self.assertTrue(first.observations.equals(slammot.read_sequence(out).observations))
        second = slammot.simulate("helix", seed=2, output=out, force=True, frames=5)
        self.assertFalse(first.observations.equals(second.observations))
        slammot.run(out, "ekf", self.folder / "run twice")
        with self.assertRaisesRegex(RuntimeError, "holds a run already"):
            slammot.run(out, "ekf", self.folder / "run twice")
        slammot.run(out, "ekf", self.folder / "run twice", force=True)

    def test_a_trajectory_alone_is_a_run(self):
        folder = self.folder / "foreign"
        folder.mkdir()
        (folder / "trajectory.tum").write_text("# mine\n0 1 2 3 0 0 0 1\n0.1 1 2 4 0 0 0 1\n", encoding="utf-8")
        run = slammot.read_run(folder)
        self.assertEqual(list(run.trajectory["z"]), [3, 4])
        self.assertIsNone(run.covariance)

    def test_study_is_a_tidy_table_of_numbers(self):
        (self.folder / "small.yaml").write_text(STUDY, encoding="utf-8")
        out = self.folder / "study"
        program("study", self.folder / "small.yaml", "--output", out, "--jobs", 1)
        runs = slammot.read_study(out)
        results = [json.loads(line) for line in (out / "results.jsonl").read_text(encoding="utf-8").splitlines()]
        timing = [json.loads(line) for line in (out / "timing.jsonl").read_text(encoding="utf-8").splitlines()]
        self.assertEqual(len(runs), 16)
        self.assertEqual(list(runs["seed"]), [result["seed"] for result in results])
        self.assertEqual(list(runs["label"].unique()), ["ekf", "batch"])
        self.assertEqual(sorted(runs["classifier.static_threshold"].unique()), [0.8, 1.6])
        self.assertEqual(set(runs["labels"]), {"one_way"})
        self.assertIn('a "quoted" one, classifier.static_threshold = 0.8, labels = one_way', set(runs["group"]))
        for (_, row), result, time in zip(runs.iterrows(), results, timing):
            self.assertEqual(row["filtered_position_rmse_m"], result["filtered"]["position_rmse_m"])
            self.assertAlmostEqual(row["filtered_nees_pose"], np.mean(result["frames"]["nees_pose"]), delta=1e-12)
            self.assertEqual([row["moving_right"], row["moving_wrong"], row["moving_undecided"]], result["moving"])
            self.assertEqual(row["seconds"], time["seconds"])
            self.assertEqual(row["label"] == "batch", row.notna()["smoothed_position_rmse_m"])
        numbers = runs.drop(columns=["scenario", "group", "estimator", "label", "labels"])
        self.assertTrue(all(dtype.kind in "ifb" for dtype in numbers.dtypes), numbers.dtypes)

    def test_what_is_missing_or_bad_is_said_with_its_file(self):
        with self.assertRaisesRegex(FileNotFoundError, "trajectory.tum"):
            slammot.read_run(self.folder)
        (self.folder / ".slammot-replacing").touch()
        with self.assertRaisesRegex(ValueError, "being replaced"):
            slammot.read_run(self.folder)
        (self.folder / ".slammot-replacing").unlink()
        with self.assertRaisesRegex(FileNotFoundError, "runs.csv"):
            slammot.read_study(self.folder)
        with self.assertRaisesRegex(RuntimeError, "^slammot: unknown scenario 'square circle'"):
            slammot.simulate("square circle")

    def test_rotations(self):
        theta, d = np.array([0.3, -1.2, 0.4]), np.array([1e-6, -2e-6, 3e-6])
        q = so3.exp(theta)
        np.testing.assert_allclose(so3.log(q), theta, atol=1e-14)
        np.testing.assert_allclose(so3.log(-q), theta, atol=1e-14)
        R = so3.matrix(q)
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
        np.testing.assert_allclose(so3.matrix(so3.multiply(q, so3.exp(d))), R @ so3.matrix(so3.exp(d)), atol=1e-14)
        moved = so3.log(so3.multiply(so3.conjugate(q), so3.exp(theta + d)))
        np.testing.assert_allclose(moved, so3.right_jacobian(theta) @ d, atol=1e-11)
        np.testing.assert_allclose(so3.log(so3.exp(d)), d, atol=1e-20)

    def test_the_notebook_runs(self):
        done = subprocess.run([sys.executable, "-B", ROOT / "examples/python/notebook.py", self.folder / "notebook"],
                              capture_output=True, text=True, check=False,
                              env=os.environ | {"PYTHONPATH": str(ROOT / "python")})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"(?s)helix-1: 80 frames.*ekf: position RMSE.*mine: position RMSE.*scenario.noise")


if __name__ == "__main__":
    unittest.main()
