"""`pip install .` gives the reader and the judge without a compiler and without the network."""
import importlib.util
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
USE = """
import numpy, slammot
from slammot.report import page
poses = numpy.column_stack([numpy.arange(9.0), numpy.random.rand(9, 3), numpy.zeros((9, 3)), numpy.ones(9)])
assert slammot.evaluate(poses, numpy.tile(numpy.eye(6), (9, 1, 1)), poses).figures["nees.pose.mean"] == 0.0
page.template("compare.html"), page.template("study.html"), page.template("timeline.html"), page.text_of("page.js")
print(slammot.__file__, slammot.__version__)
"""


@unittest.skipUnless(all(importlib.util.find_spec(name) for name in ("pip", "setuptools", "wheel")), "needs pip, setuptools and wheel")
class Install(unittest.TestCase):
    def test_what_pip_installs_judges(self):
        with tempfile.TemporaryDirectory() as temporary:
            source, site = pathlib.Path(temporary, "source"), pathlib.Path(temporary, "site")
            source.mkdir()
            for name in ("pyproject.toml", "setup.cfg", "README.md", "LICENSE"):
                shutil.copy(ROOT / name, source)
            shutil.copytree(ROOT / "python", source / "python", ignore=shutil.ignore_patterns("*.egg-info", "__pycache__"))
            pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-build-isolation", "--no-deps", "--target", site, source]
            done = subprocess.run(pip, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((site / "slammot" / "py.typed").is_file())
            used = subprocess.run([sys.executable, "-c", USE], cwd=temporary, env={"PYTHONPATH": str(site)}, capture_output=True, text=True, check=False)
            self.assertEqual(used.returncode, 0, used.stderr)
            where, version = used.stdout.split()
            self.assertTrue(where.startswith(str(site)))
            stated = re.search(r"project\(slammot VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
            self.assertEqual(version, stated)


if __name__ == "__main__":
    unittest.main()
