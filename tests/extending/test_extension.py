"""examples/extension/, built against the installed slammot: every command knows its rows.

usage: test_extension.py MY_SLAMMOT
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = sys.argv.pop(1)
# What the example takes from the installation must not come from the source tree.
ENVIRONMENT = {key: value for key, value in os.environ.items() if not key.startswith("SLAMMOT")}


def program(*words, code=0):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False, env=ENVIRONMENT)
    assert done.returncode == code, f"exit {done.returncode}\n{done.stdout}{done.stderr}"
    return done


class Extension(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_lists_keys_and_help(self):
        for table, name in (("landmarks", "decaying_velocity"), ("classifiers", "speed"), ("metrics", "path_ratio"),
                            ("readers", "pixel_list"), ("estimators", "dead_reckoning"), ("scenarios", "corridor")):
            self.assertRegex(program("list", table).stdout, rf"(?m)^{name} ")
        usage = program("run", "--help").stdout
        self.assertRegex(usage, r"(?m)^  landmark .*decaying_velocity")
        self.assertRegex(usage, r"(?m)^  classifier .*speed")
        self.assertRegex(usage, r"(?m)^  classifier.speed .*\(0.3\)")
        self.assertIn("between the walls", program("simulate", "--help").stdout)

    def test_compare(self):
        out = self.folder / "compare"
        done = program("compare", "--scenario", "corridor", "--scenario-set", "frames=25", "--landmark", "decaying_velocity",
                       "--estimator", "ekf", "--estimator", "window", "--estimator", "dead_reckoning", "--set", "classifier=speed",
                       "--set", "classifier.speed=0.4", "--output", out)
        self.assertIn("path ratio", done.stdout)
        content = json.loads((out / "compare.json").read_text(encoding="utf-8"))
        self.assertTrue(content["command"].startswith("my_slammot compare"))
        for run in content["runs"]:
            self.assertEqual(run["configuration"]["classifier.speed"], "0.4")
            self.assertAlmostEqual(run["metrics"]["filtered"]["path_ratio"], 1.0, delta=0.5)
        self.assertEqual(content["runs"][0]["landmark"], "decaying_velocity")
        page = (out / "report.html").read_text(encoding="utf-8")
        for text in ("path ratio", "dead_reckoning", "decaying_velocity"):
            self.assertIn(text, page)

    def test_study_with_all_of_it(self):
        out = self.folder / "study"
        program("study", ROOT / "examples/extension/study.yaml", "--runs", 2, "--jobs", 1, "--output", out)
        rows = (out / "runs.csv").read_text(encoding="utf-8").splitlines()
        self.assertEqual(len(rows), 1 + 2 * 4 * 2)
        self.assertIn("filtered_path_ratio", rows[0].split(","))
        self.assertIn("classifier.speed", rows[0].split(","))
        cells = json.loads((out / "summary.json").read_text(encoding="utf-8"))["groups"][0]["cells"]
        self.assertEqual(cells[0]["kind"], "filter")
        self.assertIn("value", cells[2]["filtered_path_ratio"])
        self.assertIn("path ratio", (out / "tables" / "metrics.csv").read_text(encoding="utf-8"))
        results = [json.loads(line) for line in (out / "results.jsonl").read_text(encoding="utf-8").splitlines()]
        self.assertTrue(all(result["diverged"] is None for result in results))
        # The number swept is the classifier's: it changes nothing else. A cell has two runs.
        runs = [[results[2 * (4 * sweep + estimator)]["frames"] for sweep in (0, 1)] for estimator in range(4)]
        self.assertEqual(*runs[1])
        self.assertNotEqual(*runs[2])

    def test_its_reader(self):
        rows = [f"{0.1 * i} {track} {100 + 50 * track + i} {120 + 40 * (track % 3)}" for i in range(4) for track in range(6)]
        (self.folder / "pixels.txt").write_text("\n".join(rows) + "\n", encoding="utf-8")
        program("run", self.folder, "--estimator", "ekf", "--output", self.folder / "run")
        self.assertEqual(len((self.folder / "run" / "trajectory.tum").read_text(encoding="utf-8").splitlines()), 1 + 4)
        (self.folder / "pixels.txt").write_text("0.1 3 100 200\n0.0 5 120 90\n", encoding="utf-8")
        self.assertIn("pixels.txt:2: ", program("run", self.folder, "--estimator", "ekf", code=2).stderr)

    def test_images_and_python_are_found_from_anywhere(self):
        program("simulate", "--render", "--set", "frames=1", "--output", self.folder / "room")
        program("simulate", "helix", "--set", "frames=5", "--output", self.folder / "helix")
        estimator = f"python:{ROOT / 'examples/python/estimators.py'}:DeadReckoning"
        program("run", self.folder / "helix", "--estimator", estimator, "--output", self.folder / "run")


if __name__ == "__main__":
    unittest.main()
