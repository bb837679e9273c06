#include "eval/study/study_view.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>

#include "eval/configuration/registry.h"
#include "eval/metrics/accuracy.h"
#include "eval/run/run.h"
#include "eval/statistics/chi_square.h"
#include "eval/study/study_sequence.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

// To a millimetre: it is a picture.
double to_millimetres(double x) { return std::round(1000.0 * x) / 1000.0; }
Json point(const Eigen::Vector3d& p) {
  return {to_millimetres(p.x()), to_millimetres(p.y()), to_millimetres(p.z())};
}

// Nothing for a landmark at infinity, or so uncertain that its ellipsoid would hide the scene.
Json landmark_json(const LandmarkEstimate& l, const Similarity& s) {
  constexpr double kWidest = 10.0;  // [m]
  if (!l.position.allFinite() || !l.position_covariance.allFinite()) return nullptr;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(l.position_covariance);
  const Eigen::Vector3d half =
      (chi_square_quantile(0.95, 3) * eigen.eigenvalues().cwiseMax(0.0)).cwiseSqrt();
  if (half.maxCoeff() > kWidest) return nullptr;
  Json json = {static_cast<int>(l.label)};
  for (const Json& x : point(s * l.position)) json.push_back(x);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = s.scale * s.rotation * (half(i) * eigen.eigenvectors().col(i));
    for (int k = 0; k < 3; ++k) json.push_back(to_millimetres(axis(k)));
  }
  return json;
}

// By frame, of those that can be shown.
std::map<int, Json> landmarks_json(const RunResult& run, const Similarity& alignment) {
  std::map<int, Json> landmarks;
  for (const LandmarkRecord& record : run.every_frame) {
    Json l = landmark_json(record.estimate, alignment);
    if (!l.is_null()) landmarks[record.frame].push_back(std::move(l));
  }
  return landmarks;
}

Json run_json(const Study& study, const StudyCell& cell) {
  const FrameSelection& frames = cell.configuration.frames;
  const Sequence sequence =
      select_frames(study_sequence(cell, study.first_seed), frames.first, frames.last, 1);
  DriveOptions options;
  options.landmarks_every_frame = true;
  const RunResult run = run_estimator(sequence, cell.configuration, cell.estimator, options);
  // As elsewhere on the page: beside a measured truth stands the aligned estimate.
  const Similarity alignment =
      sequence.exact_truth ? Similarity{} : similarity(pair_with_truth(sequence, run.filtered));
  std::map<int, Json> landmarks = landmarks_json(run, alignment);
  Json json = {{"label", cell.label},
               {"seed", study.first_seed},
               {"path", Json::array()},
               {"truth_path", Json::array()},
               {"steps", Json::array()}};
  const int count = static_cast<int>(run.frames.size());
  const int stride = std::max(1, (count + kViewSteps - 1) / kViewSteps);
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Vector3d estimate = alignment * run.filtered[k].state.position;
    json["path"].push_back(point(estimate));
    const Json truth = k < sequence.truth.size() && sequence.truth[k]
                           ? point(sequence.truth[k]->position)
                           : Json();
    if (!truth.is_null()) json["truth_path"].push_back(truth);
    if (i % stride != 0 && i + 1 != count) continue;
    Json shown = landmarks.count(run.frames[k]) > 0 ? landmarks[run.frames[k]] : Json::array();
    json["steps"].push_back({{"frame", run.frames[k]},
                             {"timestamp", run.filtered[k].timestamp},
                             {"done", i + 1},  // points of the path so far
                             {"camera", point(estimate)},
                             {"truth", truth},
                             {"landmarks", std::move(shown)}});
  }
  return json;
}

}  // namespace

Json study_view(const Study& study) {
  Json json = {
      {"format", "slammot-view-1"}, {"group", study.cells.front().group}, {"runs", Json::array()}};
  for (const StudyCell& cell : study.cells) {
    const bool enough = static_cast<int>(json["runs"].size()) == kViewRuns;
    if (enough || cell.group != study.cells.front().group) break;
    const EstimatorKind kind = find_estimator(cell.estimator).kind;
    const bool by_frame = kind == EstimatorKind::kFilter || kind == EstimatorKind::kSmoother;
    if (!by_frame) continue;  // a batch has no estimate per frame, an ideal covariance none
    json["runs"].push_back(run_json(study, cell));
  }
  return json;
}

}  // namespace slammot
