// What happens to free landmarks in the window: a chain grows with each frame, its base shifts when
// the frame it stands in leaves, and it ends when the landmark becomes static or is pruned.
#pragma once

#include <set>

#include "estimation/estimator.h"
#include "smoothers/solver/marginalise.h"
#include "smoothers/window/truth_linearisation.h"

namespace slammot {

class FreeLandmarks {
 public:
  FreeLandmarks(const Setup& setup, const LandmarkFunctions& functions,
                const ceres::LossFunction* loss, const TruthLinearisation& truth, Graph& graph)
      : setup_(setup), functions_(functions), loss_(loss), truth_(truth), graph_(graph) {}

  // The factor of a pixel; of a static landmark too.
  WindowPixel measure(const WindowLandmark& landmark, const MeasuredPixel& z);

  // w with its prior (2.6), and a chain without steps.
  void start(WindowLandmark& landmark, const LandmarkPrior& prior);

  // One step more, thesis (2.5), with the acceleration noise of unknown and moving landmarks.
  void extend(WindowLandmark& landmark, double dt);

  // The noises follow the depth (landmark_chain.h); returns the largest change of one [sigma].
  double refresh_noises(WindowLandmark& landmark);

  // The frame of the base leaves. Before it is marginalised: the substitution that takes the base
  // one step on, or nothing when the chain has ended and all of it leaves. Measurements of later
  // frames are taken out. After: they are put back on the shifted base.
  std::vector<Advance> release_base(WindowLandmark& landmark, std::set<VariableId>& leaving);
  void shift_base(WindowLandmark& landmark, VariableId base);

  // Steps after the last measurement say nothing; they are removed.
  void end(WindowLandmark& landmark);

  // It becomes static, (3.3). `condition`: w and all noises are zero, and the window's measurements
  // are those of one point. `drop`: the base moves on to the newest frame; w and the noises are
  // marginalised, and with them the window's measurements of the landmark.
  void condition(WindowLandmark& landmark);
  void drop(WindowLandmark& landmark);

 private:
  Advance advance(const WindowLandmark& landmark, const LandmarkVector& from,
                  std::size_t step) const;
  void forget_chain(WindowLandmark& landmark);

  const Setup& setup_;
  const LandmarkFunctions& functions_;
  const ceres::LossFunction* loss_;
  const TruthLinearisation& truth_;
  Graph& graph_;
};

}  // namespace slammot
