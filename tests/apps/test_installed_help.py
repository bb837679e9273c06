"""Man page and bash completion name what the program has.

usage: test_installed_help.py SLAMMOT MAN_PAGE
"""
import pathlib
import re
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "eval"))
from fixture import ROOT, SLAMMOT, program  # noqa: E402

MAN_PAGE = sys.argv.pop(1)
COMMANDS = ["compare", "run", "study", "report", "simulate", "track", "draw", "evaluate", "list"]

COMPLETE = """
source "$0"
compopt() { :; }  # there is no completion going on
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
_slammot "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""


def completed(*words):
    done = subprocess.run(["bash", "-c", COMPLETE, ROOT / "apps/share/slammot.bash", SLAMMOT, *words],
                          capture_output=True, text=True, check=True)
    return done.stdout.split()


class InstalledHelp(unittest.TestCase):
    def test_man_page_has_every_option(self):
        shown = subprocess.run(["man", "--warnings", "-l", MAN_PAGE], capture_output=True, text=True, check=True,
                               env={"MANWIDTH": "1000", "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8"})
        self.assertEqual(shown.stderr, "")
        for command in COMMANDS:
            self.assertIn(f"slammot {command} ", shown.stdout)
            for option in re.findall(r"--[a-z-]+", program(command, "--help").stdout):
                self.assertIn(option, shown.stdout)

    def test_completion(self):
        self.assertEqual(completed("st"), ["study"])
        self.assertLessEqual(set(COMMANDS), set(completed("")))
        self.assertEqual(completed("run", "x", "--estimator", "win"), ["window"])
        self.assertIn("--landmarks", completed("run", "--"))
        self.assertEqual(completed("run", "x", "--set", "window.fr"), ["window.frames="])
        self.assertEqual(completed("simulate", "hel"), ["helix", "helix_unobservable"])
        tables = completed("list", "")
        self.assertLessEqual({"estimators", "landmarks", "points", "motions", "classifiers", "metrics", "scenarios", "readers"}, set(tables))
        for table in tables:
            self.assertNotEqual(program("list", table).stdout, "")
        self.assertEqual(completed("compare", "--landmark", "scaled"), ["scaled_velocity"])


if __name__ == "__main__":
    unittest.main()
