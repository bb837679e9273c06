"""A stranger's four recordings, from file to report: a folder of PNGs, a rig calibrated by kalibr, a TUM folder with depth, a film.
Every command is printed; by hand only the camera is written. The images are rendered, so that nothing has to be there.

usage: test_strangers.py SLAMMOT [ROOM]; ROOM: a rendered room, or another native folder of images, instead of a small one
"""
import csv
import io
import pathlib
import shlex
import struct
import sys
import unittest

import yaml
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "eval"))
from fixture import WithFolder, program  # noqa: E402

ROOM = sys.argv.pop(1) if len(sys.argv) > 1 and pathlib.Path(sys.argv[1]).is_dir() else None
FRAMES, RATE = 30, 30


def chunk(name, content):
    return name + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)


def film(pictures, rate):
    """An AVI of JPEGs."""
    frames = []
    for picture in pictures:
        packed = io.BytesIO()
        picture.convert("RGB").save(packed, "JPEG", quality=98)
        frames.append(chunk(b"00dc", packed.getvalue()))
    width, height = pictures[0].size
    head = struct.pack("<14I", 1000000 // rate, 0, 0, 0x10, len(frames), 0, 1, 1 << 20, width, height, 0, 0, 0, 0)
    stream = struct.pack("<4s4sI2H8I4H", b"vids", b"MJPG", 0, 0, 0, 0, 1, rate, 0, len(frames), 1 << 20, 0, 0, 0, 0, width, height)
    form = struct.pack("<IiiHH4sIiiII", 40, width, height, 1, 24, b"MJPG", 3 * width * height, 0, 0, 0, 0)
    heads = chunk(b"LIST", b"hdrl" + chunk(b"avih", head) + chunk(b"LIST", b"strl" + chunk(b"strh", stream) + chunk(b"strf", form)))
    index, at = b"", 4
    for frame in frames:
        index += struct.pack("<4sIII", b"00dc", 0x10, at, len(frame) - 8)
        at += len(frame)
    return chunk(b"RIFF", b"AVI " + heads + chunk(b"LIST", b"movi" + b"".join(frames)) + chunk(b"idx1", index))


def images_of(folder):
    with (folder / "frames.csv").open(encoding="utf-8") as lines:
        return [folder / row["image"] for row in csv.DictReader(lines)][:FRAMES]


class Strangers(WithFolder):
    @classmethod
    def setUpClass(cls):
        """What strangers have: files, and what they know of their camera."""
        super().setUpClass()
        room = pathlib.Path(ROOM or cls.folder / "room").absolute()
        if not ROOM:
            program("simulate", "--render", "--seed", "3", "--set", f"frames={FRAMES}", "--output", room)
        cls.camera = yaml.safe_load((room / "sequence.yaml").read_text(encoding="utf-8"))["camera"]
        cls.images = images_of(room)
        cls.truth = (room / "groundtruth.tum").read_text(encoding="utf-8").splitlines(True)
        (cls.folder / "camera.yaml").write_text(yaml.safe_dump(cls.camera))

    def command(self, *words):
        """As a stranger types it; what it says on both streams."""
        print("$ slammot", shlex.join(map(str, words)), flush=True)
        done = program(*words, cwd=self.folder)
        return done.stdout, done.stderr

    def copied(self, name, count=FRAMES):
        folder = self.folder / name
        folder.mkdir(parents=True)
        for k, image in enumerate(self.images[:count]):
            Image.open(image).save(folder / f"{k}.png")
        return folder

    def to_report(self, name, *how):
        """Track, compare, and a run under the slider; what `track` says."""
        tracked, compared, run = (f"{name}_{what}" for what in ("tracked", "compared", "run"))
        said, warned = self.command("track", *how, "--output", tracked)
        self.assertIn(f"{len(self.images)} frames, 0 skipped", said)
        self.command("compare", tracked, "--output", compared)
        self.assertIn("<h1>Filter or smoother?", (self.folder / compared / "report.html").read_text(encoding="utf-8"))
        self.command("run", tracked, "--estimator", "window", "--landmarks", "every-frame", "--output", run)
        page, warned_of_page = self.command("report", run, "--timeline")
        self.assertEqual(page.strip(), f"{run}/timeline.html")
        text = (self.folder / run / "timeline.html").read_text(encoding="utf-8")
        self.assertIn(f"All {len(self.images)} frames are shown", text)
        self.assertEqual(text.count("data:image/jpeg") == len(self.images), name != "film")
        self.assertEqual(warned_of_page, "")
        return said, warned

    def test_a_folder_of_pngs(self):
        self.copied("pngs")
        said, warned = self.to_report("pngs", "pngs", "--rate", RATE, "--camera", "camera.yaml")
        self.assertIn("(camera.yaml, a file of slammot)", said)
        self.assertNotIn("not used", said)
        self.assertEqual(warned, "")

    def test_a_rig_calibrated_by_kalibr(self):
        """Of its two cameras the first is used, and that is said."""
        self.copied("rig/cam0"), self.copied("rig/cam1", 2)
        c = self.camera
        cam = {"camera_model": "pinhole", "intrinsics": [c["fx"], c["fy"], c["cx"], c["cy"]], "distortion_model": "radtan",
               "distortion_coeffs": c.get("distortion", [0.0] * 4)[:4], "resolution": [c["width"], c["height"]], "rostopic": "/cam0/image_raw"}
        (self.folder / "camchain.yaml").write_text(yaml.safe_dump({"cam0": cam, "cam1": cam | {"T_cn_cnm1": [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}))
        said, warned = self.to_report("rig", "rig/cam0", "--rate", RATE, "--camera", "camchain.yaml")
        self.assertIn("(camchain.yaml, a file of kalibr, the first of its cameras)", said)
        self.assertEqual(warned, "")

    def test_a_tum_folder_with_depth(self):
        """Its depth is measured where there is any, its truth is used."""
        self.copied("tum/rgb")
        (self.folder / "tum/depth").mkdir()
        for k in range(2):
            Image.new("I;16", (self.camera["width"], self.camera["height"])).save(self.folder / f"tum/depth/{k}.png")
        times = [line.split()[0] for line in self.truth][:len(self.images)]
        (self.folder / "tum/rgb.txt").write_text("# color images\n" + "".join(f"{t} rgb/{k}.png\n" for k, t in enumerate(times)))
        (self.folder / "tum/depth.txt").write_text("# depth maps\n" + "".join(f"{t} depth/{k}.png\n" for k, t in enumerate(times[:2])))
        (self.folder / "tum/groundtruth.txt").write_text("# timestamp tx ty tz qx qy qz qw\n" + "".join(self.truth))
        said, warned = self.to_report("tum", "tum", "--camera", "camera.yaml")
        self.assertIn("depth images measure 0 of ", said)
        self.assertNotIn("not used", said)
        self.assertEqual(warned, "")
        said, _ = self.command("track", "tum", "--camera", "camera.yaml", "--one-camera", "--output", "tum_alone")
        self.assertIn("not used depth.txt: one camera's images are\n", said)
        self.assertIn("<h1>window on tum</h1>", (self.folder / "tum_run" / "timeline.html").read_text(encoding="utf-8"))

    def test_a_film(self):
        (self.folder / "film.avi").write_bytes(film([Image.open(image) for image in self.images], RATE))
        said, warned = self.to_report("film", "film.avi", "--camera", "camera.yaml")
        self.assertIn("(camera.yaml, a file of slammot)", said)
        self.assertEqual(warned, "")


if __name__ == "__main__":
    unittest.main()
