#include "eval/pooling/frame_statistics.h"

#include <algorithm>
#include <cmath>

#include "eval/metrics/accuracy.h"
#include "eval/metrics/nees.h"
#include "eval/output/metrics_json.h"
#include "eval/pooling/estimate_json.h"
#include "eval/statistics/chi_square.h"
#include "eval/statistics/statistics.h"

namespace slammot {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSampled[] = {"position_error_m", "rotation_error_deg", "nees_pose",
                                    "nees_position",    "nees_rotation",      "position_sigma_m"};
struct CameraPart {
  const char* name;
  int first;  // of the 12 entries of the camera's error
  int dof;
};
constexpr CameraPart kCameraParts[] = {{"pose", 0, 6}, {"position", 0, 3}, {"rotation", 3, 3}};
constexpr const char* kLandmarkParts[] = {"landmark_position", "landmark_velocity"};

double inside(double lower, double x, double upper) {
  if (std::isnan(lower)) return kUndefined;
  return lower <= x && x <= upper ? 1.0 : 0.0;
}

std::vector<double> defined(std::vector<double> values) {
  std::erase_if(values, [](double x) { return std::isnan(x); });
  return values;
}

// The samples of a JSON object of arrays, row by row.
class Rows {
 public:
  explicit Rows(std::vector<std::string> keys) : keys_(std::move(keys)) {
    for (const std::string& key : keys_) json_[key] = Json::array();
  }
  void push(const std::vector<Json>& row) {
    for (std::size_t i = 0; i < keys_.size(); ++i) json_[keys_[i]].push_back(row[i]);
  }
  Json json() { return std::move(json_); }

 private:
  std::vector<std::string> keys_;
  Json json_;
};

}  // namespace

Json judged_frames(const Sequence& sequence, const std::vector<PosePair>& pairs) {
  Json json = frames_json(sequence.exact_truth ? pairs : aligned(pairs));
  for (const CameraPart& part : kCameraParts) {
    bool stated = false;  // but for the first, which is a pin
    for (std::size_t i = 1; i < pairs.size(); ++i) {
      const auto& P = pairs[i].estimate.covariance;
      stated = stated || !P.block(part.first, part.first, part.dof, part.dof).hasNaN();
    }
    if (!sequence.exact_truth || !stated) json.erase(std::string("nees_") + part.name);
  }
  if (!sequence.exact_truth) {
    json["position_sigma_m"] = std::vector<double>(json["frame"].size(), kUndefined);
  }
  return json;
}

Json frames_json(const std::vector<PosePair>& pairs) {
  Json json;
  std::vector<int> frame;
  std::vector<double> position, rotation, nees_pose, nees_position, nees_rotation, position_sigma;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const PosePair& p = pairs[i];
    const PoseNees nees = pose_nees(p);
    frame.push_back(p.frame);
    position.push_back(position_error(p));
    rotation.push_back(rotation_error_deg(p));
    nees_pose.push_back(nees.pose);
    nees_position.push_back(nees.position);
    nees_rotation.push_back(nees.rotation);
    position_sigma.push_back(std::sqrt(p.estimate.covariance.topLeftCorner<3, 3>().trace()));
  }
  json["frame"] = frame;
  json["position_error_m"] = position;
  json["rotation_error_deg"] = rotation;
  json["nees_pose"] = nees_pose;
  json["nees_position"] = nees_position;
  json["nees_rotation"] = nees_rotation;
  json["position_sigma_m"] = position_sigma;
  return json;
}

void FrameStatistics::add(const Json& frames) {
  for (const CameraPart& part : kCameraParts) {
    const std::string key = std::string("nees_") + part.name;
    if (!frames.contains(key) || frames.at(key).empty()) continue;
    RunSum run;
    for (const Json& x : frames.at(key)) run.sum += nees_number(x);
    run.count = static_cast<double>(frames.at(key).size());
    run_sums_[part.name].push_back(run);
  }
  const Json& index = frames.at("frame");
  for (std::size_t i = 0; i < index.size(); ++i) {
    Frame& frame = frames_[count_of(index.at(i))];
    for (const std::string what : kSampled) {
      const bool is_nees = what.starts_with("nees_");
      if (is_nees && !frames.contains(what)) continue;  // no covariance is stated
      const Json& value = frames.at(what).at(i);
      frame.samples[what].push_back(is_nees ? nees_number(value) : number(value));
    }
    for (const std::string part : kLandmarkParts) {
      if (!frames.contains("nees_" + part)) continue;  // smoothed cameras have no landmarks
      frame.landmark_nees[part].push_back(
          run_sum(frames.at("nees_" + part).at(i), frames.at(part + "_count").at(i)));
    }
  }
}

