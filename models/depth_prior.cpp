#include "slammot/models/depth_prior.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace slammot {
namespace {

constexpr double kEstablished = 0.1;  // sigma_rho / rho
constexpr std::size_t kLeast = 3;     // established landmarks
constexpr double kStatement = 1.0;    // how many landmarks the statement counts as
constexpr double kNearest = 5.0;      // times the median inverse depth

bool source_learns(const std::string& source) {
  if (source == "map") return true;
  if (source == "stated") return false;
  throw std::invalid_argument("unknown source '" + source + "' of the depth prior");
}

// A wrong landmark can seem to stand just before the camera. It counts as one that is near, no
// nearer; the births have a long tail there, so it is not left out.
std::vector<double> sample(const std::vector<SeenDepth>& seen) {
  std::vector<double> rho;
  for (const SeenDepth& s : seen) {
    if (s.sigma < kEstablished * s.inverse_depth) rho.push_back(s.inverse_depth);
  }
  if (rho.empty()) return rho;
  std::vector<double> sorted = rho;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  for (double& x : rho) x = std::min(x, kNearest * *middle);
  return rho;
}

// Of the next landmark, when the mean is that of `count`, and the sum of squares about it has so
// many degrees of freedom; 0 where there is none.
double student_variance(double squares, double degrees, double count) {
  return degrees > 2.0 ? squares / (degrees - 2.0) * (1.0 + 1.0 / count) : 0.0;
}

}  // namespace

LandmarkPrior learnt_depth_prior(const LandmarkPrior& stated, const std::vector<SeenDepth>& seen) {
  const std::vector<double> rho = sample(seen);
  if (rho.size() < kLeast) return stated;
  const auto n = static_cast<double>(rho.size());
  double mean = 0.0, squares = 0.0;
  for (const double x : rho) mean += x / n;
  for (const double x : rho) squares += (x - mean) * (x - mean);
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

DepthPrior::DepthPrior(const std::string& source, const LandmarkPrior& stated)
    : learns_(source_learns(source)), stated_(stated), born_(stated) {}

}  // namespace slammot
