#include "smoothers/window/truth_linearisation.h"

#include "models/landmarks/true_state.h"
#include "smoothers/graph/least_noise.h"

namespace slammot {

std::vector<LandmarkVector> TruthLinearisation::states(const WindowLandmark& landmark) const {
  const LandmarkFunctions& model = *graph_.models().landmark;
  const GraphLandmark& l = graph_[landmark.id];
  const Eigen::Vector3d anchor = graph_.variables[l.anchor].point();
  const MotionVector w =
      l.is_free() ? MotionVector(graph_.variables[l.w].point()) : MotionVector::Zero(model.motion);
  LandmarkVector x = landmark_state(graph_.variables[l.y].point(), w);
  const auto base = cameras_.find(landmark.base);
  if (base == cameras_.frames().end()) return {x};
  std::vector<LandmarkVector> states;
  for (int i = 0; i <= l.steps(); ++i) {
    if (i > 0) x = model.predict(x, l.chain[static_cast<std::size_t>(i - 1)].dt);
    const int frame = (base + i)->index;
    x = true_state(*truth_, model, landmark.track, frame, anchor).value_or(x);
    states.push_back(x);
  }
  return states;
}

void TruthLinearisation::apply(const WindowLandmark& landmark) const {
  if (!truth_) return;
  const LandmarkFunctions& model = *graph_.models().landmark;
  GraphLandmark& l = graph_[landmark.id];
  const std::vector<LandmarkVector> x = states(landmark);
  graph_.variables[l.y].linearisation_point = x.front().head<3>();
  if (!l.is_free()) return;
  graph_.variables[l.w].linearisation_point = x.front().tail(model.motion);
  LandmarkVector at = x.front();
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    ChainStep& step = l.chain[i];
    step.F = model.predict_jacobian(at, step.dt);
    at = model.predict(at, step.dt);
    step.G = model.noise_root(at, graph_.models().prior.noise(step.is_moving), step.dt);
    step.noise_point = least_noise(step.G, x[i + 1] - at);
    at += step.G * *step.noise_point;
    step.point = at;
  }
}

std::optional<ObservedPixel> TruthLinearisation::observe(const WindowLandmark& landmark) const {
  const CameraState x = graph_.linearisation_point(cameras_.newest().camera);
  const Eigen::Vector3d anchor = graph_.variables[graph_[landmark.id].anchor].point();
  return slammot::observe(graph_.models().camera, graph_.models().point(), x.position,
                          x.orientation, anchor, states(landmark).back().head<3>());
}

}  // namespace slammot
