"""Image codecs bring two hundred shared libraries along, so only commands that touch images load them."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SLAMMOT = sys.argv.pop(1)

CODECS = {"libslammot_codecs", "libopencv_imgcodecs", "libopencv_videoio", "libgdal", "libavcodec"}
MOST_LIBRARIES = 70


def loaded_by(*arguments):
    """Names of all libraries that this command loads, at its start and later, without versions."""
    with tempfile.TemporaryDirectory() as folder:
        # The program may start itself anew: each process writes a file of its own.
        log = pathlib.Path(folder, "log")
        subprocess.run([SLAMMOT, *arguments], check=True, stdout=subprocess.DEVNULL,
                       env=os.environ | {"LD_DEBUG": "libs", "LD_DEBUG_OUTPUT": str(log)})
        text = "".join(file.read_text() for file in pathlib.Path(folder).glob("log.*"))
    return {pathlib.Path(path).name.split(".so")[0]
            for path in re.findall(r"calling init: (\S+)", text)}


class LoadedLibraries(unittest.TestCase):
    def test_no_codecs_without_images(self):
        for command in (["--version"], ["list", "scenarios"]):
            with self.subTest(command=command):
                loaded = loaded_by(*command)
                self.assertIn("libc", loaded)  # or nothing was looked at
                self.assertEqual(loaded & CODECS, set())
                self.assertLess(len(loaded), MOST_LIBRARIES)

    def test_codecs_with_images(self):
        with tempfile.TemporaryDirectory() as folder:
            loaded = loaded_by("simulate", "--render", "--set", "frames=1", "--output", folder)
        self.assertLessEqual(CODECS, loaded)

    def test_without_the_module(self):
        with tempfile.TemporaryDirectory() as folder:
            alone = shutil.copy(SLAMMOT, folder)
            subprocess.run([alone, "--version"], check=True, stdout=subprocess.DEVNULL)
            run = subprocess.run([alone, "simulate", "--render", "--output", folder + "/room"],
                                 stderr=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, r"^slammot: images cannot .* libslammot_codecs\.so: .*\n$")


if __name__ == "__main__":
    unittest.main()
