#include "estimation/modules/depth_prior.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace slammot {
namespace {

constexpr double kEstablished = 0.1;  // sigma_rho / rho
constexpr std::size_t kLeast = 3;     // established landmarks
constexpr double kStatement = 1.0;    // how many landmarks the statement counts as
constexpr double kNearest = 5.0;      // times the median inverse depth

// The established, in place. A wrong landmark can seem to stand just before the camera. It counts
// as one that is near, no nearer; the births have a long tail there, so it is not left out.
std::span<SeenDepth> sample(std::span<SeenDepth> seen) {
  const auto end = std::partition(seen.begin(), seen.end(), [](const SeenDepth& s) {
    return s.sigma < kEstablished * s.inverse_depth;
  });
  const auto established = seen.first(static_cast<std::size_t>(end - seen.begin()));
  if (established.empty()) return established;
  const auto middle = established.begin() + std::ssize(established) / 2;
  const auto farther = [](const SeenDepth& a, const SeenDepth& b) {
    return a.inverse_depth < b.inverse_depth;
  };
  std::nth_element(established.begin(), middle, established.end(), farther);
  const double nearest = kNearest * middle->inverse_depth;
  for (SeenDepth& s : established) s.inverse_depth = std::min(s.inverse_depth, nearest);
  return established;
}

// Of the next landmark, when the mean is that of `count`, and the sum of squares about it has so
// many degrees of freedom; 0 where there is none.
double student_variance(double squares, double degrees, double count) {
  return degrees > 2.0 ? squares / (degrees - 2.0) * (1.0 + 1.0 / count) : 0.0;
}

}  // namespace

LandmarkPrior learnt_depth_prior(const LandmarkPrior& stated, std::span<SeenDepth> seen) {
  const std::span<const SeenDepth> established = sample(seen);
  if (established.size() < kLeast) return stated;
  const auto n = static_cast<double>(established.size());
  double mean = 0.0, squares = 0.0;
  for (const SeenDepth& s : established) mean += s.inverse_depth / n;
  for (const SeenDepth& s : established) {
    squares += (s.inverse_depth - mean) * (s.inverse_depth - mean);
  }
  // Beside a shared mean, rho0 is no claim about this scene's, and being surprised by it no spread.
  const double guess = stated.mean_sigma > 0.0 ? 0.0 : kStatement;
  const double degrees = kStatement + n - (guess > 0.0 ? 0.0 : 1.0);  // the sample's mean takes one
  const double surprise = mean - stated.inverse_depth;
  const double blended = squares +
                         kStatement * stated.inverse_depth_sigma * stated.inverse_depth_sigma +
                         guess * n / (guess + n) * surprise * surprise;
  LandmarkPrior learnt = stated;
  learnt.mean_sigma = 0.0;  // for the motion's prior: rho0 is not in doubt any more
  learnt.inverse_depth = (guess * stated.inverse_depth + n * mean) / (guess + n);
  // A statement that is too narrow must not make it narrower than the sample alone would.
  learnt.inverse_depth_sigma = std::sqrt(std::max(student_variance(blended, degrees, guess + n),
                                                  student_variance(squares, n - 1.0, n)));
  return learnt;
}

bool holds_scale(const InitialCamera& camera) {
  return 2.0 * camera.velocity_sigma < camera.state.velocity.norm();
}

bool learns_depths(DepthPriorSource source, const InitialCamera& camera, bool some_are_known) {
  if (source != DepthPriorSource::kAuto) return source == DepthPriorSource::kEmpirical;
  return some_are_known || holds_scale(camera);
}

}  // namespace slammot
