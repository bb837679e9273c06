"""slammot's trajectory errors against those of evo, recorded in evo/figures.json with their commands; ten foreign trajectories
against plain numpy and the formulas of ov_eval (bench/foreign.py), as results/judge/table.md has them.

usage: test_evo.py SLAMMOT
"""
import json
import pathlib
import sys
import unittest

from fixture import ROOT, SLAMMOT, WithFolder, program

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE / "evo"), str(ROOT / "bench")]
import foreign  # noqa: E402
import trajectories  # noqa: E402

TOLERANCE = 1e-11  # relative


def write_sequence(folder, truth):
    """Of a camera that sees one point."""
    folder.mkdir()
    times = [line.split()[0] for line in truth.read_text().splitlines()]
    (folder / "sequence.yaml").write_text(
        "format: slammot-sequence-1\nname: evo\npixel_sigma: 1\n"
        "camera: {model: pinhole, width: 640, height: 480, fx: 400, fy: 400, cx: 320, cy: 240}\n")
    (folder / "frames.csv").write_text("frame,timestamp\n" + "".join(f"{i},{t}\n" for i, t in enumerate(times)))
    (folder / "observations.csv").write_text("frame,track,u,v\n" + "".join(f"{i},0,320,240\n" for i in range(len(times))))
    (folder / "groundtruth.tum").write_bytes(truth.read_bytes())


class Evo(WithFolder):
    def test_every_figure(self):
        recorded = json.loads((HERE / "evo" / "figures.json").read_text())["figures"]
        self.assertEqual(set(recorded), set(trajectories.CASES))
        trajectories.write(self.folder)
        for name, figures in recorded.items():
            folder = self.folder / name
            write_sequence(folder / "sequence", folder / "truth.tum")
            program("evaluate", folder / "estimate.tum", "--against", folder / "sequence", "--json", folder / "metrics.json", *trajectories.CASES[name][2])
            ours, = json.loads((folder / "metrics.json").read_text()).values()
            for key, figure in figures.items():
                with self.subTest(trajectory=name, command=figure["command"]):
                    self.assertLess(abs(ours["filtered"]["accuracy"][key] / figure["rmse"] - 1), TOLERANCE)

    def test_ten_foreign_trajectories(self):
        rows = (ROOT / "results" / "judge" / "table.md").read_text().splitlines()
        cases = foreign.cases()
        self.assertEqual(len(cases), 10)
        for case in cases:
            ours, truth = foreign.by_judge(SLAMMOT, case, self.folder / case.name), foreign.truth_of(case)
            for others in (foreign.by_numpy(case, truth), foreign.by_ov_eval(case, truth)):
                for key, value in others.items():
                    self.assertLess(abs(ours[key] / value - 1), TOLERANCE, f"{case.name} {key}")
            recorded = next(row for row in rows if row.startswith(f"| {case.name} |")).split(" | ")
            self.assertIn(f"{ours['position_rmse_m']:.4g}", recorded)
            self.assertNotEqual(recorded[-2], "-")  # evo's


if __name__ == "__main__":
    unittest.main()
