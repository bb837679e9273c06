"""python3 -m slammot.report compare|study|frame|timeline PATH: the pages and figures that the program asks for.

Silent on success; one line on stderr and exit 2 for bad input, 1 for a missing package or a file that cannot be written.
"""
import importlib
import sys

PROGRAMS = {"compare": "compare_report", "study": "study_report", "frame": "frame_figure", "timeline": "timeline"}


def main():
    name = sys.argv.pop(1) if len(sys.argv) > 1 else ""
    if name not in PROGRAMS:
        print(f"usage: python3 -m slammot.report {'|'.join(PROGRAMS)} PATH", file=sys.stderr)
        return 2
    try:
        program = importlib.import_module(f"slammot.report.{PROGRAMS[name]}")
    except ImportError as error:
        print(f"{PROGRAMS[name]}: {error.name}: not found; install python3-{error.name}", file=sys.stderr)
        return 1
    return program.main()


if __name__ == "__main__":
    sys.exit(main())
