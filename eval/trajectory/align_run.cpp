#include "eval/trajectory/align_run.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <stdexcept>

#include "eval/metrics/alignment.h"
#include "eval/metrics/pose_pairs.h"

namespace slammot {
namespace {

using Points = std::vector<Eigen::Vector3d>;

// About a line every rotation fits.
bool is_line(const Points& points) {
  constexpr double kRounding = 1e-6;  // of the length
  Eigen::Matrix3Xd P(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    P.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  P.colwise() -= P.rowwise().mean().eval();
  const Eigen::Vector3d lengths = (P * P.transpose()).jacobiSvd().singularValues().cwiseSqrt();
  return !(lengths(1) > kRounding * lengths(0));
}

Similarity fit(const std::vector<PosePair>& pairs, AlignBy by) {
  Points estimate, truth;
  for (const PosePair& pair : pairs) {
    estimate.push_back(pair.estimate.state.position);
    truth.push_back(pair.truth.position);
  }
  if (pairs.size() < 3 || is_line(estimate) || is_line(truth)) {
    throw std::invalid_argument(
        "no rotation is seen in positions that are fewer than three, at rest or on a line: it "
        "can be aligned by `first`");
  }
  return align(estimate, truth,
               by == AlignBy::kSim3 ? AlignmentGroup::kSim3 : AlignmentGroup::kSE3);
}

Similarity at_first(const PosePair& first) {
  const CameraState& x = first.estimate.state;
  Similarity S;
  S.rotation = (first.truth.orientation * x.orientation.conjugate()).toRotationMatrix();
  S.translation = first.truth.position - S.rotation * x.position;
  return S;
}

// By blocks: one that is not known (NaN) shall not spoil another.
void move(const Similarity& S, CameraEstimate& camera) {
  const Eigen::Matrix3d R_scaled = S.scale * S.rotation;
  CameraState& x = camera.state;
  x.position = S * x.position;
  x.orientation = (Eigen::Quaterniond(S.rotation) * x.orientation).normalized();
  x.velocity = R_scaled * x.velocity;
  for (const int block : {kPosition, kVelocity}) {
    auto rows = camera.covariance.middleRows<3>(block);
    rows = (R_scaled * rows).eval();
    auto columns = camera.covariance.middleCols<3>(block);
    columns = (columns * R_scaled.transpose()).eval();
  }
}

void move(const Similarity& S, LandmarkEstimate& landmark) {
  const Eigen::Matrix3d R_scaled = S.scale * S.rotation;
  landmark.position = S * landmark.position;
  landmark.velocity = R_scaled * landmark.velocity;
  for (auto* P : {&landmark.position_covariance, &landmark.velocity_covariance}) {
    *P = (R_scaled * *P * R_scaled.transpose()).eval();
  }
}

// Whether the first pose has next to no covariance: then those of the others are of errors since.
bool first_is_held(const std::vector<PosePair>& pairs) {
  constexpr double kNegligible = 0.01;  // of the variances, on average
  return std::ranges::all_of(std::array{kPosition, kRotation}, [&](int block) {
    const auto variance = [=](const PosePair& p) {
      return p.estimate.covariance.block<3, 3>(block, block).trace();
    };
    double sum = 0.0;
    for (const PosePair& pair : pairs) sum += variance(pair);
    return variance(pairs.front()) <= kNegligible * sum / static_cast<double>(pairs.size());
  });
}

void describe(const std::vector<PosePair>& pairs, AlignBy by, RunAlignment& done) {
  done.by = std::ranges::find(kAlignments, by, [](const auto& row) { return row.second; })->first;
  done.poses = static_cast<int>(pairs.size());
  done.fitted = by == AlignBy::kSim3 ? 7 : 6;
  done.verdict = by == AlignBy::kFirst && first_is_held(pairs);
  done.note = fmt::format("aligned by {}, ", done.by);
  if (by != AlignBy::kFirst) {
    done.note += fmt::format(
        "a fit to the truth that takes {} of the {} degrees of freedom of {} poses, and all that "
        "their errors have in common: NEES is no verdict",
        done.fitted, 6 * done.poses, done.poses);
  } else if (done.verdict) {
    done.note +=
        "a pose whose error is zero and left out; its covariance is that of one held fixed";
  } else {
    done.note +=
        "a pose whose error is zero and left out, but not its covariance, if it has one: NEES is "
        "no verdict";
  }
}

}  // namespace

void align_run(const Sequence& sequence, AlignBy by, RunResult& run) {
  if (by == AlignBy::kNone) return;
  if (run.alignment) throw std::invalid_argument("is stored " + run.alignment->note);
  const std::vector<PosePair> pairs = pair_with_truth(sequence, run.judged());
  if (pairs.empty()) throw std::invalid_argument("no pose has a true one to be aligned with");
  const Similarity S = by == AlignBy::kFirst ? at_first(pairs.front()) : fit(pairs, by);
  RunAlignment& done = run.alignment.emplace();
  done.scale = S.scale;
  done.rotation = S.rotation;
  done.translation = S.translation;
  describe(pairs, by, done);
  for (auto* cameras : {&run.filtered, &run.smoothed}) {
    for (CameraEstimate& camera : *cameras) move(S, camera);
  }
  // Its scale, and so its pose, is another.
  const std::vector<PosePair> in_last_scale = pair_with_truth(sequence, run.last_scale);
  const bool has_own = by != AlignBy::kFirst && !in_last_scale.empty();
  const Similarity own = has_own ? fit(in_last_scale, by) : S;
  for (CameraEstimate& camera : run.last_scale) move(own, camera);
  for (LandmarkRecord& landmark : run.landmarks) move(S, landmark.estimate);
}

}  // namespace slammot
