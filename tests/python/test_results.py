"""Recorded results: pages show what is recorded, word for word; what is stale is said; a study is recorded as the pages want it.

usage: test_results.py SLAMMOT
"""
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "eval"))
from fixture import ROOT, WithFolder, program  # noqa: E402

loader = importlib.machinery.SourceFileLoader("results", str(ROOT / "scripts" / "results"))
results = importlib.util.module_from_spec(importlib.util.spec_from_loader("results", loader))
sys.dont_write_bytecode = True
loader.exec_module(results)
STUDY = """\
format: slammot-study-1
name: other
runs: 5
seed: 11
scenarios: [{scenario: helix, set: {frames: 8}}]
estimators: [{estimator: ekf}, {estimator: static_world}, {estimator: window, set: {window.frames: 3}}]
"""


class Pages(unittest.TestCase):
    def test_every_block_is_what_is_recorded(self):
        for page in results.pages(ROOT):
            for name, has, wanted in results.blocks(ROOT, page):
                self.assertEqual(has, wanted, f"{page.relative_to(ROOT)}: results/{name} is another: scripts/results --fill")


class Repository(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        for name, text in (("eval/studies/a.yaml", "a"), ("eval/studies/b.yaml", "b"), ("eval/x.cpp", "x"), ("docs/page.md", ""), ("README.md", "")):
            self.write(name, text)
        self.git("init", "-q")
        self.commit()

    def write(self, name, text):
        file = self.root / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def git(self, *words):
        return subprocess.run(["git", "-C", self.root, "-c", "user.name=t", "-c", "user.email=t@t", *words], check=True, capture_output=True, text=True).stdout.strip()

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "--allow-empty", "-m", "x")
        return self.git("rev-parse", "HEAD")

    def record(self, name, commit, modified=False):
        self.write(f"results/{name}/table.md", f"| {name} |\n")
        self.write(f"results/{name}/summary.json", json.dumps({"core_hours": 1.5, "runs": 50, "provenance": {"commit": commit, "modified": modified}}))

    def test_what_is_stale(self):
        self.record("a", self.git("rev-parse", "HEAD"))
        self.record("b", self.git("rev-parse", "HEAD"), modified=True)
        self.record("c", self.git("rev-parse", "HEAD"))
        self.write("docs/page.md", "words")
        self.write("eval/studies/b.yaml", "of another study")
        self.commit()
        self.assertEqual([results.state(self.root, name) for name in "abc"],
                         ["up to date", "stale: made of files that no commit has", "stale: its study is gone"])
        self.assertRegex(results.listed(self.root), r"(?m)^a +1\.50 +50 +\w{40} +up to date$")
        stale, words = "stale: the code or the study has changed", "words of a page only"
        for file, was, text, state in (("eval/studies/a.yaml", "a", "another", stale), ("eval/x.cpp", "x", "y", stale),
                                       ("eval/x.cpp", "y", "#include <map>\ny  // why\n", "up to date"), ("eval/x.cpp", "y", 'y "// text"', stale),
                                       ("python/slammot/judge/x.py", f'"{words}", "RMSE [m]"', f'"other {words}", "RMSE [m]"', "up to date"),
                                       ("python/slammot/judge/x.py", f'"{words}", "RMSE [m]"', f'"{words}", "error [m]"', stale)):
            self.write(file, was)
            self.record("a", self.commit())
            self.write(file, text)
            self.commit()
            self.assertEqual(results.state(self.root, "a"), state, text)
        self.record("a", self.git("rev-parse", "HEAD"))
        self.write("eval/there/x.cpp", (self.root / "eval/x.cpp").read_text())
        (self.root / "eval/x.cpp").unlink()
        self.commit()
        self.assertEqual(results.state(self.root, "a"), "up to date")  # its place changes no figure
        self.record("a", "0" * 40)
        self.assertEqual(results.state(self.root, "a"), "stale: its commit is not known here")

    def test_blocks_are_filled_and_a_difference_is_seen(self):
        self.record("a", "x")
        self.write("docs/page.md", "before\n\n<!-- results: a/table.md -->\nold\n<!-- end -->\nafter\n")
        page = self.root / "docs" / "page.md"
        (_, has, wanted), = results.blocks(self.root, page)
        self.assertNotEqual(has, wanted)
        self.assertEqual(results.fill(self.root), [page])
        self.assertEqual(page.read_text(), "before\n\n<!-- results: a/table.md -->\n\n| a |\n\n<!-- end -->\nafter\n")
        self.assertEqual(results.fill(self.root), [])
        self.write("results/a/table.md", "| a |\n\n| b |\n\nwords\n")
        self.assertEqual(results.content(self.root, page, "a/table.md#1"), "| a |\n\nwords")
        for text, reason in (("<!-- results: a/table.md#2 --><!-- end -->", "is not recorded"), ("<!-- results: c/table.md --><!-- end -->", "results/c/table.md is not recorded"), ("<!-- results: a/table.md -->", "no <!-- end -->"),
                             ("<!-- results: ../README.md --><!-- end -->", "is not recorded")):
            self.write("docs/page.md", text)
            with self.assertRaisesRegex(results.Refused, reason):
                results.fill(self.root)

    def test_a_program_of_other_code_records_nothing(self):
        program = self.root / "slammot"
        head = self.git("rev-parse", "HEAD")
        for said, reason in ((f"{head[:12]}, modified", "and changes"), ("0" * 12, "not of the code here"), (head[:12], None)):
            program.write_text(f"#!/bin/sh\necho 'slammot 0.1.0 (commit {said}; g++ 12)'\n")
            program.chmod(0o755)
            with unittest.mock.patch.dict(os.environ, SLAMMOT=str(program)):
                if reason is None:
                    self.assertEqual(results.program(self.root), (str(program), head[:12]))
                else:
                    with self.assertRaisesRegex(results.Refused, reason):
                        results.program(self.root)
        with self.assertRaisesRegex(results.Refused, "no such study"):
            results.record(self.root, "nothing", [])


