// NEES of poses and landmarks, and the errors of landmarks.
#include "eval/metrics/table/row_forms.h"
#include "eval/metrics/table/rows.h"

namespace slammot {
namespace {

using Pick = std::function<const NeesSummary*(const FinishedRun&)>;

MetricTable nees_rows(const std::string& block, Scope scope, const Pick& summary) {
  const auto row = [&](const char* leaf, const char* caption, auto member) {
    const auto value = [=](const FinishedRun& f) {
      const NeesSummary* s = summary(f);
      return s == nullptr ? kUndefined : number(member, *s);
    };
    return detail(block, leaf, caption, value, scope);
  };
  using S = NeesSummary;
  return {count(row("dof", "degrees of freedom: the mean NEES of a consistent estimator", &S::dof)),
          count(row("used", "samples", &S::used)),
          count(row("covariances_not_positive_definite", "samples whose NEES is infinite",
                    &S::failures)),
          row("mean", "mean NEES over the samples", &S::mean),
          row("mean_over_dof", "mean NEES over its degrees of freedom",
              [](const S& s) { return s.mean / s.dof; }),
          row("median", "median NEES", &S::median),
          row("q95", "95% quantile of the NEES", &S::q95),
          row("fraction_inside", "samples inside the two-sided 95% interval of chi-square",
              &S::interval_coverage)};
}

// The mean heads a column where `name` is given.
MetricTable pose_nees_rows(const std::string& part, NeesSummary PoseConsistency::*summary,
                           const std::string& name = "") {
  MetricTable rows = nees_rows("nees." + part, Scope::kTrajectory, [=](const FinishedRun& f) {
    const auto& consistency = f.trajectory.consistency.value;
    return consistency ? &(*consistency.*summary) : nullptr;
  });
  for (Metric& row : rows) {
    if (name.empty() || row.leaf != "mean") continue;
    row = on_terminal(near_expected(std::move(row), "nees." + part + ".dof"));
    row.name = name;
  }
  return rows;
}

MetricTable landmark_nees_rows(const std::string& part, NeesSummary LandmarkConsistency::*summary) {
  return nees_rows("landmark_nees." + part, Scope::kRun, [=](const FinishedRun& f) {
    const auto& consistency = f.metrics.landmark_consistency.value;
    return consistency ? &(*consistency.*summary) : nullptr;
  });
}

MetricTable landmark_error_rows(const std::string& what, ErrorSummary LandmarkErrors::*summary) {
  const auto row = [&](const char* leaf, const char* caption, auto member) {
    const auto value = [=](const FinishedRun& f) {
      const auto& errors = f.metrics.landmark_errors.value;
      return errors ? number(member, *errors.*summary) : kUndefined;
    };
    return detail("landmark_errors." + what, leaf, caption, value);
  };
  using E = ErrorSummary;
  return {count(row("used", "landmarks with a true value", &E::used)),
          row("rmse", "root mean square over the landmarks", &E::rmse),
          row("median", "median over the landmarks", &E::median),
          row("q95", "95% quantile over the landmarks", &E::q95)};
}

}  // namespace

MetricTable consistency_rows() {
  MetricTable table = pose_nees_rows("pose", &PoseConsistency::pose, "pose NEES");
  append(table, pose_nees_rows("position", &PoseConsistency::position, "position NEES"));
  append(table, pose_nees_rows("rotation", &PoseConsistency::rotation));
  append(table, landmark_error_rows("static_position_m", &LandmarkErrors::static_position));
  append(table, landmark_error_rows("moving_position_m", &LandmarkErrors::moving_position));
  append(table, landmark_error_rows("moving_velocity_m_s", &LandmarkErrors::moving_velocity));
  append(table, landmark_nees_rows("position", &LandmarkConsistency::position));
  append(table, landmark_nees_rows("velocity", &LandmarkConsistency::velocity));
  return table;
}

}  // namespace slammot
