"""examples/extension/, built against the installed slammot: every command knows its rows.

usage: test_extension.py MY_SLAMMOT
"""
import functools
import json
import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "eval"))
import fixture  # noqa: E402
from fixture import ROOT  # noqa: E402

# What the example takes from the installation must not come from the source tree.
program = functools.partial(fixture.program, env={key: value for key, value in os.environ.items() if not key.startswith("SLAMMOT")})


class Extension(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def test_lists_keys_and_help(self):
        for table, name in (("landmarks", "decaying_velocity"), ("classifiers", "speed"), ("metrics", "path_ratio"),
                            ("readers", "pixel_list"), ("estimators", "dead_reckoning"), ("scenarios", "corridor")):
            self.assertRegex(program("list", table).stdout, rf"(?m)^{name} ")
        usage = program("run", "--help").stdout
        self.assertRegex(usage, r"(?m)^  landmark .*decaying_velocity")
        self.assertRegex(usage, r"(?m)^  classifier .*speed")
        self.assertRegex(usage, r"(?m)^  classifier.speed .*\(0.3\)")
        self.assertIn("between the walls", program("simulate", "--help").stdout)
        for wrong, name in ((["simulate", "corridor", "--set", "widht=3", "--output", self.folder / "never"], "widht"),
                            (["compare", "--set", "classifier.speed=much", "--output", self.folder / "never"], "classifier.speed")):
            self.assertIn(name, program(*wrong, code=2).stderr)

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
            written = json.loads((out / run["folder"] / "metrics.json").read_text(encoding="utf-8"))
            for trajectory in ("filtered", "smoothed"):
                self.assertEqual((written[trajectory] or {}).get("path_ratio"), (run["metrics"][trajectory] or {}).get("path_ratio"))
        self.assertEqual(content["runs"][0]["landmark"], "decaying_velocity")
        page = (out / "report.html").read_text(encoding="utf-8")
        for text in ('title="estimated over true length of the path">path ratio', "dead_reckoning", "decaying_velocity"):
            self.assertIn(text, page)

    def test_its_scenario_repeats(self):
        for name in ("once", "again"):
            program("simulate", "corridor", "--set", "frames=5", "--seed", 5, "--output", self.folder / name)
        self.assertEqual(*((self.folder / name / "observations.csv").read_bytes() for name in ("once", "again")))

    def test_study_with_all_of_it(self):
        out = self.folder / "study"
        program("study", ROOT / "examples/extension/study.yaml", "--runs", 2, "--jobs", 1, "--output", out)
        rows = (out / "runs.csv").read_text(encoding="utf-8").splitlines()
        self.assertEqual(len(rows), 1 + 2 * 4 * 2)
        self.assertIn("filtered_path_ratio", rows[0].split(","))
        self.assertIn("classifier.speed", rows[0].split(","))
        cells = json.loads((out / "summary.json").read_text(encoding="utf-8"))["groups"][0]["cells"]
        self.assertEqual(cells[0]["kind"], "filter")
        self.assertEqual(cells[3]["smoothed_path_ratio"]["runs"], 2)
        head = (out / "tables" / "metrics.csv").read_text(encoding="utf-8").splitlines()[0]
        self.assertIn(",path ratio", head)
        self.assertIn(",smoothed: path ratio", head)
        results = [json.loads(line) for line in (out / "results.jsonl").read_text(encoding="utf-8").splitlines()]
        of_runs = [result["filtered"]["path_ratio"] for result in results[:2]]
        self.assertAlmostEqual(cells[0]["filtered_path_ratio"]["value"], sum(of_runs) / 2, places=12)
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