class Recorded(WithFolder):
    def test_a_study_is_recorded_with_what_made_it(self):
        study, out = self.folder / "helix.yaml", self.folder / "out"
        study.write_text(STUDY)
        self.assertIn("in no repository", program("study", study, "--record", "--output", out, code=2).stderr)
        program("study", study, "--output", out, "--record", self.folder / "results")
        recorded = self.folder / "results" / "helix"  # the name of the file, not of the study
        self.assertEqual({file.name for file in recorded.iterdir()}, {"table.md", "summary.json"})
        summary, whole = (json.loads((at / "summary.json").read_text()) for at in (recorded, out))
        self.assertIn(f"{study} --output", summary["command"])
        self.assertEqual((summary["runs"], summary["first_seed"], summary["name"]), (5, 11, "other"))
        self.assertEqual(summary["provenance"], whole["provenance"])
        self.assertGreater(summary["core_hours"], 0.0)
        cell = summary["groups"][0]["cells"][0]
        self.assertEqual(cell["filtered_position_rmse_m"], whole["groups"][0]["cells"][0]["filtered_position_rmse_m"])
        self.assertNotIn("per_frame", cell)
        table = (recorded / "table.md").read_text()
        for line in (r"\| estimator \| runs \| ", r"\| ekf \| 5 \| [\d.]+ \[[\d.]+, [\d.]+\] \| ",
                     r".*5 runs of each, seeds 11 to 15; .* Brackets: 95% intervals over runs\.",
                     r"(More accurate|No difference is decided) \(paired t tests, 5% over all 3 pairs by Holm's correction\)"):
            self.assertRegex(table, rf"(?m)^{line}")
        self.assertNotIn(summary["provenance"]["commit"], table)
        # Again, of other bytes in its place; and nothing that is somebody else's.
        again = ["study", study, "--resume", "--output", out, "--record"]
        program(*again, self.folder / "results")
        (self.folder / "mine" / "helix").mkdir(parents=True)
        (self.folder / "mine" / "helix" / "table.md").write_text("mine")
        self.assertIn("helix: holds files that are no results of this program", program(*again, self.folder / "mine", code=2).stderr)


if __name__ == "__main__":
    unittest.main()
