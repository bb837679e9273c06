# %% [markdown]
# A filter in Python beside the EKF
# One sequence, then a study with intervals.
# Cells are marked for editors that run them one by one; as a script it takes the output folder:
#
#     PYTHONPATH=python python3 examples/python/notebook.py out

# %% One sequence
import pathlib
import sys

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
    figures = slammot.evaluate(run.trajectory, run.covariance, sequence.truth).figures  # of arrays of any estimator
    print(f"{name}: position RMSE {figures['position_rmse_m']:.4f} m, mean NEES {figures['nees.position.mean']:.2f} (3)")

# %% A study: the same seeds for both, two levels of noise
(output / "study.yaml").write_text(f"""\
format: slammot-study-1
name: notebook
runs: 5
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

# %% Runs of one seed saw the same measurements: paired differences, mine - ekf, with their 95% intervals
for noise, group in runs.groupby("scenario.noise"):
    mine_runs, ekf_runs = (group[group["label"] == label].set_index("seed") for label in ("mine", "ekf"))
    columns = ["filtered_position_rmse_m", "filtered_rotation_rmse_deg"]
    print(f"noise {noise} px\n{slammot.compare(mine_runs[columns], ekf_runs[columns]).round(5).to_string()}")
