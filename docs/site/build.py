"""build.py OUTPUT SLAMMOT [--reference DIR]: the site in OUTPUT/html, the target `docs`.

In OUTPUT/source are README.md and docs/ as they are in the tree, so that their links hold; the notebook, which is executed; and as extra
files the C++ reference (DIR, Doxygen's) and a gallery of pages that SLAMMOT writes: those of the tutorial, and a room with pictures. A
warning of Sphinx is an error. The gallery is kept until SLAMMOT changes.
"""
import argparse
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys

import nbformat

ROOT = pathlib.Path(__file__).resolve().parents[2]
GALLERY = [("compare", "compared/report.html", "Filter and smoother on one sequence", "`slammot compare`"),
           ("study", "first/report.html", "Ten sequences: errors, ANEES with its interval, pairs", "`slammot study`"),
           ("judge", "page/report.html", "An estimator in Python, judged beside both families", "`slammot report RUN... --against SEQUENCE`"),
           ("room", "room/report.html", "From images, with a picture of every frame", "`slammot compare --pictures`"),
           ("timeline", "room/window-scaled_velocity/timeline.html", "A run under a slider: image, labels, map, NEES", "`slammot report RUN --timeline`")]
PYTHON = [("slammot", "What most scripts need"), ("slammot.reading", "Files as tables and arrays"),
          ("slammot.program", "Running the program"), ("slammot.estimator", "Estimators in Python"),
          ("slammot.so3", "Rotations")]
CONTENTS = [("Begin", ["docs/tutorial", "docs/results", "docs/consistency-background", "gallery"]),
            ("Method", ["docs/frame", "docs/models", "docs/filter", "docs/labels", "docs/smoother", "docs/decisions", "docs/reproducing"]),
            ("Use", ["docs/images", "docs/recordings", "docs/robustness", "docs/judge", "docs/python", "docs/extending", "docs/formats",
                     "docs/performance", "docs/cluster", "docs/glossary"]),
            ("Reference", ["python_package", "A notebook <notebook>", "cpp", "What it is <README>", "All pages <docs/README>", "CONTRIBUTING", "CHANGELOG"])]


def run(*words, **how):
    subprocess.run([str(word) for word in words], check=True, **how)


def notebook_of(script):
    """Cells begin with `# %%`; text cells with `# %% [markdown]`."""
    cells = []
    for cell in re.split(r"(?m)^# %%", script)[1:]:
        head, _, body = cell.partition("\n")
        if "[markdown]" in head:
            text = re.sub(r"(?m)^# ?", "", body)
            cells.append(nbformat.v4.new_markdown_cell("# " + text.strip().replace("\n", "\n\n", 1)))
        else:
            cells.append(nbformat.v4.new_markdown_cell("## " + head.strip()))
            cells.append(nbformat.v4.new_code_cell(body.strip()))
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"  # the same file each time
    return nbformat.v4.new_notebook(cells=cells, metadata={"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}})


def make_gallery(folder, slammot):
    """Pages of today's program, once for each build of it."""
    digest = hashlib.sha256(slammot.read_bytes()).hexdigest()
    mark = folder / "program.sha256"
    if mark.exists() and mark.read_text(encoding="utf-8") == digest:
        return
    shutil.rmtree(folder, ignore_errors=True)
    run(ROOT / "scripts/tutorial", "--keep", folder, slammot)
    run(slammot, "simulate", "--render", "room", "--set", "frames=40", "--output", folder / "images")
    run(slammot, "track", folder / "images", "--output", folder / "tracked")
    run(slammot, "compare", folder / "tracked", "--landmark", "scaled_velocity", "--pictures", "--output", folder / "room")
    run(slammot, "report", folder / "room/window-scaled_velocity", "--timeline")
    mark.write_text(digest, encoding="utf-8")


def lay_out(source, gallery, reference):
    shutil.rmtree(source, ignore_errors=True)
    (source / "extra").mkdir(parents=True)
    shutil.copy(ROOT / "docs/site/conf.py", source)  # paths in it are from here
    (source / "static").mkdir()
    shutil.copy(ROOT / "docs/site/wide.css", source / "static")
    for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE", "CITATION.cff"):
        shutil.copy(ROOT / name, source / name)
    shutil.copytree(ROOT / "docs", source / "docs", ignore=shutil.ignore_patterns("site"))
    shutil.copy(ROOT / "examples/python/estimators.py", source)
    nbformat.write(notebook_of((ROOT / "examples/python/notebook.py").read_text(encoding="utf-8")), source / "notebook.ipynb")
    index = ["# slammot", "", "Filter or smoother, and can I believe its covariance? Monocular SLAM among moving objects, compared and judged.", "",
             "Start with the [tutorial](docs/tutorial.md), or with [what it is](README.md).", ""]
    for caption, pages in CONTENTS:
        index += ["```{toctree}", f":caption: {caption}", ":maxdepth: 1", "", *pages, "```", ""]
    (source / "index.md").write_text("\n".join(index), encoding="utf-8")
    lines = ["# Gallery", "", "Pages as the program writes them. They need no network.", ""]
    for name, written, title, command in GALLERY:
        page = source / "extra/gallery" / name
        page.mkdir(parents=True)
        shutil.copy(gallery / written, page)
        folder = (gallery / written).parent
        for pictures in folder.glob("*/pictures/slider"):
            shutil.copytree(pictures, page / pictures.relative_to(folder))
        lines.append(f'- <a href="gallery/{name}/{pathlib.Path(written).name}">{title}</a>: {command}')
    (source / "gallery.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    package = ["Python package", "==============", ""]
    for module, title in PYTHON:
        members = [] if module == "slammot" else ["   :members:", "   :undoc-members:"]  # it hands on those of the others
        package += [title, "-" * len(title), "", f".. automodule:: {module}", *members, ""]
    (source / "python_package.rst").write_text("\n".join(package), encoding="utf-8")
    lines = ["# C++ reference", "", "Made by Doxygen from the headers.", ""]
    if reference:
        shutil.copytree(reference, source / "extra/cpp_reference")
        lines += ['<a href="cpp_reference/index.html">Classes, files, namespaces</a>', ""]
    lines += ["The contracts to begin with: `estimation/estimator.h`, `estimation/belief.h`, `estimation/classification.h`,",
              "`models/landmarks/landmark.h`, `models/points/point.h`, `eval/metrics/metric.h`, `apps/app.h`."]
    (source / "cpp.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("slammot", type=pathlib.Path)
    parser.add_argument("--reference", type=pathlib.Path, help="HTML of Doxygen")
    arguments = parser.parse_args()
    output, slammot = arguments.output.absolute(), arguments.slammot.absolute()
    make_gallery(output / "gallery", slammot)
    lay_out(output / "source", output / "gallery", arguments.reference)
    environment = os.environ | {"SLAMMOT": str(slammot), "PYTHONPATH": str(ROOT / "python"), "PYTHONDONTWRITEBYTECODE": "1"}
    run(sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-d", output / "doctrees", output / "source",
        output / "html", env=environment)
    print(output / "html/index.html")


if __name__ == "__main__":
    main()
