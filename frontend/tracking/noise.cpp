#include "frontend/tracking/noise.h"

#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>

namespace slammot {
namespace {

constexpr double kLeast = 0.01;  // [px] images that repeat have no noise at all
constexpr size_t kLeastPoints = 20;
constexpr double kNormalMedian = 1.4826;  // sigma over the median of |d|
constexpr double kCut = 3.0;              // [sigma] beyond it a point moves
constexpr double kNormal75 = 1.1503;      // |d| that holds three quarters, in sigmas
constexpr double kParameters = 7.0;       // of a fundamental matrix
constexpr int kRounds = 5;
constexpr int kMostPairs = 200;  // spread over the sequence; more tell nothing new

double quantile(std::vector<double> values, double part) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// The length of the track of a typical measurement: short tracks are many, but hold few of them.
int typical_track_length(const Sequence& sequence) {
  std::map<int, int> lengths;
  for (const Frame& frame : sequence.frames) {
    for (const Observation& z : frame.observations) ++lengths[z.track];
  }
  std::vector<double> values;
  for (const auto& [track, length] : lengths) {
    values.insert(values.end(), static_cast<size_t>(length), length);
  }
  return values.empty() ? 0 : static_cast<int>(quantile(std::move(values), 0.5));
}

struct Matches {
  std::vector<cv::Point2d> from, to;  // [px] of a pinhole without distortion
};

// Both lists of observations are sorted by track.
Matches matches(const Camera& camera, double focal, const Frame& a, const Frame& b) {
  Matches result;
  const auto plane = [&](const Observation& z) -> std::optional<cv::Point2d> {
    const auto bearing = camera.unproject(z.pixel);
    if (!bearing) return std::nullopt;
    return cv::Point2d(focal * bearing->ray.x(), focal * bearing->ray.y());
  };
  auto other = b.observations.begin();
  for (const Observation& z : a.observations) {
    while (other != b.observations.end() && other->track < z.track) ++other;
    if (other == b.observations.end() || other->track != z.track) continue;
    const auto from = plane(z), to = plane(*other);
    if (!from || !to) continue;
    result.from.push_back(*from);
    result.to.push_back(*to);
  }
  return result;
}

// Signed: x2' F x1 over its gradient's length.
double sampson_distance(const cv::Matx33d& F, const cv::Point2d& from, const cv::Point2d& to) {
  const cv::Vec3d a(from.x, from.y, 1.0), b(to.x, to.y, 1.0);
  const cv::Vec3d Fa = F * a, Fb = F.t() * b;
  return b.dot(Fa) / std::sqrt(Fa[0] * Fa[0] + Fa[1] * Fa[1] + Fb[0] * Fb[0] + Fb[1] * Fb[1]);
}

// Of all pairs, in pixels; nothing where no matrix was found.
std::vector<double> distances(const cv::Mat& F, const Matches& m) {
  std::vector<double> result;
  if (F.rows != 3 || F.cols != 3) return result;
  for (size_t i = 0; i < m.from.size(); ++i) {
    result.push_back(std::abs(sampson_distance(cv::Matx33d(F), m.from[i], m.to[i])));
  }
  return result;
}

Matches nearer_than(double limit, const std::vector<double>& d, const Matches& m) {
  Matches near;
  for (size_t i = 0; i < d.size(); ++i) {
    if (!(d[i] < limit)) continue;
    near.from.push_back(m.from[i]);
    near.to.push_back(m.to[i]);
  }
  return near;
}

std::optional<double> pair_sigma(const Matches& m) {
  if (m.from.size() < kLeastPoints) return std::nullopt;
  std::vector<double> d =
      distances(cv::findFundamentalMat(m.from, m.to, cv::FM_LMEDS, 1.0, 0.999), m);
  if (d.empty()) return std::nullopt;
  const double count = static_cast<double>(d.size());
  const double freedom = std::sqrt(count / (count - kParameters));
  double sigma = freedom * kNormalMedian * quantile(d, 0.5);
  for (int round = 0; round < kRounds; ++round) {
    const Matches inliers = nearer_than(kCut * sigma, d, m);
    if (inliers.from.size() < kLeastPoints) return std::nullopt;
    d = distances(cv::findFundamentalMat(inliers.from, inliers.to, cv::FM_8POINT), m);
    if (d.empty()) return std::nullopt;
    sigma = freedom * kNormalMedian * quantile(d, 0.5);
  }
  sigma = freedom * quantile(d, 0.75) / kNormal75;
  return std::isfinite(sigma) ? std::optional(sigma) : std::nullopt;
}

}  // namespace

std::optional<TrackNoise> measure_noise(const Sequence& sequence) {
  TrackNoise noise;
  noise.lag = std::max(1, typical_track_length(sequence) / 2);
  const double focal = (sequence.camera.fx + sequence.camera.fy) / 2.0;
  const int last = static_cast<int>(sequence.frames.size()) - noise.lag;
  const int step = std::max(1, last / kMostPairs);
  std::vector<double> sigmas;
  for (int i = 0; i < last; i += step) {
    const auto from = sequence.frames.begin() + i;
    const Frame& a = *from;
    const Frame& b = *(from + noise.lag);
    const auto sigma = pair_sigma(matches(sequence.camera, focal, a, b));
    if (sigma) sigmas.push_back(*sigma);
  }
  if (sigmas.empty()) return std::nullopt;
  noise.pairs = static_cast<int>(sigmas.size());
  noise.sigma = std::max(kLeast, quantile(std::move(sigmas), 0.5));
  return noise;
}

}  // namespace slammot
