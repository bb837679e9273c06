// What later measurements buy.
#include "eval/metrics/table/row_forms.h"
#include "eval/metrics/table/rows.h"

namespace slammot {
namespace {

// What later measurements buy: the pose of so many frames ago, as it is believed now.
struct LagQuantity {
  const char* leaf;
  const char* ratio;
  const char* caption;
  Pooled how;
  double (*value)(const TrajectoryMetrics&);
};

constexpr LagQuantity kLagQuantities[] = {
    {"position_rmse_m", "position_rmse_ratio", "RMSE of the position [m]", Pooled::kRootMeanSquare,
     [](const TrajectoryMetrics& t) {
       return t.accuracy.value ? t.accuracy.value->position_rmse : kUndefined;
     }},
    {"rotation_rmse_deg", "rotation_rmse_ratio", "RMSE of the rotation [deg]",
     Pooled::kRootMeanSquare,
     [](const TrajectoryMetrics& t) {
       return t.accuracy.value ? t.accuracy.value->rotation_rmse_deg : kUndefined;
     }},
    {"nees_pose", "nees_pose_ratio", "mean pose NEES", Pooled::kMean,
     [](const TrajectoryMetrics& t) {
       return t.consistency.value ? t.consistency.value->pose.mean : kUndefined;
     }}};

double at_lag(const FinishedRun& f, int lag, const LagQuantity& quantity) {
  const auto found = f.metrics.lagged.find(lag);
  return found == f.metrics.lagged.end() ? kUndefined : quantity.value(found->second);
}

// Of one run: paired, so that in the mean over runs no bad one hides what the others gain.
double over_filtered(const FinishedRun& f, int lag, const LagQuantity& quantity) {
  const double filtered = at_lag(f, 0, quantity);
  return filtered > 0.0 ? at_lag(f, lag, quantity) / filtered : kUndefined;
}

}  // namespace

MetricTable lag_rows() {
  MetricTable rows;
  const auto add = [&](int lag, const char* leaf, const std::string& caption, Pooled how,
                       std::function<double(const FinishedRun&)> value) {
    const std::string frames =
        lag == 1 ? " one frame later" : " " + std::to_string(lag) + " frames later";
    rows.push_back(pooled(
        detail("lag." + std::to_string(lag), leaf, caption + frames, std::move(value)), how));
  };
  const auto add_all = [&](int lag) {
    for (const LagQuantity& q : kLagQuantities) {
      add(lag, q.leaf, q.caption, q.how, [=](const FinishedRun& f) { return at_lag(f, lag, q); });
    }
  };
  add_all(0);
  for (const int lag : kLags) {
    add_all(lag);
    for (const LagQuantity& q : kLagQuantities) {
      add(lag, q.ratio, std::string(q.caption) + " over that as filtered,", Pooled::kMean,
          [=](const FinishedRun& f) { return over_filtered(f, lag, q); });
    }
  }
  return rows;
}

}  // namespace slammot
