"""How the page of a study is laid out, and the distributions on it, on made-up tables and runs."""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
from slammot.report import study_axes, study_tables  # noqa: E402
from slammot.report.charts import distributions  # noqa: E402
from slammot.report.study_tables import Table  # noqa: E402

CELLS = [{"label": label, "kind": kind} for label, kind in (("ekf", "filter"), ("window", "smoother"), ("batch", "batch"), ("ideal", "ideal_covariance"))]
SUMMARY = {"groups": [{"name": "room", "cells": CELLS}]}


def row(label, error, nees=6.0, **more):
    return {"group": "room", "label": label, "diverged": "0", "failed": "0", "filtered_position_rmse_m": str(error), "smoothed_position_rmse_m": str(error / 2),
            "filtered_nees_pose": str(nees), "smoothed_nees_pose": "", "filtered_ate_sim3_m": str(10 * error)} | more


RUNS = [row("ekf", 0.1 * i, nees=i) for i in range(1, 8)] + [row("window", 0.1), row("window", 0.3, failed="1"), row("window", 99.0, diverged="1"), row("batch", 0.4)]


class Tables(unittest.TestCase):
    def wide(self, columns):
        rows = [[group, label] + [f"0.{i:04} [0.0010, 0.0200]" for i in range(columns)] for group in ("circle", "room") for label in ("ekf", "window")]
        return Table("Metrics", "", ["scenario", "estimator"] + [f"smoothed: error {i} [m]" for i in range(columns)], rows, {(1, 2): "over", (3, columns + 1): "under"})

    def test_a_wide_table_is_several_that_fit(self):
        table = self.wide(20)
        parts = table.parts(study_tables.PAGE)
        self.assertGreater(len(parts), 1)
        for part in parts:
            self.assertEqual(part.head[:2], ["scenario", "estimator"])
            self.assertEqual([texts[:2] for texts in part.rows], [texts[:2] for texts in table.rows])
            self.assertLess(sum(study_tables.column_width(head, [texts[i] for texts in part.rows]) for i, head in enumerate(part.head)), study_tables.PAGE)
        self.assertEqual([head for part in parts for head in part.head[2:]], table.head[2:])
        self.assertEqual([[text for part in parts for text in part.rows[i][2:]] for i in range(4)], [texts[2:] for texts in table.rows])
        lengths = [len(part.head) for part in parts]
        self.assertLessEqual(max(lengths) - min(lengths), 3, "no part with the one column that was left")

    def test_colours_stay_with_their_cells(self):
        first, *_, last = self.wide(20).parts(study_tables.PAGE)
        self.assertEqual(first.classes, {(1, 2): "over"})
        self.assertEqual(last.classes, {(3, len(last.head) - 1): "under"})

    def test_a_narrow_table_is_left_alone(self):
        table = self.wide(3)
        self.assertEqual(table.parts(study_tables.PAGE), [table])
        self.assertEqual(len(table.parts(10)), 3)  # a column in each, however little room there is

    def test_the_rest_of_a_long_caption_opens(self):
        short, long = "Over all runs. Of a batch, smoothed.", "Over all runs. " + 20 * "It is explained, in a sentence of v.1.2. "
        self.assertEqual(study_tables.opening(short), (short, ""))
        first, rest = study_tables.opening(long.strip())
        self.assertTrue(first.startswith("Over all runs. It") and first.endswith("."))
        self.assertLess(len(first), 201)
        self.assertEqual(f"{first} {rest}", long.strip())


class Distributions(unittest.TestCase):
    def test_runs_are_judged_as_elsewhere_and_those_that_diverged_are_left_out(self):
        group, (ekf, window, batch, _) = SUMMARY["groups"][0], CELLS
        self.assertEqual(distributions.values_of(RUNS, group, window, "error"), [(0.1, False), (0.3, True)])
        self.assertEqual(distributions.values_of(RUNS, group, batch, "error"), [(0.2, False)])
        self.assertEqual(distributions.values_of(RUNS, group, batch, "nees"), [])
        self.assertEqual(distributions.values_of(RUNS, group, {**ekf, "aligned": True}, "error")[0], (1.0, False))
        self.assertEqual(distributions.values_of(RUNS, {"name": "circle"}, ekf, "error"), [])

    def drawn(self):
        plt = study_axes.pyplot()
        figure, _ = distributions.draw(plt, SUMMARY, RUNS)
        self.addCleanup(plt.close, figure)
        return figure.axes

    def test_every_run_is_a_point_beside_its_box(self):
        errors, nees = self.drawn()
        self.assertEqual([text.get_text() for text in errors.get_yticklabels()], ["ekf", "window", "batch"])
        marked = {marker: sorted(float(x) for line in errors.lines if line.get_marker() == marker for x in line.get_xdata()) for marker in ".x"}
        self.assertEqual([round(x, 9) for x in marked["."]], sorted([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.1, 0.2]))
        self.assertEqual(marked["x"], [0.3])  # it failed
        medians = [line for line in nees.lines if line.get_linewidth() == 1.8]
        self.assertEqual([list(line.get_xdata()) for line in medians], [[4.0, 4.0]])  # of seven runs; two and one make no box

    def test_one_run_of_each_has_no_distribution(self):
        self.assertIsNone(distributions.draw(None, SUMMARY, [row("ekf", 0.1), row("window", 0.2)]))

    def test_wide_ones_are_logarithmic(self):
        self.assertEqual(distributions.scale_of([0.1, 0.9]), {})
        self.assertEqual(distributions.scale_of([0.1, 1.1]), {"xscale": "log"})
        self.assertEqual(distributions.scale_of([0.0, 5.0]), {})


class Ticks(unittest.TestCase):
    def texts(self, low, high):
        plt = study_axes.pyplot()
        figure, axis = plt.subplots()
        self.addCleanup(plt.close, figure)
        axis.plot([0, 1], [low, high])
        axis.margins(0)
        study_axes.explain(axis, yscale="log", ylim=(low, high))
        figure.canvas.draw()
        return [text.get_text() for text in axis.get_yticklabels() if low <= text.get_position()[1] <= high]

    def test_logarithmic_axes_have_plain_numbers(self):
        self.assertEqual(self.texts(0.15, 30), ["0.2", "0.5", "1", "2", "5", "10", "20"])
        self.assertEqual(self.texts(0.5, 2e6), ["1", "10", "100", "1000", "10000", "100000", "1000000"])
        self.assertIn("10^{8}", " ".join(self.texts(1, 1e12)))


if __name__ == "__main__":
    unittest.main()
