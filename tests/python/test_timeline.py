"""The timeline page, of a made-up run over made-up images: it holds every frame and the labels of the run's files, and is drawn in headless
Chromium without the network."""
import base64
import contextlib
import csv
import io
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
from slammot.report import page, timeline  # noqa: E402

FRAMES, TRACKS, RATE = 30, 12, 10.0
WIDTH, HEIGHT = 800, 500
UPPER = [f"{i}{j}" for i in range(1, 4) for j in range(i, 4)]


def label_of(frame, track):
    """A third each; what moves and what is unknown is so from a frame of its own on; one track is no landmark for a while."""
    if track == 11 and frame < 9:
        return None
    return "unknown" if frame < track else ("static", "moving", "unknown")[track % 3]


def pixel_of(frame, track):
    return 60.0 * track + 2.5 * frame, 250.0 + 150.0 * math.sin(track + 0.1 * frame)


def pose_of(frame):
    turn = 0.02 * frame
    return f"{frame / RATE} {0.1 * frame} 0 {0.05 * frame} 0 {math.sin(turn / 2)} 0 {math.cos(turn / 2)}\n"


def write_sequence(folder, frames=FRAMES):
    (folder / "images").mkdir(parents=True)
    (folder / "sequence.yaml").write_text(f"""format: slammot-sequence-1
name: made-up
camera: {{model: pinhole, width: {WIDTH}, height: {HEIGHT}, fx: 400, fy: 400, cx: 399.5, cy: 249.5}}
pixel_sigma: 1
""")
    names = [f"images/{k:06}.png" for k in range(frames)]
    for k, name in enumerate(names):
        Image.fromarray(numpy.full((HEIGHT, WIDTH), k % 250, numpy.uint8)).save(folder / name)
    (folder / "frames.csv").write_text("frame,timestamp,image\n" + "".join(f"{k},{k / RATE},{name}\n" for k, name in enumerate(names)))
    rows = [(k, track, *pixel_of(k, track)) for k in range(frames) for track in range(TRACKS)]
    (folder / "observations.csv").write_text("frame,track,u,v\n" + "".join("{},{},{:.2f},{:.2f}\n".format(*row) for row in rows))
    (folder / "groundtruth.tum").write_text("".join(map(pose_of, range(frames))))
    return folder


def write_rig(folder):
    """A second camera, which sees every other track 20 pixels further left, and has no image of frame 1."""
    write_sequence(folder)
    settings, head, rows = folder / "sequence.yaml", *(folder / "observations.csv").read_text().split("\n", 1)
    camera = re.search("camera: (.*)}", settings.read_text())[1]
    settings.write_text(re.sub("camera: .*}", f"cameras:\n  - {camera}}}\n  - {camera}, T_C0_C: {{position: [0.1, 0, 0], quaternion: [0, 0, 0, 1]}}}}", settings.read_text()))
    seen = [(k, track, *pixel_of(k, track)) for k in range(FRAMES) for track in range(0, TRACKS, 2)]
    (folder / "observations.csv").write_text(f"{head},camera\n" + rows.replace("\n", ",0\n") + "".join(f"{k},{track},{u - 20},{v},1\n" for k, track, u, v in seen))
    shutil.copytree(folder / "images", folder / "right")
    (folder / "other_images.csv").write_text("frame,camera,image\n" + "".join(f"{k},1,right/{k:06}.png\n" for k in range(FRAMES) if k != 1))
    return folder


def write_run(folder, sequence, frames=FRAMES, every_frame=True):
    folder.mkdir()
    (folder / "run.yaml").write_text(f"format: slammot-run-1\nestimator: ekf\nsequence: {{name: made-up, path: {sequence}}}\n")
    (folder / "trajectory.tum").write_text("".join(map(pose_of, range(frames))))
    head = ",".join(["track,frame,label,x,y,z,vx,vy,vz", *(f"p{ij}" for ij in UPPER), *(f"v{ij}" for ij in UPPER)])
    rows = [f"{track},{k},{label_of(k, track)},{track - 5},0.5,{4 + track % 4},0.3,0,0" + ",0.1" * 12
            for track in range(TRACKS) for k in (range(frames) if every_frame else [frames - 1]) if label_of(k, track)]
    (folder / "landmarks.csv").write_text("\n".join([f"# [m]\n{head}", *rows]) + "\n")
    decided = [f"{track},-,{label_of(frames - 1, track)},{track if track % 3 < 2 else ''},{frames}" for track in range(TRACKS)]
    (folder / "classification.csv").write_text("\n".join(["track,truth,label,frame,observations", *decided]) + "\n")
    series = [[k, k / RATE, None if k == 0 else 5.0 + k, 1.0, 1.0] for k in range(frames)]
    (folder / "metrics.json").write_text(json.dumps({"filtered": {"nees": {"series": series}}}))
    return folder


