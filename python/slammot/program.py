"""The program `slammot`, for what it computes: simulated sequences and runs."""
import os
import pathlib
import shutil
import subprocess
import tempfile

from .reading import read_run, read_sequence


def program():
    """Path of the program: $SLAMMOT, else the one that this package belongs to, else the one on the PATH."""
    if "SLAMMOT" in os.environ:
        return os.environ["SLAMMOT"]
    here = pathlib.Path(__file__).absolute().parents
    belonging = [here[2] / "slammot",                       # build/release/python
                 here[2] / "build" / "release" / "slammot",  # python/ of the checkout
                 here[4] / "bin" / "slammot"]                # PREFIX/lib/python3.x/dist-packages
    for path in belonging:
        if path.is_file() and os.access(path, os.X_OK):
            return str(path)
    found = shutil.which("slammot")
    if found is None:
        raise FileNotFoundError("no program slammot: set SLAMMOT to its path, or add its folder to PATH")
    return found


def slammot(*words, diverged=False):
    """Runs the program and returns what it printed. Raises RuntimeError with its one line of reason; not for a run that
    diverged, where `diverged` may be."""
    done = subprocess.run([program(), *map(str, words)], capture_output=True, text=True, check=False)
    kept = diverged and done.returncode == 1 and "slammot: diverged at frame" in done.stderr
    if done.returncode != 0 and not kept:
        raise RuntimeError(done.stderr.strip() or f"slammot: exit {done.returncode}")
    return done.stdout


def _settings(flag, settings):
    return [word for key, value in settings.items() for word in (flag, f"{key}={value}")]


def _force(force):
    return ["--force"] if force else []


def simulate(scenario, seed=1, output=None, force=False, **settings):
    """A Sequence. It stays in the folder `output`, where one is given; `force` replaces an earlier one there. The same
    seed gives the same numbers."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(output) if output else pathlib.Path(temporary, "sequence")
        slammot("simulate", scenario, "--seed", seed, *_settings("--set", settings), "--output", folder,
                *_force(force))
        return read_sequence(folder)


def run(sequence, estimator, output, force=False, **settings):
    """Runs an estimator of the program, or `python:FILE.py:Class`, on a sequence's folder, and returns the Run. Keys with
    dots are given as ``**{"window.frames": 5}``. `force` replaces an earlier run in `output`. A run that diverged is returned
    as far as it went."""
    slammot("run", sequence, "--estimator", estimator, *_settings("--set", settings), "--output", output, *_force(force),
            diverged=True)
    return read_run(output)
