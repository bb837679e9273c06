"""How a study is used day by day: what it says of runs that are there, of being stopped, of settings for all; and on Slurm.

usage: test_habits.py SLAMMOT
"""
import os
import signal
import subprocess
import time
import unittest

from fixture import ROOT, SLAMMOT, WithFolder, program

STUDY = """\
format: slammot-study-1
name: habits
runs: 3
scenarios: [{scenario: helix, set: {frames: FRAMES}}]
estimators: [{estimator: ekf}, {estimator: window, set: {window.frames: 3}}]
sweep: {classifier.static_threshold: [0.8]}
"""


class Habits(WithFolder):
    def study(self, frames=6):
        file = self.folder / f"habits{frames}.yaml"
        file.write_text(STUDY.replace("FRAMES", str(frames)), encoding="utf-8")
        return file

    def test_runs_that_were_there(self):
        command = ["study", self.study(), "--shard", "1/1", "--output", self.folder / "there", "--resume"]
        self.assertRegex(program(*command).stdout, r"(?m)^6 runs done$")
        self.assertRegex(program(*command, "--runs", 4).stdout, r"(?m)^2 runs done, 6 were there$")

    def test_a_setting_for_all_is_of_the_study(self):
        output = self.folder / "set"
        command = ["study", self.study(), "--output", output, "--runs", 1]
        program(*command, "--set", "motion.adaptive=false")
        self.assertIn("\n# --set motion.adaptive=false\n", (output / "study.yaml").read_text(encoding="utf-8"))
        self.assertIn("holds another study", program(*command, "--resume", code=2).stderr)
        again = ["study", output / "study.yaml", "--output", output, "--runs", 1, "--resume"]
        self.assertIn("0 runs done, 2 were there", program(*again).stdout)
        program("study", self.study(), "--output", self.folder / "plain", "--runs", 1)
        self.assertFalse((output / "results.jsonl").read_bytes() == (self.folder / "plain" / "results.jsonl").read_bytes())
        shard = program(*command[:2], "--shard", "1/2", "--output", self.folder / "shards", "--set", "motion.adaptive=false").stdout
        self.assertIn("--set motion.adaptive=false --merge --output", shard)
        for bad, reason in (("gate.probabilty=0.9", "gate.probability"), ("window.frames=4", "the study sets it for 'window'"),
                            ("classifier.static_threshold=1", "the study sweeps it"), ("gate.probability", "key=value")):
            self.assertIn(reason, program(*command, "--set", bad, code=2).stderr)

    def test_stopped_it_says_how_to_go_on(self):
        output = self.folder / "stopped"
        for sign in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen([SLAMMOT, "study", self.study(2000), "--output", output, "--jobs", "1", "--resume"],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            process.stdout.readline()
            time.sleep(0.2)
            process.send_signal(sign)
            error = process.communicate()[1]
            self.assertEqual(process.returncode, -sign)
            self.assertRegex(error, rf"stopped; the finished runs are kept in {output}. To go on: .*slammot.* study .* --resume\n$")

    def test_on_slurm_an_array_and_a_merge_that_waits_for_it(self):
        calls, tools = self.folder / "calls", self.folder / "bin"
        tools.mkdir()
        (tools / "sbatch").write_text(f'#!/bin/sh\necho "$SLAMMOT_ROLE $@" >> {calls}\necho "17;cluster"\n', encoding="utf-8")
        (tools / "sbatch").chmod(0o755)
        script, study, output = ROOT / "scripts/study.slurm", self.study(), self.folder / "slurm"
        there = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "SLAMMOT": SLAMMOT}
        subprocess.run([script, "2", study, output, "--time=1:00:00"], env=there, check=True, capture_output=True)
        array, merge = calls.read_text(encoding="utf-8").splitlines()
        self.assertRegex(array, rf"^shard .*--array=1-2 --time=1:00:00 {script} {study} {output}$")
        self.assertRegex(merge, rf"^merge .*--dependency=afterok:17 .*--time=1:00:00 {script} {study} {output}$")
        for task in ("1", "2"):
            subprocess.run([script, study, output], check=True, capture_output=True,
                           env={**there, "SLAMMOT_ROLE": "shard", "SLURM_ARRAY_TASK_ID": task, "SLURM_ARRAY_TASK_COUNT": "2"})
        subprocess.run([script, study, output], env={**there, "SLAMMOT_ROLE": "merge"}, check=True, capture_output=True)
        self.assertTrue((output / "report.html").exists())

    def test_logs_leave_the_repository_unmodified(self):
        for log in ("slammot-17-2.log", "slammot-18-merge.log"):
            ignored = subprocess.run(["git", "-C", ROOT, "check-ignore", log], capture_output=True, check=False)
            self.assertIn(ignored.returncode, (0, 128))  # 128: not a repository


if __name__ == "__main__":
    unittest.main()
