#include "eval/run/scale_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace slammot {

namespace {

// Not of a batch, whose window in front it would be.
bool states_scale(const RunResult& run, std::size_t i) {
  return !run.batch && i < run.scale_information.size() && run.scale_information[i] > 0.0;
}

double implied_sigma(const std::vector<CameraEstimate>& cameras, std::size_t i) {
  const Eigen::Vector3d d = cameras[i].state.position - cameras[0].state.position;
  const Eigen::Matrix3d P = cameras[i].covariance.block<3, 3>(kPosition, kPosition);
  return std::sqrt(d.dot(P * d)) / d.squaredNorm();
}

}  // namespace

std::optional<StatedScale> stated_scale(const Setup& setup) {
  constexpr double kLeast = 4.0;  // of a scale that is known to half of itself
  if (setup.knows_scale() || !(setup.prior.mean_sigma > 0.0)) return std::nullopt;
  const double speed = setup.initial.state.velocity.norm() / setup.initial.velocity_sigma;
  const double depth = setup.prior.inverse_depth / setup.prior.mean_sigma;
  const double information = speed * speed + depth * depth;
  if (information < kLeast) return std::nullopt;
  return StatedScale{information, setup.camera_noise.acceleration};
}

std::optional<RunWarning> scale_warning(const RunResult& run, const StatedScale& stated) {
  constexpr double kMostOfFrame = 3.0;
  constexpr double kTooSure = 3.0, kTooSureItself = 2.0;
  const std::vector<CameraEstimate>& cameras = run.judged();
  double information = stated.information;
  for (std::size_t i = 1; i < std::min(cameras.size(), run.frames.size()); ++i) {
    const CameraState &x = cameras[i].state, &before = cameras[i - 1].state;
    const double dt = cameras[i].timestamp - cameras[i - 1].timestamp;
    const double change = (x.velocity - before.velocity).norm() / (stated.acceleration * dt);
    information += std::min(kMostOfFrame, change * change);
    const double told = 1.0 / std::sqrt(information);
    const bool states = states_scale(run, i);
    const double claimed =
        states ? 1.0 / std::sqrt(run.scale_information[i]) : implied_sigma(cameras, i);
    const double too_sure = states ? kTooSureItself : kTooSure;
    if (!(claimed > 0.0) || too_sure * claimed >= told) continue;  // or not stated
    return RunWarning{
        run.frames[i],
        fmt::format("it claims to know the scale to {:.2g}%, but first velocity, mean "
                    "depth and accelerations as stated give it only to {:.2g}%: do not trust its "
                    "sigmas along the path",
                    100.0 * claimed, 100.0 * told)};
  }
  return std::nullopt;
}

}  // namespace slammot
