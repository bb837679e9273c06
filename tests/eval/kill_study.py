"""A study killed at random moments and resumed loses no run, computes none twice, and ends with the same bytes.

usage: kill_study.py SLAMMOT [KILLS] [SEED]
"""
import json
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

from fixture import SLAMMOT, program

STUDY = """\
format: slammot-study-1
name: killed
runs: 12
scenarios: [{scenario: helix, set: {frames: 20}}]
estimators: [{estimator: ekf}, {estimator: window, set: {window.frames: 3}}]
"""


def keys(journal):
    runs = [json.loads(line) for line in journal.read_bytes().splitlines(keepends=True)[1:] if line.endswith(b"\n")]
    return [(run["result"]["cell"], run["result"]["seed"]) for run in runs]


def interrupted(study, chance, longest):
    """Starts or resumes; True if it was killed before it had finished."""
    process = subprocess.Popen([SLAMMOT, *map(str, study)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(chance.uniform(0.0, longest))
    process.send_signal(chance.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM]))
    error = process.communicate()[1]
    assert process.returncode in (0, -signal.SIGKILL, -signal.SIGTERM), f"exit {process.returncode}: {error}"
    return process.returncode != 0


def main(kills=4, seed=1):
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "study.yaml").write_text(STUDY, encoding="utf-8")
        study = ["study", folder / "study.yaml", "--jobs", 2, "--output"]
        start = time.monotonic()
        program(*study, folder / "whole")
        longest = time.monotonic() - start
        expected = (folder / "whole/results.jsonl").read_bytes()
        done = studies = 0
        while done < kills:
            output = folder / str(studies)
            studies += 1
            known = []
            while done < kills and interrupted([*study, output, "--resume"], chance, longest):
                done += 1
                journal = output / "journal-1-of-1.jsonl"
                now = keys(journal) if journal.exists() else []
                assert now[:len(known)] == known, "a finished run was lost"
                known = now
            program(*study, output, "--resume")
            runs = keys(output / "journal-1-of-1.jsonl")
            assert len(runs) == len(set(runs)) == 24, "a run was computed twice"
            assert (output / "results.jsonl").read_bytes() == expected, "other bytes"
        print(f"{done} kills in {studies} studies of 24 runs: the same bytes, no run lost or computed twice")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
