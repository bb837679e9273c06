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
import tempfile
import time
import unittest

from fixture import SLAMMOT, WithFolder, contents, program

SHORT = ["helix", "--set", "frames=12"]
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


class Outputs(WithFolder):
    @classmethod
    def setUpClass(cls):
        """One output of each command, to be copied: into `folder`, which is then the test's own."""
        super().setUpClass()
        cls.made, cls.sequence = cls.folder, cls.folder / "sequence"
        program("simulate", *SHORT, "--output", cls.sequence)
        program("run", cls.sequence, "--estimator", "ekf", "--output", cls.made / "run")
        program("compare", cls.sequence, "--estimator", "ekf", "--output", cls.made / "compared")
        program("simulate", "--render", "--set", "frames=3", "--set", "width=160", "--output", cls.made / "room")

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def slammot(self, *arguments, most_bytes=None, **more):
        done = program(*arguments, cwd=self.folder, timeout=120, preexec_fn=limited(most_bytes) if most_bytes is not None else None, **more)
        return done.stdout + done.stderr

    def refused(self, *arguments, reason, kept):
        """Exit 2, one line with the reason, and nothing in a folder has changed."""
        before = contents(kept)
        self.assertIn(reason, self.slammot(*arguments, code=2))
        self.assertEqual(contents(kept), before)

    def copy(self, name, to=None):
        return shutil.copytree(self.made / name, self.folder / (to or name))

    def written(self, name, text):
        file = self.folder / name
        file.write_text(text, encoding="utf-8")
        return file

    def users_folder(self, *files):
        folder = self.folder / "mine"
        for name in files:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text("mine", encoding="utf-8")
        return folder

    def test_what_a_run_says_against_itself_is_on_terminal_in_metrics_and_on_the_page(self):
        run, page = self.folder / "run", self.folder / "page"
        too_large = ["--estimator", "ekf", "--set", "pixel_sigma=8"]  # it is 1
        said = self.slammot("run", self.sequence, *too_large, "--output", run)
        warnings = json.loads((run / "metrics.json").read_text(encoding="utf-8"))["warnings"]
        large = [w["reason"] for w in warnings if "three times too large" in w["reason"]]
        self.assertEqual(len(large), 1)
        for warning in warnings:
            self.assertIn(f'slammot: warning: ekf, from frame {warning["frame"]}: {warning["reason"]}\n', said)
        said = self.slammot("compare", self.sequence, *too_large, "--output", page)
        self.assertEqual(said.count("three times too large"), 2)  # of each landmark model
        self.assertIn(large[0], (page / "report.html").read_text(encoding="utf-8"))

    def test_what_is_in_force_is_in_every_file_and_on_the_page(self):
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
        runs = [file.read_text(encoding="utf-8") for file in page.glob("*/run.yaml")]
        self.assertEqual(len(runs), 2)  # the thesis's landmark model alone
        self.assertTrue(all("preset: thesis" in text and "left_open_by_the_thesis:" in text for text in runs))
        self.assertIn("<h2>In force</h2>", (page / "report.html").read_text(encoding="utf-8"))

    def test_an_input_is_never_written_over(self):
        sequence = self.copy("sequence")
        for force in ([], ["--force"]):
            for command in (["run", sequence, "--estimator", "ekf"], ["compare", sequence]):
                self.refused(*command, "--output", sequence, *force, reason="would replace", kept=sequence)

    def test_what_somebody_else_wrote_stays(self):
        mine = self.users_folder("frames/a.jpg", "slider/b.jpg", "sequence.yaml", "frames.csv", "run.yaml", "compare.json", "results.jsonl", "runs.csv")
        study = self.written("mine/study.yaml", STUDY)  # a study may stand where its output goes
        for command in (["run", self.sequence, "--estimator", "ekf"], ["compare", self.sequence], ["compare"], ["simulate", *SHORT],
                        ["simulate", "--render"], ["study", study], ["study", study, "--resume"], ["study", study, "--merge"],
                        ["report", self.made / "run"]):
            for force in ([], ["--force"]):
                self.refused(*command, "--output", mine, *force, reason="holds files that are not", kept=mine)

    def test_pictures_stay(self):
        room, tracked, run = self.copy("room"), self.folder / "tracked", self.folder / "run"
        self.refused("track", room, "--output", room, "--force", reason="would replace", kept=room)
        self.slammot("track", room, "--threads", "100000", "--output", tracked)  # more than there are cores
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

    def test_a_users_file_in_a_sequence_stays(self):
        """Whatever its name, --force or not."""
        sequence, known = self.folder / "mine", "track,x,y,z,sigma\n1,0,0,5,0.1\n"
        self.slammot("simulate", "circle", "--set", "frames=8", "--set", "known=0", "--output", sequence)
        for name, text, command, reason in (("room.yaml", "mine", ["--render"], "replaced"), ("images/000000.png", "mine", ["--render"], "replaced"),
                                            ("known.csv", known, ["circle", "--set", "known=0"], "known.csv: was not written by this program"),
                                            ("known.csv", known, ["circle", "--set", "known=4"], "known.csv: was not written by this program")):
            mine = sequence / name
            mine.parent.mkdir(exist_ok=True)
            mine.write_text(text, encoding="utf-8")
            self.refused("simulate", *command, "--output", sequence, "--force", reason=reason, kept=sequence)
            mine.unlink()

    def test_an_earlier_output_needs_force(self):
        for command, name in ((["simulate", *SHORT], "sequence"), (["run", self.sequence, "--estimator", "ekf"], "run"),
                              (["compare", self.sequence, "--estimator", "ekf"], "compared"), (["report", self.made / "run"], "compared")):
            output = self.copy(name, to=f"{command[0]}-{name}")
            self.refused(*command, "--output", output, reason="--force replaces it", kept=output)
            self.slammot(*command, "--output", output, "--force")
        self.slammot("report", output)
        (output / "report.html").write_text("mine", encoding="utf-8")
        self.refused("report", output, reason="not replaced", kept=output)

    def test_default_folders_are_replaced(self):
        study = self.written("tiny.yaml", STUDY)
        for command in (["run", self.sequence], ["compare", "--scenario", "helix", "--scenario-set", "frames=12"]):
            for _ in range(2):
                self.slammot(*command, "--estimator", "ekf")
        self.assertIn("2 runs done", self.slammot("study", study))
        self.assertIn("0 runs done", self.slammot("study", study))

    def test_a_comparison_that_ended_before_its_first_run_can_be_made_again(self):
        folder = self.folder / "slammot-out/compare-circle"
        self.copy("sequence", to=folder / "sequence")
        self.slammot("compare", code=2)  # it cannot know whose these are
        shutil.rmtree(folder)
        process = subprocess.Popen([SLAMMOT, "compare"], cwd=self.folder, stdout=subprocess.DEVNULL)
        while not folder.exists():
            pass
        process.kill()
        process.wait()
        self.slammot("compare", "--scenario-set", "frames=5", "--estimator", "ekf")
        for never in (["nowhere"], ["--scenario", "nowhere"], ["--set", "frames.first=9000"]):
            self.slammot("compare", *never, "--output", "out", code=2)
        self.slammot("compare", self.sequence, "--estimator", "ekf", "--output", "out")

    def test_a_comparison_under_way_is_left_alone(self):
        """Also when it has finished a run."""
        out = self.copy("compared")
        again = ["compare", self.sequence, "--estimator", "ekf", "--force", "--output"]
        with open(out / ".slammot-lock", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.refused(*again, out, reason="another process is at work on it", kept=out)
        process = subprocess.Popen([SLAMMOT, "compare", "--scenario", "helix", "--scenario-set", "frames=200", "--landmark", "scaled_velocity",
                                    "--output", "long"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        mark = self.folder / "long" / "compare.json"
        while not (mark.exists() and '"label"' in mark.read_text(encoding="utf-8")):
            self.assertIsNone(process.poll())
            time.sleep(0.01)
        self.slammot(*again, "long", code=2)
        self.assertEqual(process.wait(), 0)

    def test_metrics_are_written_over_nothing(self):
        sequence, run, file = self.copy("sequence"), self.copy("run"), self.folder / "metrics.json"
        evaluate = ["evaluate", run, "--against", sequence, "--json"]
        for force in ([], ["--force"]):
            for kept in (run / "metrics.json", run / "run.yaml", run / "trajectory.tum", sequence / "frames.csv"):
                self.refused(*evaluate, kept, *force, reason="", kept=kept.parent)
        self.slammot(*evaluate, file)
        self.slammot(*evaluate, file, code=2)
        self.slammot(*evaluate, file, "--force")
        self.slammot(*evaluate, "/dev/null")
        self.assertIn("/dev/full: cannot be written: No space left on device", self.slammot(*evaluate, "/dev/full", code=1))

    def test_a_full_device_loses_nothing(self):
        sequence, run, compared = (self.copy(name) for name in ("sequence", "run", "compared"))
        evaluated = self.folder / "metrics.json"
        self.slammot("evaluate", run, "--json", evaluated)
        before = contents(self.folder)
        for command, most in ((["run", sequence, "--estimator", "ekf", "--output", run, "--force"], (0, 100, 3000)),
                              (["simulate", *SHORT, "--output", sequence, "--force"], (0, 100, 3000)),
                              (["compare", sequence, "--estimator", "ekf", "--output", compared, "--force"], (0, 100, 3000)),
                              (["evaluate", run, "--json", evaluated, "--force"], (0, 100, 3000)), (["report", compared], (1000,))):
            for most_bytes in most:
                with self.subTest(command=command[0], most_bytes=most_bytes):
                    said = self.slammot(*command, code=1, most_bytes=most_bytes)
                    self.assertRegex(said, r"\S+: cannot be written: File too large\n")
        self.assertEqual(contents(self.folder), before)
        size = max(path.stat().st_size for path in sequence.iterdir())
        self.slammot("simulate", *SHORT, "--output", sequence, "--force", code=1, most_bytes=size - 1)  # the last byte
        self.slammot("simulate", *SHORT, "--output", sequence, "--force", most_bytes=size)

    def test_a_name_stays_in_its_folder(self):
        sequence = self.copy("sequence")
        good = (sequence / "sequence.yaml").read_text(encoding="utf-8")
        for name in ("a/../../x", "..", "", r"a\nb", "x" * 300):
            (sequence / "sequence.yaml").write_text(good.replace('"helix-1"', f'"{name}"'), encoding="utf-8")
            self.refused("run", sequence, "--estimator", "ekf", reason="sequence.yaml:3: 'name'", kept=self.folder)

    def test_names_of_folders(self):
        self.copy("room", to="a, b")
        self.slammot("track", "a, b", "--output", "c, d")  # names the images beside it
        self.slammot("run", "c, d", "--estimator", "ekf", "--landmarks", "every-frame", "--output", "e, f")
        self.slammot("draw", "e, f")
        latin = os.path.join(os.fsencode(self.folder), b"caf\xe9")
        shutil.copytree(os.fsencode(self.folder / "c, d"), latin)
        self.assertIn(r"caf\xe9", self.slammot("compare", b"caf\xe9", code=2))
        self.assertIn("not UTF-8", self.slammot("run", "c, d", "--estimator", "ekf", "--output", b"\xe9", code=2))

    def test_a_pipe_is_no_file(self):
        sequence, run = self.copy("sequence"), self.copy("run")
        for folder, names, command in ((sequence, ("sequence.yaml", "observations.csv", "known.csv"), ["run", sequence, "--estimator", "ekf"]),
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

    def test_without_measurements_no_estimator_is_the_best(self):
        sequence = self.copy("sequence")
        (sequence / "observations.csv").write_text("frame,track,u,v\n", encoding="utf-8")
        self.slammot("compare", sequence, "--output", "out")
        page = (self.folder / "out/report.html").read_text(encoding="utf-8")
        self.assertNotIn("most accurate", page)
        self.assertIn("no run used any measurement", page)

    def test_a_page_of_what_slammot_did_not_write_is_refused_in_one_line(self):
        folder = self.users_folder("results.jsonl")
        self.refused("report", folder, reason="mine", kept=folder)
        (folder / "summary.json").write_text('{"format": "slammot-summary-2", "figures": 3}', encoding="utf-8")
        self.refused("report", folder, reason="summary.json: ", kept=folder)
        (folder / "compare.json").symlink_to("/dev/zero")
        self.refused("report", folder, reason="compare.json: not a regular file", kept=folder)

    def test_figures_and_tables_are_written_aside_and_in_their_folder(self):
        """Also a figure that another program named."""
        output, before = self.folder / "deep/output", self.folder / "before"
        drawn = "sweep: {ekf.iterations: [1, 2]}\nfigures: [anees]\nlatex: {columns: [position_rmse_m]}\n"
        self.slammot("study", self.written("tiny.yaml", STUDY.replace("runs: 2", "runs: 1") + drawn), "--output", output)
        before.mkdir()
        files = [*(output / "tables").iterdir(), *(output / "figures").iterdir()]
        self.assertLessEqual({"paper.tex", "anees.pdf", "anees.svg", "anees.png"}, {file.name for file in files})
        for file in files:
            os.link(file, before / file.name)  # the same file: it would change with it
            file.write_text("before", encoding="utf-8")
        plan = json.loads((output / "plan.json").read_text(encoding="utf-8"))
        plan["figures"] += ["../../escape:position_rmse_m"]
        (output / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
        known = set(contents(self.folder))
        self.slammot("report", output)
        for file in files:
            self.assertEqual((before / file.name).read_text(encoding="utf-8"), "before")
            self.assertNotEqual(file.read_bytes(), b"before")
        made = set(contents(self.folder)) - known
        self.assertEqual(len(made), 3, made)
        self.assertEqual({path.parts[:3] for path in made}, {("deep", "output", "figures")})

    def test_what_is_said_and_lost_is_an_error(self):
        run = self.copy("run")
        for command in (["evaluate", run], ["run", self.sequence, "--estimator", "ekf", "--output", run, "--force"], ["list", "scenarios"], ["--version"]):
            with open("/dev/full", "w", encoding="utf-8") as full:
                done = subprocess.run([SLAMMOT, *command], stdout=full, stderr=subprocess.PIPE, text=True, check=False, timeout=120)
            self.assertEqual(done.returncode, 1, command)
            self.assertTrue(done.stderr.endswith("slammot: standard output: cannot be written\n"), done.stderr)


if __name__ == "__main__":
    unittest.main()
