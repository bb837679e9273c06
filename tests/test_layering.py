"""Fails on an #include against the arrows: who may know whom (docs/README.md, "Pieces"); on a cycle of includes among the
sub-folders of a folder; and on a folder with too many files.

Every own header is included by its path from the root, "models/camera.h"; a path relative to the file
would get around the check and is refused too.
"""
import collections
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent

MAY_KNOW = {
    "models": {"models"},
    "estimation": {"estimation", "models"},
    "filters": {"filters", "estimation", "models"},
    "smoothers": {"smoothers", "estimation", "models"},
    "datasets": {"datasets", "models"},
    "frontend": {"frontend", "datasets", "estimation", "models"},
    "codecs": {"codecs", "frontend"},
    "eval": {"eval", "datasets", "estimation", "models"},
    "apps": {"apps", "eval", "frontend", "datasets", "estimation", "models"},
}

# The one place that maps names to estimators, and the one that parses their options.
EXCEPTIONS = {
    "eval/configuration/registry.cpp": re.compile(r"(filters|smoothers)/[\w/]+\.h"),
    "eval/configuration/configuration.h": re.compile(
        r"filters/ekf_options\.h|smoothers/window/window_options\.h"),
}

# Libraries that only some folders may know.
LIBRARIES = {
    "ceres/": {"smoothers"},
    "opencv2/": {"frontend", "codecs"},
}

MOST_FILES = 20  # .h, .cpp and .py of one folder

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)


def faults_in(path, text):
    """The includes of the file at `path` (relative to the root) that point against the arrows."""
    folder = path.split("/")[0]
    faults = []
    for bracket, header in INCLUDE.findall(text):
        if bracket == '"':
            exception = EXCEPTIONS.get(path)
            allowed = header.split("/")[0] in MAY_KNOW[folder] or (
                exception is not None and exception.fullmatch(header) is not None)
        else:
            allowed = header.split("/")[0] not in MAY_KNOW and all(
                folder in users for library, users in LIBRARIES.items()
                if header.startswith(library))
        if not allowed:
            faults.append(f"{path} includes {header}")
    return faults


def sources():
    for folder in MAY_KNOW:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in {".h", ".cpp"}:
                yield path


def folder_of(path):
    return path.rsplit("/", 1)[0]


def arrows_of(files):
    """Folder to the other folders of the same top-level folder that its files include; files: path to text."""
    arrows = {}
    for path, text in files.items():
        for bracket, header in INCLUDE.findall(text):
            if bracket != '"' or header.split("/")[0] != path.split("/")[0]:
                continue
            if folder_of(header) != folder_of(path):
                arrows.setdefault(folder_of(path), set()).add(folder_of(header))
    return arrows


def cycle_in(arrows):
    """The folders of a cycle in their order, or nothing."""
    done = set()

    def walk(folder, path):
        if folder in path:
            return path[path.index(folder):] + [folder]
        if folder in done:
            return []
        for other in sorted(arrows.get(folder, ())):
            found = walk(other, path + [folder])
            if found:
                return found
        done.add(folder)
        return []

    return next(filter(None, (walk(folder, []) for folder in sorted(arrows))), [])


def crowded(paths):
    """The folders that hold too many of these files, with their number."""
    counts = collections.Counter(map(folder_of, paths))
    return {folder: count for folder, count in counts.items() if count > MOST_FILES}


class Layering(unittest.TestCase):
    def test_the_tree_follows_the_arrows(self):
        files = list(sources())
        self.assertTrue(files)
        faults = [fault for path in files
                  for fault in faults_in(path.relative_to(ROOT).as_posix(), path.read_text())]
        self.assertEqual(faults, [], "\n".join(faults))

    def test_no_cycle_among_subfolders(self):
        files = {path.relative_to(ROOT).as_posix(): path.read_text() for path in sources()}
        for top in MAY_KNOW:
            mine = {path: text for path, text in files.items() if path.startswith(top + "/")}
            with self.subTest(folder=top):
                self.assertEqual(cycle_in(arrows_of(mine)), [])

    def test_a_cycle_is_found(self):
        files = {"eval/run/run.h": '#include "eval/result/run_result.h"\n', "eval/result/writer.cpp": '#include "eval/metrics/m.h"\n',
                 "eval/metrics/m.h": '#include "eval/run/run.h"\n'}
        self.assertEqual(len(cycle_in(arrows_of(files))), 4)
        del files["eval/metrics/m.h"]
        self.assertEqual(cycle_in(arrows_of(files)), [])

    def test_no_folder_is_crowded(self):
        tops = [*MAY_KNOW, "tests", "bench"]
        paths = [path.relative_to(ROOT).as_posix() for top in tops for path in (ROOT / top).rglob("*")
                 if path.suffix in {".h", ".cpp", ".py"}]
        self.assertEqual(crowded(paths), {})
        self.assertEqual(crowded([f"eval/x/{i}.h" for i in range(21)]), {"eval/x": 21})

    def test_bad_includes_are_found(self):
        for path, line in [
            ("models/camera.h", '#include "filters/ekf.h"'),
            ("filters/ekf.cpp", '#include "smoothers/window.h"'),
            ("smoothers/window.cpp", '  #  include <filters/ekf.h>'),
            ("datasets/sequence.h", '#include "eval/metrics.h"'),
            ("eval/metrics.h", '#include "filters/ekf.h"'),
            ("eval/configuration.h", '#include "filters/ekf.h"'),
            ("apps/main.cpp", '#include "smoothers/window.h"'),
            ("filters/ekf.cpp", '#include "../smoothers/window.h"'),
            ("filters/ekf.cpp", '#include <ceres/ceres.h>'),
            ("models/camera.cpp", '#include <opencv2/core.hpp>'),
            ("datasets/reader.cpp", '#include <opencv2/core.hpp>'),
            ("eval/metrics.h", '#include "frontend/tracker.h"'),
        ]:
            with self.subTest(path=path, line=line):
                self.assertEqual(len(faults_in(path, f"#pragma once\n{line}\n")), 1)

    def test_good_includes_pass(self):
        for path, line in [
            ("models/camera.h", '#include "models/lens.h"'),
            ("models/camera.h", "#include <vector>"),
            ("smoothers/window.cpp", "#include <ceres/problem.h>"),
            ("eval/configuration/registry.cpp", '#include "filters/ekf.h"'),
            ("eval/configuration/configuration.h", '#include "smoothers/window/window_options.h"'),
        ]:
            with self.subTest(path=path, line=line):
                self.assertEqual(faults_in(path, line), [])


if __name__ == "__main__":
    unittest.main()
