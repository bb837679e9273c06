"""The man page, from what the program says of itself: man_page.py SLAMMOT OUTPUT."""
import pathlib
import re
import subprocess
import sys

EXIT = """.SH EXIT STATUS
0 done; 1 the run failed, and what was finished is kept; 2 bad usage or bad input.
.SH ENVIRONMENT
.TP
SLAMMOT_PYTHON
the Python of reports and of estimators written in Python (/usr/bin/python3)
.TP
SLAMMOT_SHARE
PREFIX/share/slammot of an installation, where the Python package is not found beside the program
"""


def said(program, *words):
    return subprocess.run([program, *words], capture_output=True, text=True, check=True).stdout


def roff(text):
    """Text in which nothing is taken for a request."""
    return re.sub(r"(?m)^([.'])", r"\\&\1", text.replace("\\", r"\e").replace("-", r"\-"))


def page(program):
    version = said(program, "--version").split()[1]
    overview = said(program, "--help")
    commands = re.findall(r"(?m)^  ([a-z]+) ", overview[overview.index("Subcommands:"):])
    parts = [f".TH SLAMMOT 1 \"\" \"slammot {version}\"\n.SH NAME\nslammot \\- filter or smoother? monocular SLAM with moving "
             f"objects, compared and judged\n.SH SYNOPSIS\n.nf\n{roff(overview)}.fi\n"]
    for command in commands:
        parts.append(f".SH SLAMMOT {command.upper()}\n.nf\n{roff(said(program, command, '--help'))}.fi\n")
    return "".join(parts) + EXIT


if __name__ == "__main__":
    pathlib.Path(sys.argv[2]).write_text(page(sys.argv[1]), encoding="utf-8")
