"""Fails on an #include against the arrows: who may know whom (docs/README.md, "Pieces").

Every own header is included by its path from the root, "models/camera.h"; a path relative to the file
would get around the check and is refused too.
"""
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
    "opencv2/": {"frontend"},
}

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


class Layering(unittest.TestCase):
    def test_the_tree_follows_the_arrows(self):
        files = list(sources())
        self.assertTrue(files)
        faults = [fault for path in files
                  for fault in faults_in(path.relative_to(ROOT).as_posix(), path.read_text())]
        self.assertEqual(faults, [], "\n".join(faults))

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
