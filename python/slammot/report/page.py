"""What every page shares: the template engine, Plotly carried inside, data that a script reads, and the command line."""
import argparse
import base64
import contextlib
import gzip
import importlib.util
import json
import os
import pathlib
import sys

from .comparison import BadInput, NotMade

TEMPLATES = pathlib.Path(__file__).resolve().parent / "templates"
GENERATOR = '<meta name="generator" content="slammot">'  # of base.html


def plotly_source():
    """Plotly's JavaScript as Debian's python3-plotly ships it, or as the wheel does."""
    candidates = [pathlib.Path("/usr/share/python3-plotly/plotly.js")]
    found = importlib.util.find_spec("plotly")
    if found and found.origin:
        candidates.append(pathlib.Path(found.origin).parent / "package_data" / "plotly.min.js")
    for path in candidates:
        if path.is_file():
            return path.read_bytes()
    raise NotMade("plotly.js: not found; install python3-plotly")


def packed(source):
    """Compressed, as text: a third of the size, and the same bytes every time. Level 9 saves 1% and takes three times as long."""
    return base64.b64encode(gzip.compress(source, 6, mtime=0)).decode("ascii")


def embedded_picture(file):
    """A picture's file, carried inside the page."""
    kind = {".svg": "svg+xml", ".jpg": "jpeg"}[file.suffix]
    return f"data:image/{kind};base64," + base64.b64encode(file.read_bytes()).decode("ascii")


def embedded_json(value):
    """JSON that no `</script>` inside can end."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")


def text_of(name):
    return (TEMPLATES / name).read_text(encoding="utf-8")


def template(name):
    try:
        import jinja2
    except ImportError as error:
        raise NotMade("jinja2: not found; install python3-jinja2") from error
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(name)


def rendered(name, script, data, with_plotly=True, **content):
    """The page of a template that extends base.html. The script draws the data, with Plotly if it asks for it; None carries neither."""
    drawn = data is not None
    return template(name).render(
        style=text_of("page.css"), script=text_of(script), data_json=embedded_json(data) if drawn else None,
        plotly=packed(plotly_source()) if drawn and with_plotly else None, **content)


@contextlib.contextmanager
def aside(path):
    """A path to write to, for a file that is there whole or not at all."""
    unfinished = path.with_name(f"{path.stem}.{os.getpid()}.unfinished{path.suffix}")
    try:
        yield unfinished
        os.replace(unfinished, path)
    except OSError as error:
        raise NotMade(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        with contextlib.suppress(OSError):
            unfinished.unlink()


def write_aside(path, text):
    with aside(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def require_own(report):
    """Only a page of this program's is replaced."""
    if report.exists() and not (report.is_file() and GENERATOR in report.read_text(encoding="utf-8", errors="replace")[:1000]):
        raise BadInput(f"{report}: was not written by slammot: it is not replaced")


def one_line(error):
    """Of unknown origin, for the terminal."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in str(error))[:2000]


def made(make, output, source):
    """What `make` makes of a folder. What it cannot make anything of is no fault of its own: the file may be anybody's."""
    try:
        return make(output)
    except (BadInput, NotMade, OSError):
        raise
    except Exception as error:  # of whatever kind: shapes are not looked at beforehand
        raise BadInput(f"{output / source}: is not as slammot writes it ({type(error).__name__}: {error})") from error


def run_report(name, make, source, product="report.html", **options):
    """The program `name OUTPUT`: the page that `make(output, given)` makes of OUTPUT/`source` goes to OUTPUT/`product`;
    the exit code. `options` are flags by name, with what argparse wants to know of each."""
    parser = argparse.ArgumentParser(prog=name)
    parser.add_argument("output", type=pathlib.Path)
    for option, how in options.items():
        parser.add_argument(f"--{option}", **how)
    given = parser.parse_args()
    try:
        require_own(given.output / product)
        write_aside(given.output / product, made(lambda output: make(output, given), given.output, source))
    except (BadInput, NotMade, OSError) as error:
        print(f"{name}: {one_line(error)}", file=sys.stderr)
        return 2 if isinstance(error, BadInput) else 1
    return 0
