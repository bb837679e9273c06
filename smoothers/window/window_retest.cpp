// `window.retest`: after a frame's update every measurement in the window meets the gate again,
// given all others, at an estimate that later frames have improved. One that fails is let go, one
// that was refused and now passes enters.
//
// The NIS is that of given_others.h, the threshold that of `gate.given_others`. Of each landmark
// only the worst is let go in a frame: an outlier makes its neighbours look wrong (Baarda's data
// snooping, 1968). A first pixel stays: without it the landmark is not determined.
#include <algorithm>

#include "smoothers/window/window_belief.h"

namespace slammot {

// What belongs to frames that have left is forgotten.
void Window::note_refused(std::span<const Observation> accepted) {
  std::erase_if(refused_, [&](const RefusedPixel& z) {
    return cameras_.find(z.position) == cameras_.frames().end();
  });
  for (const Observation& z : gated_) {
    if (std::ranges::find(accepted, z.track, &Observation::track) != accepted.end()) continue;
    refused_.push_back({z, cameras_.newest().camera.position});
  }
}

void Window::forget_refused(int track) {
  std::erase_if(refused_, [&](const RefusedPixel& refused) { return refused.z.track == track; });
}

bool Window::retest() {
  retested_.clear();
  for (const auto& [track, landmark] : landmarks_) retest_held(landmark);
  for (const WindowLandmark& landmark : pruned_) retest_held(landmark);
  for (const RefusedPixel& z : refused_) retest_refused(z);
  const std::vector<double> nis = given_others_.nis(optimiser_.equations());
  for (std::size_t i = 0; i < nis.size(); ++i) retested_[i].nis = nis[i];
  const RetestCounts before = retest_counts_;
  for (auto first = retested_.begin(); first != retested_.end();) {
    const auto next = std::find_if(first, retested_.end(), [&](const RetestedPixel& z) {
      return z.landmark != first->landmark || z.is_held != first->is_held;
    });
    if (first->is_held) {
      const auto worst = std::ranges::max_element(first, next, {}, &RetestedPixel::nis);
      if (!(worst->nis <= threshold_given_others_)) let_go(*worst);
    } else {
      std::for_each(first, next, [&](const RetestedPixel& z) {
        if (z.nis <= threshold_given_others_) admit(z);
      });
    }
    first = next;
  }
  return retest_counts_ != before;
}

void Window::retest_held(const WindowLandmark& landmark) {
  const GraphLandmark& l = graph_[landmark.id];
  if (is_inactive(l.y)) return;
  const NormalEquations& equations = optimiser_.equations();
  for (int i = 0; i < std::ssize(l.pixels); ++i) {
    const GraphPixel& pixel = l.pixels[static_cast<std::size_t>(i)];
    if (!pixel.valid || pixel.z.here) continue;
    given_others_.add(equations, equations.block(landmark.id), i, pixel.at.r, true);
    const Observation z{landmark.track, pixel.z.pixel, pixel.z.relative_sigma};
    retested_.push_back({landmark.id, {z, pixel.position}, true, 0.0});
  }
}

// In a copy of the landmark, which alone is linearised and eliminated anew.
void Window::retest_refused(const RefusedPixel& refused) {
  const WindowLandmark& landmark = landmarks_.at(refused.z.track);
  if (is_inactive(graph_[landmark.id].y)) return;
  GraphLandmark l = graph_[landmark.id];
  const int place = insert_pixel(l, landmark, refused);
  graph_.linearise(l);
  if (!l.pixels[static_cast<std::size_t>(place)].valid) return;
  LandmarkBlock block;
  block.eliminate(graph_, l, 0.0);
  given_others_.add(optimiser_.equations(), block, place, block.weighed_residual(place), false);
  retested_.push_back({landmark.id, refused, false, 0.0});
}

// In the order of frames. Those before the base of a free landmark are of the time when it was
// static.
int Window::insert_pixel(GraphLandmark& l, const WindowLandmark& landmark,
                         const RefusedPixel& refused) const {
  const WindowFrame& frame = *cameras_.find(refused.position);
  GraphPixel pixel;
  pixel.position = frame.camera.position;
  pixel.orientation = frame.camera.orientation;
  pixel.z = {refused.z.pixel, refused.position == l.anchor, refused.z.relative_sigma};
  pixel.at = {Eigen::Vector2d::Zero(), Eigen::Matrix<double, 2, 6>::Zero(), Matrix23d::Zero(),
              Matrix23d::Zero()};  // not linearised yet
  if (l.is_free()) pixel.depth = std::max(0, frame.number - cameras_.find(landmark.base)->number);
  const auto later = std::ranges::find_if(l.pixels, [&](const GraphPixel& other) {
    return cameras_.find(other.position)->number > frame.number;
  });
  const auto place = later - l.pixels.begin();
  l.pixels.insert(later, pixel);
  return static_cast<int>(place);
}

void Window::let_go(const RetestedPixel& z) {
  ++retest_counts_.let_go;
  std::erase_if(graph_[z.landmark].pixels,
                [&](const GraphPixel& pixel) { return pixel.position == z.at.position; });
  const auto landmark = landmarks_.find(z.at.z.track);
  if (landmark == landmarks_.end() || landmark->second.id != z.landmark) return;  // pruned
  forget_pixel(z.at.z.track, z.at.position);
  refused_.push_back(z.at);
}

void Window::admit(const RetestedPixel& z) {
  ++retest_counts_.admitted;
  WindowLandmark& landmark = landmarks_.at(z.at.z.track);
  const WindowFrame& frame = *cameras_.find(z.at.position);
  insert_pixel(graph_[z.landmark], landmark, z.at);
  landmark.last_used = std::max(landmark.last_used, frame.index);
  std::erase_if(refused_, [&](const RefusedPixel& other) {
    return other.z.track == z.at.z.track && other.position == z.at.position;
  });
  if (histories_) histories_->measured(z.at.z, frame.number);
}

}  // namespace slammot
