// Linearisation `ideal` of the window's landmarks: Jacobians at the true states, in simulation
// only. It shows what a smoother loses by not knowing where to linearise.
#pragma once

#include "smoothers/window/camera_window.h"
#include "smoothers/window/window_landmark.h"

namespace slammot {

class TruthLinearisation {
 public:
  // Without a truth it does nothing.
  TruthLinearisation(std::shared_ptr<const Truth> truth, Graph& graph, const CameraWindow& cameras)
      : truth_(std::move(truth)), graph_(graph), cameras_(cameras) {}

  explicit operator bool() const { return truth_ != nullptr; }

  // The landmark's linearisation points and the G of its chain are the truth's from now on.
  void apply(const WindowLandmark& landmark) const;

  // The newest measurement's h and Jacobians there; nothing where it is not in view.
  std::optional<ObservedPixel> observe(const WindowLandmark& landmark) const;

 private:
  // The true states of its chain, base to newest. Where the truth has no row, predicted from the
  // point before; a landmark labelled static stays where it was then.
  std::vector<LandmarkVector> states(const WindowLandmark& landmark) const;

  std::shared_ptr<const Truth> truth_;
  Graph& graph_;
  const CameraWindow& cameras_;
};

}  // namespace slammot
