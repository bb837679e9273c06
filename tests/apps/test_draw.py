"""slammot draw: a film, and figures fit for a paper, of a run over rendered images.

usage: test_draw.py SLAMMOT
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zlib

SLAMMOT = sys.argv.pop(1)


def slammot(*arguments, code=0, **environment):
    done = subprocess.run([SLAMMOT, *arguments], capture_output=True, text=True, check=False, timeout=300,
                          env=os.environ | environment)
    if done.returncode != code:
        raise AssertionError(f"{arguments}: exit {done.returncode}: {done.stderr}")
    return done


def streams(pdf):
    """What the streams of a PDF hold, those that are compressed as others."""
    for raw in re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.DOTALL):
        try:
            yield zlib.decompress(raw)
        except zlib.error:
            yield raw


class Draw(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        slammot("simulate", "--render", "--seed", "3", "--set", "frames=14", "--output", cls.folder / "room")
        # One thread: ThreadSanitizer does not see that OpenCV's threads wait for each other (tsan.supp).
        slammot("track", cls.folder / "room", "--threads", "1", "--output", cls.folder / "tracked")
        cls.run_folder = cls.folder / "run"
        cls.run_estimator(cls.run_folder)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def run_estimator(cls, output, *more):
        slammot("run", cls.folder / "tracked", "--estimator", "ekf", "--landmarks", "every-frame", "--output", output, *more)

    def copy(self):
        copy = self.folder / self.id().rsplit(".", 1)[1]
        shutil.copytree(self.run_folder, copy)
        return copy

    def test_a_figure_is_vectors_with_its_fonts(self):
        done = slammot("draw", self.run_folder, "--pdf", "6,9", "--output", self.folder / "figures")
        files = [pathlib.Path(line) for line in done.stdout.split()]
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
        slammot("draw", self.run_folder, "--pdf", "9", "--output", self.folder / "data")
        frame = json.loads((self.folder / "data" / "frame_000009.json").read_text())
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
        pdfs = []
        for name in ("one", "two"):
            slammot("draw", self.run_folder, "--pdf", "9", "--output", self.folder / name)
            pdfs.append((self.folder / name / "frame_000009.pdf").read_bytes())
        self.assertEqual(*pdfs)

    def test_what_is_not_there_is_refused(self):
        done = slammot("draw", self.run_folder, "--pdf", "99", code=2)
        self.assertIn("the run has no frame 99", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertFalse((self.run_folder / "pictures").exists())
        run = self.copy()
        text = (run / "predictions.csv").read_text().splitlines(keepends=True)
        (run / "predictions.csv").write_text("".join(text[:7]) + "1,2,3\n")
        self.assertIn("predictions.csv:8: expected 8 fields, found 3", slammot("draw", run, code=2).stderr)

    def test_an_image_that_is_gone_and_a_python_without_packages_are_told(self):
        tracked = self.folder / "gone"
        shutil.copytree(self.folder / "tracked", tracked)
        frames = tracked / "frames.csv"
        frames.write_text(frames.read_text().replace("000009.png", "nowhere.png"))
        output = self.folder / "untold"
        done = slammot("draw", self.run_folder, "--sequence", tracked, "--pdf", "9", "--output", output, code=2)
        self.assertIn("nowhere.png: no such file", done.stderr)
        self.assertFalse(output.exists())
        slammot("draw", self.run_folder, "--pdf", "9", "--output", output, code=1, SLAMMOT_PYTHON="/bin/false")
        self.assertFalse((output / "frame_000009.pdf").exists())

    def test_a_run_of_an_earlier_build_has_no_ellipses(self):
        run = self.copy()
        (run / "predictions.csv").unlink()
        done = slammot("draw", run, "--pdf", "9")
        self.assertIn("no ellipses", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertEqual(json.loads((run / "pictures" / "frame_000009.json").read_text())["predictions"], [])
        self.assertIn("14 pictures", slammot("draw", run).stdout)
        self.assertTrue((run / "pictures" / "frame_000009.pdf").exists())

    def test_predictions_are_replaced_with_the_run(self):
        run = self.copy()
        slammot("run", self.folder / "tracked", "--estimator", "ekf", "--output", run, "--force")
        self.assertFalse((run / "predictions.csv").exists())


if __name__ == "__main__":
    unittest.main()
