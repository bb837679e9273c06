"""What the tests share that run the program: their first argument names it."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SLAMMOT = os.environ["SLAMMOT"] = str(pathlib.Path(sys.argv.pop(1)).absolute())
sys.path.insert(0, str(ROOT / "python"))


def program(*words, code=0, **more):
    """What it says. Bad usage and bad input (2) are refused in one line."""
    words = [word if isinstance(word, bytes) else str(word) for word in words]
    done = subprocess.run([SLAMMOT, *words], capture_output=True, encoding="utf-8", errors="replace", check=False, **more)
    assert done.returncode == code, f"{words}: exit {done.returncode}\n{done.stdout}{done.stderr}"
    assert code != 2 or done.stderr.count("\n") == 1, f"{words}: not one line\n{done.stderr}"
    return done


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


class WithFolder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
