#include "eval/metrics/metrics_json.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

Json block(const NeesSummary& s) {
  return {{"dof", s.dof},
          {"used", s.used},
          {"covariances_not_positive_definite", s.failures},
          {"mean", s.mean},
          {"mean_over_dof", s.mean / s.dof},
          {"median", s.median},
          {"q95", s.q95},
          {"single_run_interval_95", {s.lower, s.upper}},
          {"fraction_inside", s.fraction_inside}};
}

Json block(const Accuracy& a) {
  return {{"poses", a.poses},
          {"position_rmse_m", a.position_rmse},
          {"position_max_m", a.position_max},
          {"position_final_m", a.position_final},
          {"rotation_rmse_deg", a.rotation_rmse_deg},
          {"rotation_max_deg", a.rotation_max_deg},
          {"ate_se3_m", a.ate_se3},
          {"ate_sim3_m", a.ate_sim3},
          {"sim3_scale", a.scale},
          {"rpe_1s_pairs", a.relative_pairs},
          {"rpe_1s_position_rmse_m", a.relative_position_rmse},
          {"rpe_1s_rotation_rmse_deg", a.relative_rotation_rmse_deg}};
}

Json block(const PoseConsistency& c) {
  Json series = Json::array();
  for (const PoseNees& s : c.series) {
    series.push_back({s.frame, s.timestamp, s.pose, s.position, s.rotation});
  }
  return {{"error", "[dr (W), dtheta (C, right)]"},
          {"excluded", "frames before the first prediction"},
          {"note", "frames of one run are correlated: fraction_inside is descriptive"},
          {"pose", block(c.pose)},
          {"position", block(c.position)},
          {"rotation", block(c.rotation)},
          {"series_columns", {"frame", "timestamp", "pose", "position", "rotation"}},
          {"series", std::move(series)}};
}

Json block(const ErrorSummary& e) {
  return {{"used", e.used}, {"rmse", e.rmse}, {"median", e.median}, {"q95", e.q95}};
}

Json block(const LandmarkErrors& e) {
  return {{"static_position_m", block(e.static_position)},
          {"moving_position_m", block(e.moving_position)},
          {"moving_velocity_m_s", block(e.moving_velocity)}};
}

Json block(const LandmarkConsistency& c) {
  return {{"position", block(c.position)}, {"velocity", block(c.velocity)}};
}

template <typename T>
void add_known(Json& json, const std::string& name, const Known<T>& known) {
  json[name] = known.value ? block(*known.value) : Json(nullptr);
  if (!known.value) json[name + "_reason"] = known.reason;
}

Json block(const TrajectoryMetrics& t) {
  Json json = Json::object();
  add_known(json, "accuracy", t.accuracy);
  add_known(json, "nees", t.consistency);
  return json;
}

Json block(const ClassCounts& c) {
  return {{"right", c.right},
          {"wrong", c.wrong},
          {"undecided", c.undecided},
          {"wrongly_classified", c.wrongly_classified()},
          {"misclassified", c.misclassified()}};
}

Json block(const ClassificationMetrics& c) {
  return {{"static", block(c.statics)},
          {"moving", block(c.movings)},
          {"without_truth", c.without_truth},
          {"median_frames_to_decision", c.median_frames_to_decision}};
}

Json block(const Coverage& c) {
  return {{"frames_offered", c.frames_offered},
          {"frames_done", c.frames_done},
          {"measurements_offered", c.offered},
          {"accepted", c.accepted},
          {"rejected", c.rejected},
          {"out_of_view", c.out_of_view},
          {"landmarks_admitted", c.admitted},
          {"landmarks_lost", c.lost},
          {"negative_inverse_depths", c.negative_inverse_depth}};
}

Json block(const RuntimeMetrics& r) {
  Json stages = Json::array();
  for (const StageCost& s : r.stages) {
    stages.push_back({{"stage", s.stage},
                      {"median_ms", s.median_ms},
                      {"p95_ms", s.p95_ms},
                      {"total_ms", s.total_ms}});
  }
  return {{"frame_median_ms", r.frame_median_ms},
          {"frame_p95_ms", r.frame_p95_ms},
          {"frames_per_second", r.frames_per_second},
          {"smoothing_ms", r.smoothing_ms},
          {"state_size_median", r.state_size_median},
          {"state_size_max", r.state_size_max},
          {"stages", std::move(stages)}};
}

}  // namespace

Json metrics_json(const RunMetrics& m) {
  Json json = Json::object();
  json["diverged"] = m.diverged.has_value();
  json["divergence"] =
      m.diverged ? Json{{"frame", m.diverged->frame}, {"reason", m.diverged->reason}} : Json();
  json["filtered"] = block(m.filtered);
  json["smoothed"] = m.smoothed ? block(*m.smoothed) : Json();
  add_known(json, "landmark_errors", m.landmark_errors);
  add_known(json, "landmark_nees", m.landmark_consistency);
  json["classification"] = block(m.classification);
  json["nis"] = {{"dof", m.nis.dof}, {"mean", m.nis.mean}, {"expected_mean", m.nis.expected}};
  json["coverage"] = block(m.coverage);
  json["runtime"] = block(m.runtime);
  return json;
}

void restore_totals(const Json& metrics, RunResult& run) {
  const Json& coverage = metrics.at("coverage");
  const Json& mean_nis = metrics.at("nis").at("mean");
  FrameCounts& totals = run.totals;
  run.frames_offered = coverage.at("frames_offered").get<int>();
  totals.accepted = coverage.at("accepted").get<int>();
  totals.rejected = coverage.at("rejected").get<int>();
  totals.out_of_view = coverage.at("out_of_view").get<int>();
  totals.admitted = coverage.at("landmarks_admitted").get<int>();
  totals.lost = coverage.at("landmarks_lost").get<int>();
  totals.negative_inverse_depth = coverage.at("negative_inverse_depths").get<int>();
  if (mean_nis.is_number()) totals.nis_sum = mean_nis.get<double>() * totals.accepted;
  run.smoothing_ms = metrics.at("runtime").at("smoothing_ms").get<double>();
  if (metrics.at("diverged").get<bool>()) {
    const Json& divergence = metrics.at("divergence");
    run.diverged = {divergence.at("frame").get<int>(), divergence.at("reason").get<std::string>()};
  }
}

}  // namespace slammot
