#include "eval/compare/series.h"

#include <map>

#include "eval/metrics/alignment.h"
#include "eval/metrics/pose_pairs.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMostPoints = 2000;

size_t stride_of(size_t points) { return points / kMostPoints + 1; }

Json as_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Nothing that a camera measures fixes frame and scale: beside a measured truth stands the aligned
// path.
void add_alignment(const Sequence& sequence, const std::vector<CameraEstimate>& estimates,
                   size_t stride, Json& json) {
  const std::vector<PosePair> pairs = pair_with_truth(sequence, estimates);
  const Similarity s = similarity(pairs);
  std::map<double, double> errors;
  for (const PosePair& pair : pairs) {
    errors[pair.estimate.timestamp] =
        (pair.truth.position - s * pair.estimate.state.position).norm();
  }
  json["alignment"] = {
      {"scale", s.scale},
      {"rotation",
       {as_json(s.rotation.row(0)), as_json(s.rotation.row(1)), as_json(s.rotation.row(2))}},
      {"translation", as_json(s.translation)}};
  json["aligned_position_error_m"] = Json::array();
  for (size_t i = 0; i < estimates.size(); i += stride) {
    const auto error = errors.find(estimates[i].timestamp);
    json["aligned_position_error_m"].push_back(error == errors.end() ? kUndefined : error->second);
  }
}

}  // namespace

Json path_series(const Sequence& sequence, const std::vector<CameraEstimate>& estimates,
                 const TrajectoryMetrics& metrics) {
  std::map<double, PosePair> pairs;
  for (const PosePair& pair : pair_with_truth(sequence, estimates)) {
    pairs.emplace(pair.estimate.timestamp, pair);
  }
  std::map<double, PoseNees> nees;
  if (metrics.consistency.value) {
    for (const PoseNees& s : metrics.consistency.value->series) nees.emplace(s.timestamp, s);
  }
  const size_t stride = stride_of(estimates.size());
  Json json = {{"stride", stride}};
  if (!sequence.exact_truth && !pairs.empty()) add_alignment(sequence, estimates, stride, json);
  for (const char* name : {"timestamp", "position", "position_error_m", "rotation_error_deg",
                           "nees_pose", "nees_position", "nees_rotation"}) {
    json[name] = Json::array();
  }
  for (size_t i = 0; i < estimates.size(); i += stride) {
    const double t = estimates[i].timestamp;
    const auto pair = pairs.find(t);
    const auto n = nees.find(t);
    const bool true_pose = pair != pairs.end();
    json["timestamp"].push_back(t);
    json["position"].push_back(as_json(estimates[i].state.position));
    json["position_error_m"].push_back(true_pose ? position_error(pair->second) : kUndefined);
    json["rotation_error_deg"].push_back(true_pose ? rotation_error_deg(pair->second) : kUndefined);
    json["nees_pose"].push_back(n == nees.end() ? kUndefined : n->second.pose);
    json["nees_position"].push_back(n == nees.end() ? kUndefined : n->second.position);
    json["nees_rotation"].push_back(n == nees.end() ? kUndefined : n->second.rotation);
  }
  return json;
}

Json run_series(const Sequence& sequence, const RunResult& run, const TrajectoryMetrics& metrics) {
  Json json = path_series(sequence, run.judged(), metrics);
  std::map<int, double> total_ms;
  for (const StageTime& time : run.timing) {
    if (time.stage == "total") total_ms[time.frame] = time.milliseconds;
  }
  for (const char* name : {"frame", "nis_mean", "accepted", "rejected", "state_size", "frame_ms"}) {
    json[name] = Json::array();
  }
  for (size_t i = 0; i < run.counts.size(); i += stride_of(run.filtered.size())) {
    const FrameCounts& counts = run.counts[i];
    json["frame"].push_back(run.frames[i]);
    json["nis_mean"].push_back(counts.accepted == 0 ? kUndefined
                                                    : counts.nis_sum / counts.accepted);
    json["accepted"].push_back(counts.accepted);
    json["rejected"].push_back(counts.rejected);
    json["state_size"].push_back(counts.state_size);
    json["frame_ms"].push_back(total_ms[run.frames[i]]);
  }
  return json;
}

Json truth_json(const Sequence& sequence) {
  Json json = {{"timestamp", Json::array()}, {"position", Json::array()}};
  for (size_t i = 0; i < sequence.truth.size(); i += stride_of(sequence.truth.size())) {
    if (!sequence.truth[i]) continue;
    json["timestamp"].push_back(sequence.frames[i].timestamp);
    json["position"].push_back(as_json(sequence.truth[i]->position));
  }
  json["landmarks"] = Json::array();
  for (const auto& [track, landmark] : sequence.landmarks) {
    if (landmark.by_frame.empty()) continue;
    json["landmarks"].push_back({{"track", track},
                                 {"class", std::string(to_string(landmark.label))},
                                 {"position", as_json(landmark.by_frame.begin()->second.position)},
                                 {"last", as_json(landmark.by_frame.rbegin()->second.position)}});
  }
  return json;
}

}  // namespace slammot
