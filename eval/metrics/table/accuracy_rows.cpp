// Errors of a trajectory.
#include "eval/metrics/table/row_forms.h"
#include "eval/metrics/table/rows.h"

namespace slammot {
namespace {

Metric coverage_row() {
  return {.key = "coverage",
          .unit = "",
          .name = "coverage",
          .caption = "poses judged, of the frames of the sequence",
          .value =
              [](const FinishedRun& f) {
                const auto& accuracy = f.trajectory.accuracy.value;
                const auto frames = static_cast<double>(f.sequence.frames.size());
                return accuracy ? accuracy->poses / frames : kUndefined;
              },
          .scope = Scope::kTrajectory,
          .form = Form::kRatio,
          .better = Better::kNeither,
          .block = "accuracy"};
}

}  // namespace

MetricTable accuracy_rows() {
  const auto row = [](const char* key, const char* unit, const char* name, const char* caption,
                      auto member) {
    const auto value = [=](const FinishedRun& f) {
      const auto& accuracy = f.trajectory.accuracy.value;
      return accuracy ? number(member, *accuracy) : kUndefined;
    };
    return Metric{.key = key,
                  .unit = unit,
                  .name = name,
                  .caption = caption,
                  .value = value,
                  .scope = Scope::kTrajectory,
                  .decimals = 4,
                  .pooled = Pooled::kNot,
                  .block = "accuracy"};
  };
  using A = Accuracy;
  constexpr Pooled kRms = Pooled::kRootMeanSquare;
  return {
      on_terminal(coverage_row()),
      count(row("poses", "", "poses", "poses with a true pose near in time", &A::poses)),
      pooled(on_terminal(row(kPositionRmse, "m", "position RMSE",
                             "RMSE of the position, without alignment", &A::position_rmse)),
             kRms),
      row("position_max_m", "m", "largest error", "largest position error", &A::position_max),
      pooled(on_page(row("position_final_m", "m", "final error", "position error of the last pose",
                         &A::position_final)),
             Pooled::kMean),
      pooled(on_terminal(row("rotation_rmse_deg", "deg", "rotation RMSE",
                             "RMSE of the orientation, without alignment", &A::rotation_rmse_deg)),
             kRms),
      row("rotation_max_deg", "deg", "largest rotation error", "largest orientation error",
          &A::rotation_max_deg),
      pooled(on_terminal(row("ate_se3_m", "m", "ATE SE(3)",
                             "RMSE of the position after rigid alignment", &A::ate_se3)),
             kRms),
      pooled(on_terminal(row(kAteSim3, "m", "ATE Sim(3)",
                             "RMSE of the position after similarity alignment", &A::ate_sim3)),
             kRms),
      pooled(on_terminal(
                 neither(row("sim3_scale", "", "scale",
                             "true over estimated size, of the similarity alignment", &A::scale))),
             Pooled::kMean),
      count(row("rpe_1s_pairs", "", "RPE pairs", "pairs of poses one second apart",
                &A::relative_pairs)),
      pooled(on_terminal(row("rpe_1s_position_rmse_m", "m", "RPE 1 s",
                             "RMSE of the displacement in one second", &A::relative_position_rmse)),
             kRms),
      pooled(on_page(row("rpe_1s_rotation_rmse_deg", "deg", "RPE 1 s, rotation",
                         "RMSE of the rotation in one second", &A::relative_rotation_rmse_deg)),
             kRms),
  };
}

}  // namespace slammot
