#include "eval/trajectory/last_scale.h"

#include <algorithm>
#include <cmath>

namespace slammot {

std::vector<CameraEstimate> in_last_scale(std::vector<CameraEstimate> path,
                                          std::span<const double> changes) {
  const auto is_known = [](double t) { return std::isfinite(t); };
  if (changes.size() != path.size() || !std::ranges::all_of(changes, is_known)) return {};
  double later = 0.0;
  for (std::size_t j = path.size(); j-- > 0; later += changes[j]) {
    CameraState& x = path[j].state;
    const Eigen::Vector3d origin = path.front().state.position;
    x.position = origin + std::exp(later) * (x.position - origin);
    x.velocity *= std::exp(later);
    path[j].covariance.setConstant(kUndefined);
  }
  return path;
}

}  // namespace slammot
