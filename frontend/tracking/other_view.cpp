#include "frontend/tracking/other_view.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace slammot {
namespace {

// Above the noise of two alignments and what a good calibration leaves [px].
constexpr double kMostOffLine = 2.0;

}  // namespace

std::vector<Observation> OtherView::match(const Tracker& tracker, const cv::Mat& image,
                                          const std::vector<Observation>& z) {
  std::vector<Eigen::Vector2d> far, guesses;
  std::map<int, Eigen::Vector2d> moved;
  for (const Observation& one : z) {
    const auto before = moved_.find(one.track);
    if (before != moved_.end()) moved.insert(*before);
    far.push_back(at_infinity(one.pixel));
    guesses.emplace_back(before == moved_.end() ? far.back() : far.back() + before->second);
  }
  const auto fits = tracker.find_in(image, guesses);
  std::vector<Observation> views;
  for (size_t i = 0; i < z.size(); ++i) {
    if (!fits[i]) continue;
    const Eigen::Vector2d& pixel = fits[i]->warp.t;
    const auto off = off_line(z[i].pixel, pixel);
    if (!off || *off > kMostOffLine) continue;
    views.push_back({z[i].track, pixel, fits[i]->sigma, number_});
    moved.insert_or_assign(z[i].track, pixel - far[i]);
  }
  moved_ = std::move(moved);  // what has ended is forgotten
  return views;
}

Eigen::Vector2d OtherView::at_infinity(const Eigen::Vector2d& first) const {
  const auto g = first_.unproject(first);
  const auto seen = g ? other_.lens.project(other_.ray(g->ray, 0.0)) : std::nullopt;
  return seen && other_.lens.in_image(seen->pixel) ? seen->pixel : first;
}

// On the normalised plane the image of R' (g - rho t) begins at rho = 0 and goes straight to the
// epipole.
std::optional<double> OtherView::off_line(const Eigen::Vector2d& first,
                                          const Eigen::Vector2d& pixel) const {
  const auto g = first_.unproject(first), seen = other_.lens.unproject(pixel);
  if (!g || !seen) return std::nullopt;
  const Eigen::Vector3d a = other_.ray(g->ray, 0.0), e = other_.R.conjugate() * other_.t;
  if (!(a.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d focal(other_.lens.fx, other_.lens.fy), far = a.hnormalized();
  const Eigen::Vector2d nearer = focal.cwiseProduct(e.z() * far - e.head<2>());
  const Eigen::Vector2d off = focal.cwiseProduct(seen->ray.hnormalized() - far);
  const double along = std::max(0.0, off.dot(nearer.stableNormalized()));
  return (off - along * nearer.stableNormalized()).norm();
}

}  // namespace slammot
