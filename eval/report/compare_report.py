#!/usr/bin/python3
"""compare_report.py OUTPUT: writes OUTPUT/report.html from OUTPUT/compare.json and its run folders.

The page needs nothing but itself: Plotly is carried inside. Silent on success; exit 2 and one line on
stderr for bad input, a missing package or a page that cannot be written.
"""
import base64
import gzip
import importlib.util
import json
import pathlib
import sys

import figures
import tables
import verdict
from comparison import BadInput, read_comparison

HERE = pathlib.Path(__file__).resolve().parent


def plotly_source():
    """Plotly's JavaScript as Debian's python3-plotly ships it, or as the wheel does."""
    candidates = [pathlib.Path("/usr/share/python3-plotly/plotly.js")]
    found = importlib.util.find_spec("plotly")
    if found and found.origin:
        candidates.append(pathlib.Path(found.origin).parent / "package_data" / "plotly.min.js")
    for path in candidates:
        if path.is_file():
            return path.read_bytes()
    raise BadInput("plotly.js: not found; install python3-plotly")


def packed(source):
    """Compressed, as text: a third of the size, and the same bytes every time."""
    return base64.b64encode(gzip.compress(source, 9, mtime=0)).decode("ascii")


def embedded_json(value):
    """JSON that no `</script>` inside can end."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")


def page(comparison):
    try:
        import jinja2
    except ImportError as error:
        raise BadInput("jinja2: not found; install python3-jinja2") from error
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True)
    charts = {name: figure for name, figure in (
        ("trajectory", figures.trajectory(comparison)),
        ("position_error", figures.position_error(comparison)),
        ("nees", figures.nees(comparison)),
        ("runtime", figures.runtime(comparison))) if figure}
    return environment.get_template("compare.html").render(
        comparison=comparison, charts=charts, charts_json=embedded_json(charts),
        findings=verdict.findings(comparison), verdict=verdict, tables=tables, plotly=packed(plotly_source()),
        style=(HERE / "page.css").read_text(encoding="utf-8"),
        script=(HERE / "page.js").read_text(encoding="utf-8"))


def main(arguments):
    if len(arguments) != 1:
        print("usage: compare_report.py OUTPUT", file=sys.stderr)
        return 2
    output = pathlib.Path(arguments[0])
    try:
        (output / "report.html").write_text(page(read_comparison(output)), encoding="utf-8")
    except (BadInput, OSError) as error:
        print(f"compare_report: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
