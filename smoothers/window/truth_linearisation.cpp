#include "smoothers/window/truth_linearisation.h"

#include "models/landmarks/true_state.h"

namespace slammot {

std::vector<LandmarkVector> TruthLinearisation::states(const WindowLandmark& l) const {
  const Eigen::Vector3d anchor = linearisation_point(graph_, l.anchor);
  LandmarkVector x = landmark_state(linearisation_point(graph_, l.y),
                                    l.w ? MotionVector(linearisation_point(graph_, *l.w))
                                        : MotionVector::Zero(functions_.motion));
  const auto base = cameras_.find(l.base);
  if (base == cameras_.frames().end()) return {x};
  std::vector<LandmarkVector> states;
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
  const std::vector<LandmarkVector> x = states(l);
  graph_.variable(l.y).linearisation_point = x.front().head<3>();
  if (!l.w) return;
  graph_.variable(*l.w).linearisation_point = x.front().tail(functions_.motion);
  const auto noises = lead_through(*l.chain, x, prior_);
  for (std::size_t i = 0; i < noises.size(); ++i) {
    graph_.variable(l.noises[i]).linearisation_point = noises[i];
  }
}

std::optional<ObservedPixel> TruthLinearisation::observe(const Camera& camera,
                                                         const WindowLandmark& l) const {
  const CameraState x = cameras_.linearisation_point(cameras_.newest());
  return slammot::observe(camera, x.position, x.orientation, linearisation_point(graph_, l.anchor),
                          states(l).back().head<3>());
}

}  // namespace slammot
