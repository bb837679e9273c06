"""against.py COMMIT [SEQUENCE ...]: CPU time of whole runs of the window by an earlier commit and by build/release, in turn on this machine.

The commit is built beside, in slammot-out/against-COMMIT; that takes minutes. Without a sequence it is `circle` with seed 5, written by the present
program. *Same method*: settings that take away what 4c410ac did not have. Both run with the same BLAS kernels, Haswell's unless OPENBLAS_CORETYPE
says otherwise. Nothing else should run meanwhile.
"""
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
SAME_METHOD = ["classifier=thesis", "labels.memory=0", "labels.sightings=2", "labels.births=static_first", "gate.given_others=1", "prior.steady_time=0"]
TURNS = 2


def built(commit):
    """The program of that commit."""
    tree = ROOT / "slammot-out" / f"against-{commit}"
    if not tree.exists():
        subprocess.run(["git", "-C", ROOT, "worktree", "add", "--detach", tree, commit], check=True)
    subprocess.run(["cmake", "-S", tree, "--preset", "release"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", tree / "build/release", "--parallel", "--target", "slammot"], check=True, stdout=subprocess.DEVNULL)
    return tree / "build/release/slammot"


def cpu_seconds(program, sequence, frames, settings, folder):
    environment = {**os.environ, "OPENBLAS_CORETYPE": os.environ.get("OPENBLAS_CORETYPE", "Haswell")}
    changes = [word for setting in [f"window.frames={frames}", *settings] for word in ("--set", setting)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([program, "run", sequence, "--estimator", "window", *changes, "--output", folder / "run"], env=environment, check=False,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if done.returncode == 2:
        sys.exit(f"{program} refuses {sequence} or a setting")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    shutil.rmtree(folder / "run")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(commit, sequences):
    here, there = ROOT / "build/release/slammot", built(commit)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if not sequences:
            subprocess.run([here, "simulate", "circle", "--seed", "5", "--output", folder / "circle"], check=True, stdout=subprocess.DEVNULL)
            sequences = [folder / "circle"]
        print(f"{'':32}{commit + ' [s]':>14}{'same method':>14}{'ratio':>8}{'defaults':>10}{'ratio':>8}")
        for sequence in map(pathlib.Path, sequences):
            for frames in (10, 20):
                turns = [[cpu_seconds(program, sequence, frames, settings, folder)
                          for program, settings in ((there, []), (here, SAME_METHOD), (here, []))] for _ in range(TURNS)]
                before, same, now = map(statistics.mean, zip(*turns))
                print(f"{sequence.name + f', window of {frames}':32}{before:14.1f}{same:14.1f}{before / same:8.1f}{now:10.1f}{before / now:8.1f}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__.splitlines()[0])
    main(sys.argv[1], sys.argv[2:])
