"""python3 -m slammot.report compare OUTPUT: writes OUTPUT/report.html, and OUTPUT/pooled.json with what the runs say
together, from OUTPUT/compare.json and its run folders.

The page needs nothing but itself: Plotly is carried inside.
"""
from ..pooling.estimators import FORMAT
from ..pooling.json_files import dumped
from . import figures, lags, pooled_verdict, tables, verdict
from .charts import errors, pooled
from .comparison import read_comparison
from .page import embedded_picture, rendered, run_report, write_aside


def pictures_of(output, runs):
    """[(run, [(frame, picture), ...])] of the runs in whose folders `slammot compare --pictures` left some."""
    found = []
    for run in runs:
        files = sorted((output / run.label / "pictures" / "slider").glob("*.jpg"))
        if files:
            found.append((run, [(int(file.stem), embedded_picture(file)) for file in files]))
    return found


def page(output, given):
    comparison = read_comparison(output)
    write_aside(output / "pooled.json", dumped({"format": FORMAT} | comparison.together))
    if given.table:  # on the terminal too
        print(tables.terminal(comparison), flush=True)
    charts = {name: figure for name, figure in (
        ("distribution", pooled.distribution(comparison)),
        ("trajectory", figures.trajectory(comparison)),
        ("position_error", figures.position_error(comparison)),
        ("axis_errors", errors.axis_errors(comparison)),
        ("error_path", errors.error_path(comparison)),
        ("nees", figures.nees(comparison)),
        ("lag", figures.lag(comparison)),
        ("runtime", figures.runtime(comparison))) if figure}
    return rendered("compare.html", "page.js", charts, charts=charts, comparison=comparison,
                    findings=(pooled_verdict if comparison.pooled else verdict).findings(comparison), verdict=verdict, tables=tables, lags=lags, figures=figures,
                    pictures=pictures_of(output, comparison.runs))


def main():
    return run_report("compare_report", page, "compare.json", table={"action": "store_true"})
