#include "frontend/tracking/noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>

namespace slammot {
namespace {

constexpr double kLeast = 0.01;  // [px] images that repeat have no noise at all
constexpr size_t kLeastPoints = 20;
constexpr double kCut = 3.0;         // [sigma] beyond it a point moves
constexpr double kParameters = 7.0;  // of a fundamental matrix
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

// A part of the distances, and |d| of a normal distribution that holds it, in sigmas.
struct Part {
  double share, normal;
};
constexpr Part kMedian{0.5, 1.0 / 1.4826}, kThreeQuarters{0.75, 1.1503};

struct Matches {
  std::vector<cv::Point2d> from, to;               // [px] of a pinhole without distortion
  std::vector<double> variance_from, variance_to;  // what is known beforehand [px^2]
};

// Both lists of observations are sorted by track.
Matches matches(const Camera& camera, double focal, NoiseModel model, const Frame& a,
                const Frame& b) {
  Matches result;
  const double known = model == NoiseModel::kAlignment ? kMismatch : 0.0;
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
    result.variance_from.push_back(z.variance(known));
    result.variance_to.push_back(other->variance(known));
  }
  return result;
}

// e = x2' F x1, of variance a^2 u + v: a as of all coordinates, v by what is known of these.
struct Distance {
  double e, u, v;
};

// Of all pairs; nothing where no matrix was found.
std::vector<Distance> distances(const cv::Mat& matrix, const Matches& m) {
  std::vector<Distance> result;
  if (matrix.rows != 3 || matrix.cols != 3) return result;
  const cv::Matx33d F(matrix);
  for (size_t i = 0; i < m.from.size(); ++i) {
    const cv::Vec3d from(m.from[i].x, m.from[i].y, 1.0), to(m.to[i].x, m.to[i].y, 1.0);
    const cv::Vec3d at_to = F * from, at_from = F.t() * to;  // de/dto, de/dfrom
    const double u_to = at_to[0] * at_to[0] + at_to[1] * at_to[1];
    const double u_from = at_from[0] * at_from[0] + at_from[1] * at_from[1];
    result.push_back(
        {to.dot(at_to), u_to + u_from, u_to * m.variance_to[i] + u_from * m.variance_from[i]});
  }
  return result;
}

// The a with which this part of the distances is within what a normal distribution has there, seven
// degrees of freedom taken off: each distance is from its own a on.
double common_sigma(const std::vector<Distance>& distances, const Part& part) {
  const double count = static_cast<double>(distances.size());
  const double limit = part.normal * std::sqrt((count - kParameters) / count);
  std::vector<double> squares;
  for (const Distance& d : distances) {
    squares.push_back((d.e * d.e / (limit * limit) - d.v) / d.u);
  }
  const double square = quantile(std::move(squares), part.share);
  return std::sqrt(std::max(square, kLeast * kLeast));  // in this order NaN stays NaN
}

Matches inliers(double a, const std::vector<Distance>& distances, const Matches& m) {
  Matches near;
  for (size_t i = 0; i < m.from.size(); ++i) {
    const Distance& d = distances[i];
    if (!(d.e * d.e < kCut * kCut * (a * a * d.u + d.v))) continue;
    near.from.push_back(m.from[i]);
    near.to.push_back(m.to[i]);
  }
  return near;
}

std::optional<double> pair_sigma(const Matches& m, const Part& part) {
  if (m.from.size() < kLeastPoints) return std::nullopt;
  std::vector<Distance> d =
      distances(cv::findFundamentalMat(m.from, m.to, cv::FM_LMEDS, 1.0, 0.999), m);
  if (d.empty()) return std::nullopt;
  for (int round = 0; round < kRounds; ++round) {
    const Matches near = inliers(common_sigma(d, kMedian), d, m);
    if (near.from.size() < kLeastPoints) return std::nullopt;
    d = distances(cv::findFundamentalMat(near.from, near.to, cv::FM_8POINT), m);
    if (d.empty()) return std::nullopt;
  }
  const double sigma = common_sigma(d, part);
  return std::isfinite(sigma) ? std::optional(sigma) : std::nullopt;
}

}  // namespace

std::optional<TrackNoise> measure_noise(const Sequence& sequence, NoiseModel model) {
  TrackNoise noise;
  noise.lag = std::max(1, typical_track_length(sequence) / 2);
  const double focal = (sequence.camera.fx + sequence.camera.fy) / 2.0;
  const int last = static_cast<int>(sequence.frames.size()) - noise.lag;
  const int step = std::max(1, last / kMostPairs);
  const Part& part = model == NoiseModel::kAlignment ? kMedian : kThreeQuarters;
  std::vector<double> sigmas;
  for (int i = 0; i < last; i += step) {
    const auto from = sequence.frames.begin() + i;
    const Frame& a = *from;
    const Frame& b = *(from + noise.lag);
    const auto sigma = pair_sigma(matches(sequence.camera, focal, model, a, b), part);
    if (sigma) sigmas.push_back(*sigma);
  }
  if (sigmas.empty()) return std::nullopt;
  noise.pairs = static_cast<int>(sigmas.size());
  noise.lower = quantile(sigmas, 0.25);
  noise.upper = quantile(sigmas, 0.75);
  noise.sigma = quantile(std::move(sigmas), 0.5);
  return noise;
}

void state_noise(const std::optional<TrackNoise>& noise, NoiseModel model, Sequence& sequence) {
  if (model == NoiseModel::kCommon || !noise) {
    if (noise) sequence.pixel_sigma = std::max(kLeastStated, noise->sigma);
    for (Frame& frame : sequence.frames) {
      for (Observation& z : frame.observations) z.relative_sigma = 1.0;
      for (Observation& z : frame.other_views) z.relative_sigma = 1.0;
    }
    return;
  }
  std::vector<double> sigmas;
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) {
      z.relative_sigma = kLasting * std::hypot(noise->sigma, kMismatch * z.relative_sigma);
      sigmas.push_back(z.relative_sigma);
    }
    for (Observation& z : frame.other_views) {
      z.relative_sigma = kLasting * std::hypot(noise->sigma, kMismatch * z.relative_sigma);
    }
  }
  sequence.pixel_sigma = quantile(std::move(sigmas), 0.5);
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) z.relative_sigma /= sequence.pixel_sigma;
    for (Observation& z : frame.other_views) z.relative_sigma /= sequence.pixel_sigma;
  }
}

}  // namespace slammot
