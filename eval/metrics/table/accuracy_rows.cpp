// Errors of a trajectory.
#include "eval/metrics/table/row_forms.h"
#include "eval/metrics/table/rows.h"

namespace slammot {
namespace {

Metric coverage_row() {
  return {.key = "coverage",
          .unit = "",
          .name = "coverage",
          .caption = "frames that have a pose, of those of the sequence",
          .value =
              [](const FinishedRun& f) {
                const auto poses = static_cast<double>(f.estimates.size());
                const auto frames = static_cast<double>(f.sequence.frames.size());
                return f.trajectory.accuracy.value ? poses / frames : kUndefined;
              },
          .scope = Scope::kTrajectory,
          .form = Form::kRatio,
          .better = Better::kNeither,
          .block = "accuracy"};
}

// A number of the accuracy, where that is known.
std::function<double(const FinishedRun&)> of_accuracy(
    const std::function<double(const Accuracy&)>& value) {
  return [=](const FinishedRun& f) {
    const auto& accuracy = f.trajectory.accuracy.value;
    return accuracy ? value(*accuracy) : kUndefined;
  };
}

struct PathQuantity {
  const char* leaf;
  const char* unit;
  const char* name;
  const char* caption;
  double DistanceErrors::*value;
};

constexpr PathQuantity kPathQuantities[] = {
    {"percent", "%", "", "mean error of the displacement over ",
     &DistanceErrors::translation_percent},
    {"scaled_percent", "%", ", scaled",
     "mean error of the displacement, at the scale of the similarity alignment, over ",
     &DistanceErrors::scaled_percent},
    {"rotation_deg_per_m", "deg/m", ", rotation", "mean error of the rotation over ",
     &DistanceErrors::rotation_deg_per_m}};

MetricTable path_rows(const std::string& key, const std::string& name, const std::string& lengths,
                      DistanceErrors Accuracy::*errors) {
  MetricTable rows;
  for (const PathQuantity& q : kPathQuantities) {
    rows.push_back({.key = key + "_" + q.leaf,
                    .unit = q.unit,
                    .name = name + q.name,
                    .caption = q.caption + lengths,
                    .value = of_accuracy([=](const Accuracy& a) { return a.*errors.*q.value; }),
                    .scope = Scope::kTrajectory,
                    .decimals = 4,
                    .pooled = Pooled::kNot,
                    .block = "accuracy"});
  }
  return rows;
}

MetricTable scale_along_path_rows() {
  MetricTable rows;
  for (std::size_t k = 0; k < kTenths; ++k) {
    rows.push_back(neither(
        pooled(detail("scale_along_path", "tenth_" + std::to_string(k + 1),
                      "size of the estimate over that of the truth in this tenth of the path",
                      of_accuracy([=](const Accuracy& a) { return a.scale_along_path[k]; }),
                      Scope::kTrajectory),
               Pooled::kNot)));
  }
  return rows;
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
  MetricTable table = {
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
      on_page(
          row("rpe_1s_scaled_position_rmse_m", "m", "RPE 1 s, scaled",
              "RMSE of the displacement in one second, at the scale of the similarity alignment",
              &A::relative_scaled_rmse)),
      pooled(on_page(row("rpe_1s_rotation_rmse_deg", "deg", "RPE 1 s, rotation",
                         "RMSE of the rotation in one second", &A::relative_rotation_rmse_deg)),
             kRms),
  };
  append(table, path_rows("rpe_tenth", "RPE tenth", "a tenth of the path", &A::over_tenths));
  append(table, path_rows("rpe_kitti", "RPE KITTI", "100 to 800 m, as KITTI's benchmark has it",
                          &A::over_kitti));
  append(table, scale_along_path_rows());
  return table;
}

}  // namespace slammot
