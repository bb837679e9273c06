"""What the program writes, and what it never does: over an input, over what it did not write, or half a file.

usage: test_outputs.py SLAMMOT
"""
import fcntl
import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SLAMMOT = ""
SHORT = ["circle", "--set", "frames=12"]
STUDY = """\
format: slammot-study-1
name: tiny
runs: 2
scenarios: [{scenario: helix, set: {frames: 12}}]
estimators: [{estimator: ekf}]
"""


def limited(most_bytes):
    """A device that is full after this many bytes of each file."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
    return limit


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


class Outputs(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)
        self.sequence = self.folder / "sequence"

    def slammot(self, *arguments, code=0, most_bytes=None):
        done = subprocess.run([SLAMMOT, *arguments], capture_output=True, check=False, cwd=self.folder, timeout=120,
                              preexec_fn=limited(most_bytes) if most_bytes is not None else None)
        error = done.stderr.decode(errors="replace")
        self.assertEqual(done.returncode, code, error)
        if code == 2:
            self.assertEqual(error.count("\n"), 1, error)
        return done.stdout.decode(errors="replace") + error

    def refused(self, *arguments, reason, kept):
        """Exit 2, one line with the reason, and nothing in a folder has changed."""
        before = contents(kept)
        self.assertIn(reason, self.slammot(*arguments, code=2))
        self.assertEqual(contents(kept), before)

    def simulated(self):
        self.slammot("simulate", *SHORT, "--output", self.sequence)
        return self.sequence

    def users_folder(self, *files):
        folder = self.folder / "mine"
        for name in files:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text("mine", encoding="utf-8")
        return folder

    def test_what_a_run_says_against_itself_is_on_terminal_in_metrics_and_on_the_page(self):
        self.slammot("simulate", "circle", "--set", "frames=40", "--output", self.sequence)
        too_large = ["--set", "pixel_sigma=8"]  # it is 1
        run, page = self.folder / "run", self.folder / "page"
        said = self.slammot("run", self.sequence, "--estimator", "ekf", *too_large, "--output", run)
        warnings = json.loads((run / "metrics.json").read_text(encoding="utf-8"))["warnings"]
        large = [w["reason"] for w in warnings if "three times too large" in w["reason"]]
        self.assertEqual(len(large), 1)
        for warning in warnings:
            self.assertIn(f'slammot: warning: ekf, from frame {warning["frame"]}: {warning["reason"]}\n', said)
        said = self.slammot("compare", self.sequence, *too_large, "--output", page)
        self.assertEqual(said.count("three times too large"), 2)
        self.assertIn(large[0], (page / "report.html").read_text(encoding="utf-8"))

    def test_what_is_in_force_is_in_every_file_and_on_the_page(self):
        self.slammot("simulate", *SHORT, "--output", self.sequence)
        run, page = self.folder / "run", self.folder / "page"
        iterated = ["--set", "ekf.iterations=3", "--set", "gauge=scale", "--output", run]
        said = self.slammot("run", self.sequence, "--estimator", "ekf", *iterated)
        self.assertIn("asked for, but without effect: ", said)
        stated = json.loads((run / "metrics.json").read_text(encoding="utf-8"))["in_force"]
        scale = next(m for m in stated if m["key"] == "gauge" and m["because"])
        self.assertEqual((scale["state"], scale["acted"]), ("off", 0))
        self.assertIn(f"name: {scale['name']}", (run / "run.yaml").read_text(encoding="utf-8"))
        said = self.slammot("compare", self.sequence, "--set", "preset=thesis", "--verbose", "--output", page)
        self.assertIn("in force", said)
        self.assertEqual(len(list(page.glob("*/run.yaml"))), 2)  # the thesis's landmark model alone
        for written in page.glob("*/run.yaml"):
            text = written.read_text(encoding="utf-8")
            self.assertIn("preset: thesis", text)
            self.assertIn("left_open_by_the_thesis:", text)
        self.assertIn("<h2>In force</h2>", (page / "report.html").read_text(encoding="utf-8"))

    def test_an_input_is_never_written_over(self):
        sequence = self.simulated()
        for force in ([], ["--force"]):
            for command in (["run", sequence, "--estimator", "ekf"], ["compare", sequence]):
                self.refused(*command, "--output", sequence, *force, reason="would replace", kept=sequence)

    def test_what_somebody_else_wrote_stays(self):
        sequence = self.simulated()
        study = self.folder / "tiny.yaml"
        study.write_text(STUDY, encoding="utf-8")
        mine = self.users_folder("frames/a.jpg", "slider/b.jpg", "sequence.yaml", "frames.csv", "run.yaml", "compare.json")
        for command in (["run", sequence, "--estimator", "ekf"], ["compare", sequence], ["compare"], ["simulate", *SHORT],
                        ["simulate", "--render"], ["study", study]):
            for force in ([], ["--force"]):
                self.refused(*command, "--output", mine, *force, reason="holds files that are not", kept=mine)

    def test_pictures_stay(self):
        room, tracked, run = (self.folder / name for name in ("room", "tracked", "run"))
        self.slammot("simulate", "--render", "--set", "frames=3", "--set", "width=160", "--output", room)
        self.refused("track", room, "--output", room, "--force", reason="would replace", kept=room)
        self.slammot("track", room, "--output", tracked)
        own = tracked / "track.yaml"
        text = own.read_text(encoding="utf-8")
        own.write_text("mine: 1", encoding="utf-8")
        self.refused("track", room, "--output", tracked, "--force", reason="was not written by this program", kept=tracked)
        own.write_text(text, encoding="utf-8")
        self.slammot("run", tracked, "--estimator", "ekf", "--landmarks", "every-frame", "--output", run)
        mine = self.users_folder("frames/000001.png", "slider/b.jpg", "film.mp4")
        for force in ([], ["--force"]):
            self.refused("draw", run, "--output", mine, *force, reason="not pictures", kept=mine)
            self.refused("draw", run, "--output", run, *force, reason="not pictures", kept=run)
        self.slammot("draw", run)
        stale, users = run / "pictures/frames/000009.png", run / "pictures/frames/notes.txt"
        for file in (stale, users):
            file.write_text("x", encoding="utf-8")
        self.slammot("draw", run)  # RUN/pictures is the program's own
        self.assertFalse(stale.exists())
        self.assertTrue(users.exists())
        self.refused("draw", run, "--output", run / "pictures", reason="--force", kept=run)
        self.slammot("draw", run, "--output", run / "pictures", "--force")
        self.assertFalse(list(self.folder.rglob("*unfinished*")))

    def test_images_beside_a_sequence_stay(self):
        sequence = self.simulated()
        for name in ("room.yaml", "images/000000.png"):
            mine = sequence / name
            mine.parent.mkdir(exist_ok=True)
            mine.write_text("mine", encoding="utf-8")
            self.refused("simulate", "--render", "--output", sequence, "--force", reason="replaced", kept=sequence)
            mine.unlink()

    def test_an_earlier_output_needs_force(self):
        sequence, run, compared = self.simulated(), self.folder / "run", self.folder / "compared"
        for command, output in ((["simulate", *SHORT], sequence), (["run", sequence, "--estimator", "ekf"], run),
                                (["compare", sequence, "--estimator", "ekf"], compared)):
            if not output.exists():
                self.slammot(*command, "--output", output)
            self.refused(*command, "--output", output, reason="--force replaces it", kept=output)
            self.slammot(*command, "--output", output, "--force")
        report = compared / "report.html"
        self.slammot("report", compared)
        report.write_text("mine", encoding="utf-8")
        self.assertIn("not replaced", self.slammot("report", compared, code=2))
        self.assertEqual(report.read_text(encoding="utf-8"), "mine")

    def test_default_folders_are_replaced(self):
        sequence = self.simulated()
        study = self.folder / "tiny.yaml"
        study.write_text(STUDY, encoding="utf-8")
        for command in (["run", sequence, "--estimator", "ekf"], ["compare", sequence, "--estimator", "ekf"],
                        ["compare", "--scenario", "helix", "--scenario-set", "frames=12", "--estimator", "ekf"]):
            self.slammot(*command)
            self.slammot(*command)
        self.assertIn("2 runs done", self.slammot("study", study))
        self.assertIn("0 runs done", self.slammot("study", study))

    def test_an_interrupted_comparison_can_be_made_again(self):
        folder = self.folder / "slammot-out/compare-circle"
        self.slammot("simulate", *SHORT, "--output", folder / "sequence")
        self.slammot("compare", code=2)  # it cannot know whose these are
        shutil.rmtree(folder)
        process = subprocess.Popen([SLAMMOT, "compare"], cwd=self.folder, stdout=subprocess.DEVNULL)
        while not folder.exists():
            pass
        process.kill()
        process.wait()
        self.slammot("compare", "--scenario-set", "frames=12", "--estimator", "ekf")

    def test_a_comparison_that_never_began_can_be_made_again(self):
        self.slammot("compare", "nowhere", "--output", "out", code=2)
        self.slammot("compare", "--scenario", "nowhere", "--output", "out", code=2)
        self.slammot("compare", "--set", "frames.first=9000", "--output", "out", code=2)
        self.slammot("compare", self.simulated(), "--estimator", "ekf", "--output", "out")
        self.refused("compare", self.sequence, "--estimator", "ekf", "--output", "out", reason="holds a comparison already", kept=self.folder / "out")

    def test_a_comparison_under_way_is_left_alone(self):
        """Also when it has finished a run."""
        self.slammot("compare", "--scenario-set", "frames=8", "--estimator", "ekf", "--output", "out")
        with open(self.folder / "out" / ".slammot-lock", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.refused("compare", self.simulated(), "--estimator", "ekf", "--output", "out", "--force",
                         reason="another process is at work on it", kept=self.folder / "out")
        process = subprocess.Popen([SLAMMOT, "compare", "--scenario-set", "frames=200", "--landmark", "scaled_velocity", "--output", "long"],
                                   cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        mark = self.folder / "long" / "compare.json"
        while not (mark.exists() and '"label"' in mark.read_text(encoding="utf-8")):
            self.assertIsNone(process.poll())
            time.sleep(0.01)
        self.slammot("compare", "--scenario-set", "frames=12", "--estimator", "ekf", "--output", "long", "--force", code=2)
        self.assertEqual(process.wait(), 0)

    def test_a_users_file_in_a_sequence_stays(self):
        """Whatever its name, --force or not."""
        sequence = self.folder / "mine"
        self.slammot("simulate", "circle", "--set", "frames=8", "--set", "known=0", "--output", "mine")
        (sequence / "known.csv").write_text("track,x,y,z,sigma\n1,0,0,5,0.1\n", encoding="utf-8")
        for known in ("0", "4"):
            self.refused("simulate", "circle", "--set", f"known={known}", "--output", "mine", "--force",
                         reason="known.csv: was not written by this program", kept=sequence)

    def test_metrics_are_written_over_nothing(self):
        sequence, run, file = self.simulated(), self.folder / "run", self.folder / "metrics.json"
        self.slammot("run", sequence, "--estimator", "ekf", "--output", run)
        evaluate = ["evaluate", run, "--json"]
        for force in ([], ["--force"]):
            for name in ("metrics.json", "run.yaml", "trajectory.tum"):
                self.refused(*evaluate, run / name, *force, reason="", kept=run)
            self.refused(*evaluate, sequence / "frames.csv", *force, reason="", kept=sequence)
        self.slammot(*evaluate, file)
        self.slammot(*evaluate, file, code=2)
        self.slammot(*evaluate, file, "--force")
        self.slammot(*evaluate, "/dev/null")
        self.assertIn("/dev/full: cannot be written: No space left on device", self.slammot(*evaluate, "/dev/full", code=1))

    def test_a_full_device_loses_nothing(self):
        sequence = self.simulated()
        run, compared, evaluated = (self.folder / name for name in ("run", "compared", "metrics.json"))
        self.slammot("run", sequence, "--estimator", "ekf", "--output", run)
        self.slammot("compare", sequence, "--estimator", "ekf", "--output", compared)
        self.slammot("evaluate", run, "--json", evaluated)
        before = contents(self.folder)
        for command, least in ((["run", sequence, "--estimator", "ekf", "--output", run, "--force"], "trajectory.tum"),
                               (["simulate", *SHORT, "--output", sequence, "--force"], "frames.csv"),
                               (["compare", sequence, "--estimator", "ekf", "--output", compared, "--force"], "compare.json"),
                               (["evaluate", run, "--json", evaluated, "--force"], "metrics.json")):
            for most_bytes in (0, 100, 3000):
                with self.subTest(command=command[0], most_bytes=most_bytes):
                    said = self.slammot(*command, code=1, most_bytes=most_bytes)
                    self.assertRegex(said, r"slammot: \S+: cannot be written: File too large\n")
        self.assertEqual(contents(self.folder), before)
        size = max(path.stat().st_size for path in sequence.iterdir())
        self.slammot("simulate", *SHORT, "--output", sequence, "--force", code=1, most_bytes=size - 1)  # the last byte
        self.slammot("simulate", *SHORT, "--output", sequence, "--force", most_bytes=size)

    def test_a_name_stays_in_its_folder(self):
        sequence = self.simulated()
        settings = sequence / "sequence.yaml"
        good = settings.read_text(encoding="utf-8")
        for name in ("a/../../x", "..", "", r"a\nb", "x" * 300):
            settings.write_text(good.replace('"circle-1"', f'"{name}"'), encoding="utf-8")
            self.refused("run", sequence, "--estimator", "ekf", reason="sequence.yaml:3: 'name'", kept=self.folder)

    def test_names_of_folders(self):
        self.slammot("simulate", "--render", "--set", "frames=3", "--set", "width=160", "--output", "a, b")
        self.slammot("track", "a, b", "--output", "c, d")  # names the images beside it
        self.slammot("run", "c, d", "--estimator", "ekf", "--landmarks", "every-frame", "--output", "e, f")
        self.slammot("draw", "e, f")
        latin = os.path.join(os.fsencode(self.folder), b"caf\xe9")
        shutil.copytree(os.fsencode(self.folder / "c, d"), latin)
        self.assertIn(r"caf\xe9", self.slammot("compare", b"caf\xe9", code=2))
        self.assertIn("not UTF-8", self.slammot("run", "c, d", "--estimator", "ekf", "--output", b"\xe9", code=2))

    def test_a_pipe_is_no_file(self):
        sequence, run = self.simulated(), self.folder / "run"
        self.slammot("run", sequence, "--estimator", "ekf", "--output", run)
        for folder, names, command in ((sequence, ("sequence.yaml", "observations.csv", "known.csv"),
                                        ["run", sequence, "--estimator", "ekf"]),
                                       (run, ("run.yaml", "trajectory.tum", "metrics.json"), ["evaluate", run])):
            for name in names:
                file = folder / name
                kept = file.read_bytes()
                file.unlink()
                os.mkfifo(file)
                self.assertIn(f"{name}: cannot be read", self.slammot(*command, code=2))
                file.unlink()
                file.write_bytes(kept)
        author = self.folder / "author"
        author.mkdir()
        os.mkfifo(author / "groundTruth.txt")
        self.slammot("run", author, "--estimator", "ekf", code=2)

    def test_a_configuration_within_itself(self):
        sequence, file = self.simulated(), self.folder / "c.yaml"
        wide = "a: &a {x: {}, y: {}, z: {}}\n" + "".join(
            f"{chr(98 + i)}: &{chr(98 + i)} {{x: *{chr(97 + i)}, y: *{chr(97 + i)}, z: *{chr(97 + i)}}}\n" for i in range(20))
        for text in ("a: &x {b: *x}\n", wide, "[" * 100000, "{a: " * 100000, "- 1", "a\n", "a: [1]", "\xff: 1", "a: \x00"):
            file.write_text(text, encoding="latin-1")
            self.assertIn("c.yaml:", self.slammot("run", sequence, "--estimator", "ekf", "--config", file, code=2))

    def test_without_measurements_no_estimator_is_the_best(self):
        sequence = self.simulated()
        (sequence / "observations.csv").write_text("frame,track,u,v\n", encoding="utf-8")
        self.slammot("compare", sequence, "--output", "out")
        page = (self.folder / "out/report.html").read_text(encoding="utf-8")
        self.assertNotIn("most accurate", page)
        self.assertIn("no run used any measurement", page)

    def test_a_page_of_what_slammot_did_not_write_is_refused_in_one_line(self):
        for name, text in (("compare.json", '{"format": "slammot-compare-1", "runs": 5}'), ("summary.json", '{"format": "slammot-summary-2", "figures": 3}')):
            folder = self.users_folder(f"{name}.d/results.jsonl") / f"{name}.d"
            (folder / name).write_text(text, encoding="utf-8")
            self.refused("report", folder, reason=f"{name}: ", kept=folder)
        (folder / "compare.json").symlink_to("/dev/zero")
        self.refused("report", folder, reason="compare.json: not a regular file", kept=folder)

    def test_figures_and_tables_are_written_aside(self):
        study, output, before = self.folder / "tiny.yaml", self.folder / "output", self.folder / "before"
        study.write_text(STUDY + 'figures: [anees]\nlatex: {columns: [position_rmse_m]}\n', encoding="utf-8")
        self.slammot("study", study, "--output", output)
        before.mkdir()
        files = [*(output / "tables").iterdir(), *(output / "figures").iterdir()]
        self.assertLessEqual({"paper.tex", "anees.pdf", "anees.png"}, {file.name for file in files})
        for file in files:
            os.link(file, before / file.name)  # the same file: it would change with it
            file.write_text("before", encoding="utf-8")
        self.slammot("report", output)
        for file in files:
            self.assertEqual((before / file.name).read_text(encoding="utf-8"), "before")
            self.assertNotEqual(file.read_bytes(), b"before")

    def test_a_figure_stays_in_its_folder(self):
        """Also where another program named it."""
        study, output = self.folder / "tiny.yaml", self.folder / "deep/output"
        study.write_text(STUDY + 'sweep: {ekf.iterations: [1, 2]}\nfigures: ["against_sweep:position_rmse_m"]\n', encoding="utf-8")
        self.slammot("study", study, "--output", output)
        plan = json.loads((output / "plan.json").read_text(encoding="utf-8"))
        plan["figures"] = ["../../escape:position_rmse_m"]
        (output / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
        before = set(contents(self.folder))
        self.slammot("report", output)
        made = set(contents(self.folder)) - before
        self.assertEqual(len(made), 2, made)
        self.assertEqual({path.parts[:3] for path in made}, {("deep", "output", "figures")})

    def test_a_page_that_cannot_be_finished_leaves_nothing_behind(self):
        self.slammot("compare", self.simulated(), "--estimator", "ekf", "--output", "out")
        before = contents(self.folder / "out")
        self.slammot("report", self.folder / "out", code=1, most_bytes=1000)
        self.assertEqual(contents(self.folder / "out"), before)

    def test_what_is_said_and_lost_is_an_error(self):
        sequence, run = self.simulated(), self.folder / "run"
        self.slammot("run", sequence, "--estimator", "ekf", "--output", run)
        for command in (["evaluate", run], ["run", sequence, "--estimator", "ekf", "--output", run, "--force"], ["list", "scenarios"], ["--version"]):
            with open("/dev/full", "w", encoding="utf-8") as full:
                done = subprocess.run([SLAMMOT, *command], stdout=full, stderr=subprocess.PIPE, text=True, check=False, timeout=120)
            self.assertEqual(done.returncode, 1, command)
            self.assertTrue(done.stderr.endswith("slammot: standard output: cannot be written\n"), done.stderr)

    def test_more_threads_than_there_are_cores(self):
        self.slammot("simulate", "--render", "--set", "frames=3", "--set", "width=160", "--output", "room")
        self.slammot("track", "room", "--threads", "100000", "--output", "tracked")


if __name__ == "__main__":
    SLAMMOT = str(pathlib.Path(sys.argv.pop(1)).absolute())
    unittest.main()
