// What happens to free landmarks in the window: a chain grows with each frame, and it ends when the
// landmark becomes static by a condition, or is pruned.
#include "smoothers/window/window_belief.h"

namespace slammot {

// One step more, thesis (2.5), with the acceleration noise of unknown and moving landmarks.
void Window::extend(WindowLandmark& landmark, Label label, double dt) {
  GraphLandmark& l = graph_[landmark.id];
  const LandmarkVector x = graph_.newest_state(l);
  ChainStep step;
  step.dt = dt;
  step.is_moving = label == Label::kMoving;
  step.F = functions_.predict_jacobian(x, dt);
  step.x = functions_.predict(x, dt);
  step.point = step.x;
  step.G = functions_.noise_root(step.x, setup_.prior.noise(step.is_moving), dt);
  step.noise.setZero(functions_.dim());
  l.chain.push_back(step);
  truth_.apply(landmark);
}

// Steps after the last measurement say nothing; they are removed.
void Window::end_chain(WindowLandmark& landmark) {
  GraphLandmark& l = graph_[landmark.id];
  const int last = l.pixels.empty() ? 0 : l.pixels.back().depth;
  l.chain.resize(static_cast<std::size_t>(last));
}

}  // namespace slammot
