#include "smoothers/window/truth_linearisation.h"

#include "models/landmarks/true_state.h"

namespace slammot {

std::vector<Vector6d> TruthLinearisation::states(const WindowLandmark& l) const {
  const Eigen::Vector3d anchor = *graph_.variables().at(l.anchor).first;
  Vector6d x;
  x << graph_.point(l.y), l.w ? Eigen::Vector3d(graph_.point(*l.w)) : Eigen::Vector3d::Zero();
  const auto base = cameras_.find(l.base);
  if (base == cameras_.frames().end()) return {x};
  std::vector<Vector6d> states;
  for (std::size_t i = 0; i <= l.noises.size(); ++i) {
    if (i > 0) x = functions_.predict(x, l.chain->steps[i - 1].dt);
    const int frame = (base + static_cast<std::ptrdiff_t>(i))->index;
    x = true_state(*truth_, functions_, l.track, frame, anchor).value_or(x);
    states.push_back(x);
  }
  return states;
}

void TruthLinearisation::apply(const WindowLandmark& l) const {
  if (!truth_) return;
  const std::vector<Vector6d> x = states(l);
  graph_.linearise_at(l.y, x.front().head<3>());
  if (!l.w) return;
  graph_.linearise_at(*l.w, x.front().tail<3>());
  const auto noises = lead_through(*l.chain, x, sigma_a_);
  for (std::size_t i = 0; i < noises.size(); ++i) graph_.linearise_at(l.noises[i], noises[i]);
}

std::optional<ObservedPixel> TruthLinearisation::observe(const Camera& camera,
                                                         const WindowLandmark& l) const {
  const CameraState x = cameras_.linearisation_point(cameras_.newest());
  return slammot::observe(camera, x.position, x.orientation, graph_.point(l.anchor),
                          states(l).back().head<3>());
}

}  // namespace slammot
