# %% [markdown]
# A filter in Python beside the EKF
# One sequence, then a study with intervals.
# Cells are marked for editors that run them one by one; as a script it takes the output folder:
#
#     PYTHONPATH=python python3 examples/python/notebook.py out

# %% One sequence
import pathlib
import sys

import numpy as np
import slammot

here = pathlib.Path(__file__).parent if "__file__" in globals() else pathlib.Path()  # a notebook has no file
arguments = [] if "ipykernel" in sys.modules else sys.argv[1:]
output = pathlib.Path(arguments[0] if arguments else "slammot-out/notebook")
mine = f"python:{here / 'estimators.py'}:KnownPoints"
sequence = slammot.simulate("helix", seed=1, output=output / "sequence", force=True, frames=80)
print(f"{sequence.name}: {len(sequence.frames)} frames, {len(sequence.known)} known landmarks")

# %% Both estimators on it, and the error of each position against the truth
for estimator, name in (("ekf", "ekf"), (mine, "mine")):
    run = slammot.run(output / "sequence", estimator, output / name, force=True)
    error = (run.trajectory - sequence.truth)[["x", "y", "z"]].to_numpy()
    inverses = np.linalg.inv(run.covariance[1:, :3, :3])  # not of the first frame, which is given
    nees = np.einsum("ni,nij,nj->n", error[1:], inverses, error[1:])
    print(f"{name}: position RMSE {np.sqrt((error ** 2).sum(axis=1).mean()):.4f} m, mean NEES {nees.mean():.2f} (3)")

# %% A study: the same seeds for both, two levels of noise
(output / "study.yaml").write_text(f"""\
format: slammot-study-1
name: notebook
runs: 4
scenarios: [{{scenario: helix, set: {{frames: 40}}}}]
estimators:
  - {{estimator: ekf}}
  - {{estimator: "{mine}", label: mine}}
sweep: {{scenario.noise: [0.5, 2]}}
""", encoding="utf-8")
slammot.slammot("study", output / "study.yaml", "--output", output / "study", "--resume")
runs = slammot.read_study(output / "study")

# %% The table of runs is tidy: a row per run, numbers as numbers
table = runs.groupby(["scenario.noise", "label"])[["filtered_position_rmse_m", "filtered_nees_pose"]]
print(table.agg(["mean", "sem"]).round(4).to_string())

# %% Runs of one seed saw the same measurements: paired differences
pairs = runs.pivot(index=["scenario.noise", "seed"], columns="label", values="filtered_position_rmse_m")
difference = (pairs["mine"] - pairs["ekf"]).groupby("scenario.noise")
print(difference.agg(["mean", "sem", "count"]).round(5).to_string())
