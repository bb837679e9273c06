"""slammot's trajectory errors against those of evo, recorded in evo/figures.json with their commands.

usage: test_evo.py SLAMMOT
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "evo"))
import trajectories  # noqa: E402

SLAMMOT = ""
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


class Evo(unittest.TestCase):
    def test_every_figure(self):
        recorded = json.loads((HERE / "evo" / "figures.json").read_text())["figures"]
        self.assertEqual(set(recorded), set(trajectories.CASES))
        worst = 0.0
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            trajectories.write(folder)
            for name, figures in recorded.items():
                write_sequence(folder / name / "sequence", folder / name / "truth.tum")
                subprocess.run([SLAMMOT, "evaluate", folder / name / "estimate.tum", "--against", folder / name / "sequence",
                                "--json", folder / f"{name}.json", *trajectories.CASES[name][2]], check=True, capture_output=True)
                ours, = json.loads((folder / f"{name}.json").read_text()).values()
                for key, figure in figures.items():
                    with self.subTest(trajectory=name, command=figure["command"]):
                        difference = abs(ours["filtered"]["accuracy"][key] / figure["rmse"] - 1)
                        worst = max(worst, difference)
                        self.assertLess(difference, TOLERANCE)
        print(f"largest relative difference from evo: {worst:.1e}", file=sys.stderr)


if __name__ == "__main__":
    SLAMMOT = sys.argv.pop(1)
    unittest.main()
