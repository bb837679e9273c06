"""The Debian package: what cpack makes passes lintian without errors, and what is in it runs where there is no compiler.

usage: test_package.py CPACK BUILD
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

CPACK, BUILD = sys.argv.pop(1), pathlib.Path(sys.argv.pop(1)).absolute()


@unittest.skipUnless(shutil.which("dpkg-shlibdeps"), "needs dpkg-dev")
class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        subprocess.run([CPACK, "-G", "DEB", "-B", cls.folder / "packed", "--config", BUILD / "CPackConfig.cmake"], check=True, capture_output=True)
        cls.package, = (cls.folder / "packed").glob("*.deb")

    def run_it(self, *words):
        program = self.folder / "prefix/usr/bin/slammot"
        done = subprocess.run([program, *words], cwd=self.folder, env={"PATH": "/nowhere", "HOME": str(self.folder)},
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_it_runs_without_a_compiler(self):
        subprocess.run(["dpkg-deb", "-x", self.package, self.folder / "prefix"], check=True)
        self.run_it("simulate", "--render", "--set", "frames=12", "--output", "images")
        self.run_it("track", "images", "--output", "tracked")
        self.run_it("compare", "tracked", "--output", "compared")
        self.assertTrue((self.folder / "compared/report.html").exists())

    @unittest.skipUnless(shutil.which("lintian"), "needs lintian")
    def test_lintian_finds_no_error(self):
        done = subprocess.run(["lintian", "--fail-on", "error", self.package], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
