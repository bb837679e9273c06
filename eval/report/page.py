"""What every page shares: the template engine, Plotly carried inside, data that a script reads, and the command line."""
import base64
import gzip
import importlib.util
import json
import pathlib
import sys

from comparison import BadInput

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


def text_of(name):
    return (HERE / name).read_text(encoding="utf-8")


def template(name):
    try:
        import jinja2
    except ImportError as error:
        raise BadInput("jinja2: not found; install python3-jinja2") from error
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(name)


def rendered(name, script, data, **content):
    """The page of a template that extends base.html. The script draws the data; None carries neither."""
    drawn = data is not None
    return template(name).render(
        style=text_of("page.css"), script=text_of(script), data_json=embedded_json(data) if drawn else None,
        plotly=packed(plotly_source()) if drawn else None, **content)


def run_report(name, make):
    """The program `name.py OUTPUT`: the page that `make` returns for the folder goes to OUTPUT/report.html; the exit code."""
    if len(sys.argv) != 2:
        print(f"usage: {name}.py OUTPUT", file=sys.stderr)
        return 2
    output = pathlib.Path(sys.argv[1])
    try:
        (output / "report.html").write_text(make(output), encoding="utf-8")
    except (BadInput, OSError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2
    return 0
