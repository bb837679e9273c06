#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/metrics/accuracy.h"
#include "eval/run/alternatives.h"

namespace slammot {
namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
constexpr double kBetter = 10.0;   // times, that an alternative must be
constexpr double kNotWorse = 1.1;  // times, in what it does not better
constexpr double kConstant = 0.5;  // of the error: that the first pose has

struct PoseErrors {
  double position = 0.0, rotation = 0.0;  // RMS [m], [deg]
};

struct PoseAlternative {
  const char* name;
  CameraState (*as)(const CameraState& read);
};

CameraState with_orientation(CameraState state, const Eigen::Quaterniond& q) {
  state.orientation = q;
  return state;
}

CameraState w_first(const CameraState& x) {
  const Eigen::Quaterniond& q = x.orientation;
  return with_orientation(x, Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()));
}

CameraState w_last(const CameraState& x) {
  const Eigen::Quaterniond& q = x.orientation;
  return with_orientation(x, Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()));
}

CameraState turned_back(const CameraState& x) {
  return with_orientation(x, x.orientation.conjugate());
}

CameraState inverted(CameraState x) {
  x.orientation = x.orientation.conjugate();
  x.position = -(x.orientation * x.position);
  return x;
}

constexpr PoseAlternative kPoseAlternatives[] = {
    {"with w first in the quaternions", w_first},
    {"with w last in the quaternions", w_last},
    {"inverted (T_CW, where T_WC is read)", [](const CameraState& x) { return inverted(x); }},
    {"with the rotations inverted", turned_back},
    {"with w first in the quaternions and inverted (T_CW)",
     [](const CameraState& x) { return inverted(w_first(x)); }},
    {"with w first in the quaternions and the rotations inverted",
     [](const CameraState& x) { return turned_back(w_first(x)); }}};

std::vector<PosePair> moved(std::vector<PosePair> pairs, const Similarity& by) {
  const Eigen::Quaterniond turn(by.rotation);
  for (PosePair& pair : pairs) {
    CameraState& x = pair.estimate.state;
    x.position = by * x.position;
    x.orientation = turn * x.orientation;
  }
  return pairs;
}

std::vector<PosePair> in_true_world(const std::vector<PosePair>& pairs, AlignmentGroup group) {
  std::vector<Eigen::Vector3d> estimate, truth;
  for (const PosePair& pair : pairs) {
    estimate.push_back(pair.estimate.state.position);
    truth.push_back(pair.truth.position);
  }
  return moved(pairs, align(estimate, truth, group));
}

PoseErrors errors_of(const std::vector<PosePair>& pairs) {
  const Accuracy a = accuracy(pairs);
  return {a.position_rmse, a.rotation_rmse_deg};
}

// The rotation X that brings R_est X nearest to the true ones (Markley et al. 2007).
Eigen::Quaterniond mean_turn(const std::vector<PosePair>& pairs) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const PosePair& pair : pairs) {
    const Eigen::Vector4d q =
        (pair.estimate.state.orientation.conjugate() * pair.truth.orientation).coeffs();
    sum += q * q.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sum);
  const Eigen::Vector4d largest = solver.eigenvectors().col(3);
  return Eigen::Quaterniond(largest).normalized();
}

std::vector<PosePair> turned(std::vector<PosePair> pairs, const Eigen::Quaterniond& X) {
  for (PosePair& pair : pairs) {
    pair.estimate.state.orientation = pair.estimate.state.orientation * X;
  }
  return pairs;
}

bool fits(const PoseErrors& other, const PoseErrors& read) {
  const bool rotation = kBetter * other.rotation < read.rotation;
  const bool position = kBetter * other.position < read.position;
  return (rotation && (position || other.position <= kNotWorse * read.position)) ||
         (position && other.rotation <= kNotWorse * read.rotation);
}

std::string in_numbers(const PoseErrors& e) {
  return fmt::format("{:.4g} m, {:.3g} deg", e.position, e.rotation);
}

std::optional<std::string> other_order(const std::vector<PosePair>& pairs, const PoseErrors& read,
                                       bool exact) {
  constexpr double kTie = 1.01;
  std::optional<PoseErrors> best;
  std::string name;
  for (const PoseAlternative& alternative : kPoseAlternatives) {
    std::vector<PosePair> as = pairs;
    for (PosePair& pair : as) pair.estimate.state = alternative.as(pair.estimate.state);
    const PoseErrors errors = errors_of(exact ? as : in_true_world(as, AlignmentGroup::kSim3));
    if (!fits(errors, read) || (best && kTie * errors.rotation >= best->rotation)) continue;
    best = errors;
    name = alternative.name;
  }
  if (!best) return std::nullopt;
  return fmt::format("position and rotation RMSE {}{}; {} {}", in_numbers(read),
                     exact ? "" : " after alignment", name, in_numbers(*best));
}

std::optional<std::string> other_body(const std::vector<PosePair>& pairs, const PoseErrors& read) {
  const Eigen::Quaterniond X = mean_turn(pairs);
  const PoseErrors left = errors_of(turned(pairs, X));
  if (!fits(left, read)) return std::nullopt;
  return fmt::format(
      "rotation RMSE {:.2f} deg; a constant rotation of {:.1f} deg between the frames of camera "
      "and "
      "pose leaves {:.2g} deg: are these the poses of another body?",
      read.rotation, X.angularDistance(Eigen::Quaterniond::Identity()) * kDegreesPerRadian,
      left.rotation);
}

std::optional<std::string> other_world(const std::vector<PosePair>& pairs, const PoseErrors& read) {
  const std::vector<PosePair> there = in_true_world(pairs, AlignmentGroup::kSE3);
  const PoseErrors world = errors_of(there);
  const Eigen::Quaterniond X = mean_turn(there);
  const PoseErrors both = errors_of(turned(there, X));
  if (!(kBetter * world.position < read.position)) return std::nullopt;
  std::string body;
  if (kBetter * both.rotation < world.rotation) {
    body = fmt::format(
        ", and {:.2g} deg after a constant rotation of {:.1f} deg between the frames "
        "of camera and pose",
        both.rotation, X.angularDistance(Eigen::Quaterniond::Identity()) * kDegreesPerRadian);
  }
  return fmt::format(
      "another world: position and rotation RMSE {}, after SE(3) alignment {}{}; "
      "NEES judges the frame, not the estimator (--align)",
      in_numbers(read), in_numbers(world), body);
}

}  // namespace

std::optional<std::string> other_poses(const std::vector<PosePair>& pairs, bool exact_truth) {
  constexpr std::size_t kFewest = 3;
  if (pairs.size() < kFewest) return std::nullopt;
  const std::vector<PosePair> as_read =
      exact_truth ? pairs : in_true_world(pairs, AlignmentGroup::kSim3);
  const PoseErrors read = errors_of(as_read);
  if (auto hint = other_order(pairs, read, exact_truth)) return hint;
  // What an estimator loses on its way is no constant: the first pose does not have it yet.
  const bool turned_at_once = rotation_error_deg(as_read.front()) > kConstant * read.rotation;
  const bool moved_at_once = position_error(pairs.front()) > kConstant * read.position;
  if (exact_truth && (turned_at_once || moved_at_once)) {
    if (auto hint = other_world(pairs, read)) return hint;
  }
  return turned_at_once ? other_body(as_read, read) : std::nullopt;
}

}  // namespace slammot
