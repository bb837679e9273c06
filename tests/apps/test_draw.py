"""slammot draw: a film, and figures fit for a paper, of a run over rendered images.

usage: test_draw.py SLAMMOT
"""
import json
import os
import pathlib
import re
import shutil
import sys
import unittest
import zlib

from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "eval"))
from fixture import WithFolder, program  # noqa: E402


def streams(pdf):
    """What the streams of a PDF hold, those that are compressed as others."""
    for raw in re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.DOTALL):
        try:
            yield zlib.decompress(raw)
        except zlib.error:
            yield raw


class Draw(WithFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        program("simulate", "--render", "--seed", "3", "--set", "frames=14", "--output", cls.folder / "room")
        # One thread: ThreadSanitizer does not see that OpenCV's threads wait for each other (tsan.supp).
        program("track", cls.folder / "room", "--threads", "1", "--output", cls.folder / "tracked")
        cls.run_folder = cls.folder / "run"
        program("run", cls.folder / "tracked", "--estimator", "ekf", "--landmarks", "every-frame", "--output", cls.run_folder)
        cls.drawn = program("draw", cls.run_folder, "--pdf", "6,9", "--output", cls.folder / "figures").stdout.split()

    def test_a_figure_is_vectors_with_its_fonts(self):
        files = [pathlib.Path(line) for line in self.drawn]
        self.assertEqual([file.name for file in files], ["frame_000006.pdf", "frame_000009.pdf"])
        pdf = files[1].read_bytes()
        self.assertTrue(pdf.startswith(b"%PDF"))
        self.assertEqual(len(re.findall(rb"/Subtype /Image", pdf)), 1)  # the camera's
        self.assertIn(b"/FontFile2", pdf)  # embedded TrueType
        self.assertNotIn(b"/Type3", pdf)
        frame = json.loads(files[1].with_suffix(".json").read_text())
        curves = max(len(re.findall(rb" c\n", stream)) for stream in streams(pdf))
        drawn = [p for p in frame["predictions"] if p["S"][0][0] < 100.0]
        self.assertGreater(len(drawn), 20)
        self.assertGreaterEqual(curves, 4 * len(drawn))  # an ellipse is four curves or more
        self.assertFalse((self.folder / "figures" / "film.mp4").exists())

    def test_the_data_of_a_figure_are_those_of_the_run(self):
        frame = json.loads((self.folder / "figures" / "frame_000009.json").read_text())
        rows = [line.split(",") for line in (self.run_folder / "predictions.csv").read_text().splitlines() if line[0] == "9"]
        self.assertEqual([p["track"] for p in frame["predictions"]], [int(row[1]) for row in rows])
        for p, row in zip(frame["predictions"], rows):
            self.assertEqual(p["pixel"], [float(row[2]), float(row[3])])
            self.assertEqual(p["S"], [[float(row[4]), float(row[5])], [float(row[5]), float(row[6])]])
            self.assertEqual(p["measured"], row[7])
        self.assertEqual(len(frame["path"]), 10)

    def test_the_predictions_have_the_nis_that_the_run_states(self):
        def rows(file):
            return [line.split(",") for line in file.read_text().splitlines() if line[0].isdigit()]

        observations = rows(self.folder / "tracked" / "observations.csv")
        measured = {(frame, track): (float(u), float(v)) for frame, track, u, v in observations}
        nis = []
        for frame, track, *numbers, how in rows(self.run_folder / "predictions.csv"):
            self.assertEqual(how != "-", (frame, track) in measured)
            if how == "accepted":
                u, v, s_uu, s_uv, s_vv = map(float, numbers)
                x, y = measured[frame, track][0] - u, measured[frame, track][1] - v
                nis.append((s_vv * x * x - 2 * s_uv * x * y + s_uu * y * y) / (s_uu * s_vv - s_uv * s_uv))
        stated = json.loads((self.run_folder / "metrics.json").read_text())
        self.assertEqual(len(nis), stated["coverage"]["accepted"])
        self.assertAlmostEqual(sum(nis) / len(nis), stated["nis"]["mean"], places=9)

    def test_the_same_bytes_again(self):
        program("draw", self.run_folder, "--pdf", "9", "--output", self.folder / "again")
        again, before = ((self.folder / name / "frame_000009.pdf").read_bytes() for name in ("again", "figures"))
        self.assertEqual(again, before)

    def test_what_is_not_there_is_told(self):
        """A frame, an image, a Python with packages."""
        self.assertIn("the run has no frame 99", program("draw", self.run_folder, "--pdf", "99", code=2).stderr)
        self.assertFalse((self.run_folder / "pictures").exists())
        tracked, output = shutil.copytree(self.folder / "tracked", self.folder / "gone"), self.folder / "untold"
        frames = tracked / "frames.csv"
        frames.write_text(frames.read_text().replace("000009.png", "nowhere.png"))
        done = program("draw", self.run_folder, "--sequence", tracked, "--pdf", "9", "--output", output, code=2)
        self.assertIn("nowhere.png: no such file", done.stderr)
        self.assertFalse(output.exists())
        program("draw", self.run_folder, "--pdf", "9", "--output", output, code=1, env=os.environ | {"SLAMMOT_PYTHON": "/bin/false"})
        self.assertFalse((output / "frame_000009.pdf").exists())

    def test_both_images_of_two_cameras(self):
        """Of each its own predictions; a second image that cannot be used is said, and its tracks are drawn without it."""
        tracked, run = self.folder / "pair", self.folder / "run pair"
        program("simulate", "--render", "--seed", "3", "--set", "frames=6", "--set", "stereo=0.1", "--output", self.folder / "rig")
        program("track", self.folder / "rig", "--threads", "1", "--output", tracked)
        program("run", tracked, "--estimator", "ekf", "--landmarks", "every-frame", "--output", run)
        program("draw", run, "--pdf", "5")
        figure = run / "pictures" / "frame_000005"
        self.assertEqual(len(re.findall(rb"/Subtype /Image", figure.with_suffix(".pdf").read_bytes())), 2)
        other, = json.loads(figure.with_suffix(".json").read_text())["other_cameras"]
        places = {z["track"]: z["pixel"] for z in other["measurements"]}
        near = [abs(p["pixel"][0] - places[p["track"]][0]) < 3.0 for p in other["predictions"]]
        self.assertGreater(sum(near), 20)
        self.assertGreater(sum(near), 0.9 * len(near))
        self.assertEqual(program("draw", run).stderr, "")
        with Image.open(run / "pictures" / "frames" / "000005.png") as picture:
            self.assertEqual(picture.width, 2 * 2 * 320)
        (self.folder / "rig" / "images_1" / "000004.png").unlink()
        self.assertRegex(program("draw", run).stderr,
                         r"\Aslammot: warning: 1 images of other cameras cannot be used; the first: .*images_1/000004.png: no such file\n\Z")

    def test_a_run_of_an_earlier_build_has_no_ellipses(self):
        run = shutil.copytree(self.run_folder, self.folder / "earlier")
        (run / "predictions.csv").unlink()
        done = program("draw", run, "--pdf", "9")
        self.assertIn("no ellipses", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertEqual(json.loads((run / "pictures" / "frame_000009.json").read_text())["predictions"], [])
        self.assertIn("14 pictures", program("draw", run).stdout)
        self.assertTrue((run / "pictures" / "frame_000009.pdf").exists())


if __name__ == "__main__":
    unittest.main()