def make(run, *more):
    """The generator's exit code and what it said."""
    said = io.StringIO()
    with mock.patch.object(sys, "argv", ["timeline", str(run), *map(str, more)]), contextlib.redirect_stderr(said):
        return timeline.main(), said.getvalue()


class Timeline(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.sequence = write_sequence(cls.folder / "sequence")
        cls.run_folder = write_run(cls.folder / "run", cls.sequence)

    def data(self, run=None, said=""):
        run = run or self.run_folder
        self.assertEqual(make(run), (0, said))
        self.text = (run / "timeline.html").read_text(encoding="utf-8")
        return json.loads(re.search(r'id="timeline-data">(.*?)</script>', self.text, re.DOTALL)[1])

    def test_it_holds_every_frame_with_its_picture(self):
        data = self.data()
        self.assertEqual([frame["frame"] for frame in data["frames"]], list(range(FRAMES)))
        self.assertEqual(len(data["pictures"]), FRAMES)
        for k in (0, 17):
            shown = Image.open(io.BytesIO(base64.b64decode(data["pictures"][k].partition(",")[2])))
            self.assertEqual((shown.size, shown.format), ((640, 400), "JPEG"))
            self.assertAlmostEqual(shown.getpixel((300, 200)), k, delta=2)
        self.assertIn(f"All {FRAMES} frames are shown", self.text)

    def test_no_address_of_a_network(self):
        self.data()
        self.assertNotRegex(re.sub(r"data:image/jpeg;base64,[\w+/=]*", "", self.text), r"https?://|//cdn|@import|\bfetch\(")

    def test_labels_and_places_are_those_of_the_files(self):
        with (self.run_folder / "landmarks.csv").open(encoding="utf-8") as lines:
            stated = {(int(row["frame"]), int(row["track"])): row["label"] for row in csv.DictReader(line for line in lines if line[0] != "#")}
        for k, frame in enumerate(self.data()["frames"]):
            self.assertEqual(len(frame["tracks"]), TRACKS)
            for track, u, v, label in frame["tracks"]:
                self.assertEqual([*timeline.LABELS, None][label], stated.get((k, track)))
                self.assertAlmostEqual(u, pixel_of(k, track)[0], delta=0.06)
                self.assertAlmostEqual(v, pixel_of(k, track)[1], delta=0.06)
            self.assertEqual(len(frame["landmarks"]), sum((k, track) in stated for track in range(TRACKS)))
            self.assertTrue(all(len(landmark) == (6 if landmark[0] == 2 else 4) for landmark in frame["landmarks"]))

    def test_the_series_are_those_of_the_judge(self):
        nees, error, _, counts = self.data()["series"]
        self.assertEqual(nees["lines"][0][:3], [None, 6.0, 7.0])
        self.assertLess(max(error["lines"][0]), 1e-9)  # the truth is the estimate; measured, so aligned
        self.assertIn("Sim(3)", error["name"])
        self.assertEqual([line[FRAMES - 1] for line in counts["lines"]], [4, 4, 4])

    def test_with_final_landmarks_labels_are_those_of_the_decision(self):
        run = write_run(self.folder / "final", self.sequence, every_frame=False)
        data = self.data(run)
        for frame in data["frames"]:
            for track, *_, label in frame["tracks"]:
                self.assertEqual(timeline.LABELS[label], label_of(frame["frame"], track) or "unknown")
        self.assertEqual(len(data["landmarks"]), TRACKS)
        self.assertIn("classification.csv", self.text)

    def test_of_many_frames_every_kth_is_shown(self):
        with mock.patch.object(timeline, "MOST_IMAGES", 8):
            data = self.data()
        self.assertEqual([frame["frame"] for frame in data["frames"]], list(range(0, FRAMES, 4)))
        self.assertEqual(len(data["pictures"]), 8)
        self.assertEqual(len(data["series"][0]["lines"][0]), FRAMES)
        self.assertIn(f"Every 4th of {FRAMES} frames", self.text)

    def test_without_images_tracks_are_drawn_on_a_plain_canvas(self):
        sequence = shutil.copytree(self.sequence, self.folder / "moved")
        run = write_run(self.folder / "plain", sequence)
        shutil.rmtree(sequence / "images")
        said = f"timeline: warning: The images are not where the sequence names them, as {sequence}/images/000000.png.\n"
        self.assertIsNone(self.data(run, said)["pictures"])
        frames = sequence / "frames.csv"
        frames.write_text(re.sub(",[^,]*$", "", frames.read_text(), flags=re.MULTILINE))
        self.assertIsNone(self.data(run)["pictures"])
        self.assertIn("names no images", self.text)

    def test_of_two_cameras_both_are_shown(self):
        rig = write_rig(self.folder / "rig")
        run = write_run(self.folder / "of rig", rig)
        data = self.data(run)
        self.assertEqual([len(pictures) for pictures in data["other_pictures"]], [FRAMES])
        self.assertEqual([k for k, shown in enumerate(data["other_pictures"][0]) if shown is None], [1])
        for frame in data["frames"]:
            self.assertEqual(len(frame["tracks"]), TRACKS)
            first = {track: (u, label) for track, u, _, label in frame["tracks"]}
            self.assertEqual([track for track, *_ in frame["others"][0]], list(range(0, TRACKS, 2)))
            for track, u, _, label in frame["others"][0]:
                self.assertAlmostEqual(u, first[track][0] - 20, delta=0.11)
                self.assertEqual(label, first[track][1])
        self.assertEqual(self.text.count("<canvas id="), 3)
        if shutil.which("chromium"):
            self.assertIn('data-image="true,true"', self.drawn(run, "#frame=12"))
        (rig / "right" / "000007.png").unlink()
        self.data(run, f"timeline: warning: 1 images of camera 1 are missing, as {rig}/right/000007.png.\n")

    def test_the_same_bytes_again(self):
        self.data()
        first = self.text
        self.data()
        self.assertEqual(first, self.text)

    def test_what_cannot_be_shown_is_refused(self):
        """In one line, printable, with the file."""
        nothing = self.folder / "nothing"
        nothing.mkdir(exist_ok=True)
        compared = self.folder / "compared"
        compared.mkdir(exist_ok=True)
        (compared / "compare.json").write_text("{}")
        nowhere = write_run(self.folder / "nowhere", self.folder / "gone")
        broken = write_run(self.folder / "broken", self.sequence)
        (broken / "landmarks.csv").write_text("track,frame\n1,2\n")
        other = write_run(self.folder / "other", self.sequence)
        (other / "timeline.html").write_text("mine")
        for run, words in ((nothing, "trajectory.tum: no such file"), (compared, "is a comparison"), (nowhere, "sequence.yaml: no such file"),
                           (broken, "is not as slammot writes it"), (other, "was not written by slammot")):
            with self.subTest(words):
                code, said = make(run)
                self.assertEqual(code, 2, said)
                self.assertRegex(said, rf"\Atimeline: [ -~]*{words}[ -~]*\n\Z")
        self.assertEqual((other / "timeline.html").read_text(), "mine")

    def drawn(self, run, asked):
        """The head of what Chromium makes of a page."""
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
            done = subprocess.run(
                ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
                 "--disable-component-update", "--disable-sync", "--enable-logging=stderr", "--virtual-time-budget=5000",
                 f"--user-data-dir={profile}", "--dump-dom", (run / "timeline.html").as_uri() + asked],
                capture_output=True, text=True, timeout=300, check=False)
        self.assertNotIn(":CONSOLE", done.stderr)
        self.assertNotIn("data-error", done.stdout[:1000])
        return done.stdout[:1000]

    @unittest.skipUnless(shutil.which("chromium"), "needs chromium")
    def test_it_is_drawn_at_the_frame_of_its_address(self):
        self.data()
        for asked, shown in (("", 0), ("#frame=12", 12), ("#frame=999", FRAMES - 1)):
            with self.subTest(asked):
                html = self.drawn(self.run_folder, asked)
                self.assertIn(f'data-drawn="{shown}"', html)
                counts = [sum(label_of(shown, track) == label for track in range(TRACKS)) for label in (*timeline.LABELS, None)]
                self.assertIn(f'data-marks="{",".join(map(str, counts))}"', html)
                self.assertIn('data-image="true"', html)


if __name__ == "__main__":
    unittest.main()