FrameStatistics::Anees FrameStatistics::camera_part(const std::string& part, int dof) const {
  Anees anees{part, dof, {}, {}, {}, {}};
  for (const auto& [index, frame] : frames_) {
    std::vector<double> samples;
    const auto nees = frame.samples.find("nees_" + part);
    if (nees != frame.samples.end()) {
      samples = nees->second;
    }
    const int runs = static_cast<int>(samples.size());
    const Interval interval =
        runs > 0 ? nees_interval(dof, runs) : Interval{kUndefined, kUndefined};
    anees.value.push_back(mean(samples));
    anees.lower.push_back(interval.lower);
    anees.upper.push_back(interval.upper);
    anees.inside.push_back(inside(interval.lower, anees.value.back(), interval.upper));
  }
  return anees;
}

FrameStatistics::Anees FrameStatistics::landmark_part(const std::string& part) const {
  constexpr int kDof = 3;
  Anees anees{part, kDof, {}, {}, {}, {}};
  for (const auto& [index, frame] : frames_) {
    const Estimate estimate = bootstrap_mean(frame.landmark_nees.at(part));
    anees.value.push_back(estimate.value);
    anees.lower.push_back(estimate.lower);
    anees.upper.push_back(estimate.upper);
    anees.inside.push_back(inside(estimate.lower, kDof, estimate.upper));
  }
  return anees;
}

std::vector<FrameStatistics::Anees> FrameStatistics::parts() const {
  std::vector<Anees> all;
  for (const CameraPart& part : kCameraParts) {
    if (run_sums_.contains(part.name)) all.push_back(camera_part(part.name, part.dof));
  }
  for (const char* part : kLandmarkParts) {
    if (frames_.begin()->second.landmark_nees.contains(part)) all.push_back(landmark_part(part));
  }
  return all;
}

Json FrameStatistics::anees() const {
  Json json = Json::object();
  for (const Anees& part : parts()) {
    const std::vector<double> values = defined(part.value);
    json[part.part] = {{"dof", part.dof},
                       {"mean", mean(values)},
                       {"largest", maximum(values)},
                       {"inside", mean(defined(part.inside))},
                       {"infinite", std::ranges::count(values, INFINITY)}};
    const auto runs = run_sums_.find(part.part);
    if (runs == run_sums_.end()) continue;
    const Estimate estimate = bootstrap_mean(runs->second);
    json[part.part]["mean"] = estimate.value;
    json[part.part]["lower"] = estimate.lower;
    json[part.part]["upper"] = estimate.upper;
    json[part.part]["runs"] = estimate.samples;
  }
  return json;
}

Json FrameStatistics::per_frame() const {
  Rows rows({"frame", "runs", "position_rmse_m", "position_q25_m", "position_median_m",
             "position_q75_m", "position_q95_m", "position_sigma_m", "rotation_rmse_deg"});
  for (const auto& [index, frame] : frames_) {
    const std::vector<double>& errors = frame.samples.at("position_error_m");
    rows.push({index, errors.size(), root_mean_square(errors), quantile(errors, 0.25),
               quantile(errors, 0.5), quantile(errors, 0.75), quantile(errors, 0.95),
               root_mean_square(frame.samples.at("position_sigma_m")),
               root_mean_square(frame.samples.at("rotation_error_deg"))});
  }
  Json json = rows.json();
  for (const Anees& part : parts()) {
    json["anees_" + part.part] = part.value;
    json["anees_" + part.part + "_lower"] = part.lower;
    json["anees_" + part.part + "_upper"] = part.upper;
  }
  return json;
}

}  // namespace slammot
