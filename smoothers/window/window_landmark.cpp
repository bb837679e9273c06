#include "smoothers/window/window_landmark.h"

#include <algorithm>

#include "smoothers/graph/chain_step.h"

namespace slammot {

void extend_chain(Graph& graph, LandmarkId id, Label label, double dt) {
  const LandmarkFunctions& model = *graph.models().landmark;
  GraphLandmark& l = graph[id];
  const LandmarkVector x = graph.newest_state(l);
  ChainStep step;
  step.dt = dt;
  step.is_moving = label == Label::kMoving;
  step.F = model.predict_jacobian(x, dt);
  step.x = model.predict(x, dt);
  step.point = step.x;
  step.G = model.noise_root(step.x, graph.models().prior.noise(step.is_moving), dt);
  step.unit = unit_of_motion(graph.models(), step.x.head<3>());
  step.noise.setZero(model.dim());
  l.chain.push_back(step);
}

void end_chain(GraphLandmark& l) {
  const int last = l.pixels.empty() ? 0 : l.pixels.back().depth;
  l.chain.resize(static_cast<std::size_t>(last));
}

const WindowFrame& base_of_release(const GraphLandmark& l, const CameraWindow& cameras) {
  if (l.pixels.empty()) return cameras.newest();
  auto frame = cameras.find(l.pixels.front().position);
  while (frame->timestamp < l.constrained->rest_time) ++frame;
  return *frame;
}

void begin_chain(Graph& graph, LandmarkId id, const WindowFrame& base,
                 const CameraWindow& cameras) {
  double time = base.timestamp;
  for (const WindowFrame& frame : cameras.frames()) {
    if (frame.number <= base.number) continue;
    extend_chain(graph, id, Label::kUnknown, frame.timestamp - time);
    time = frame.timestamp;
  }
  for (GraphPixel& pixel : graph[id].pixels) {
    pixel.depth = std::max(0, cameras.find(pixel.position)->number - base.number);
    pixel.J_w.resize(2, 0);
  }
}

}  // namespace slammot
