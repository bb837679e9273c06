#!/usr/bin/python3
"""compare_report.py OUTPUT: writes OUTPUT/report.html from OUTPUT/compare.json and its run folders.

The page needs nothing but itself: Plotly is carried inside. Silent on success; one line on stderr and
exit 2 for bad input, 1 for a missing package or a page that cannot be written.
"""
import sys

import figures
import lags
import pictures
import pooled_verdict
import tables
import verdict
from comparison import read_comparison
from page import rendered, run_report


def page(output):
    comparison = read_comparison(output)
    charts = {name: figure for name, figure in (
        ("trajectory", figures.trajectory(comparison)),
        ("position_error", figures.position_error(comparison)),
        ("nees", figures.nees(comparison)),
        ("lag", figures.lag(comparison)),
        ("runtime", figures.runtime(comparison))) if figure}
    return rendered("compare.html", "page.js", charts, charts=charts, comparison=comparison,
                    findings=(pooled_verdict if comparison.pooled else verdict).findings(comparison), verdict=verdict, tables=tables, lags=lags, figures=figures,
                    pictures=pictures.of_runs(output, comparison.runs))


if __name__ == "__main__":
    sys.exit(run_report("compare_report", page, "compare.json"))
