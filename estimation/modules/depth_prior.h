// The Gaussian that a new landmark's inverse depth has before it is measured again.
//
// `fixed`: N(rho0, sigma_rho^2) for every landmark, as the sequence or the user states it.
// `empirical`: learnt in every frame from the established static landmarks that this frame
// measured, so that it follows the scene, and a wrong statement decides only about landmarks
// initialised before any other is known: those of the first frame.
//
// Bias of first sight. Landmarks are not initialised where the camera finds them later: most come
// into view far ahead and are then approached. What is learnt are therefore their inverse depths at
// birth, which is what rho of a static landmark is (the distance from its anchor), and not those
// from the present camera: on `circle` the latter have a mean 35 to 45% above that of the births.
// What remains: those that pass close by leave soon and are seldom in the sample, so that the
// births have a longer tail towards the camera than any Gaussian learnt here or stated.
//
// The sample's errors are taken as independent of the map's. They are not: a map whose scale is off
// learns a prior whose scale is as much off, and does not know it. Beside a shared mean
// (LandmarkPrior::mean_sigma), a state that is correlated with the map as it should be, the mean of
// a birth is that state, and only its spread and the motion's prior are learnt here.
//
// `auto`: `empirical` where a landmark known beforehand or the first velocity holds the scale. Else
// the statement is all that holds it, and it is kept.
#pragma once

#include <span>

#include "estimation/options.h"
#include "estimation/seen_depth.h"
#include "models/measurement.h"

namespace slammot {

// `fixed` with the mean and sigma of the inverse depth learnt. Conjugate (normal, inverse
// chi-square), the statement counting as one landmark; the result is the Gaussian with the moments
// of the predictive Student distribution, which is wider the smaller the sample. The statement
// itself with fewer than three established landmarks. `seen` is reordered, and what is much nearer
// than the rest moved back.
LandmarkPrior learnt_depth_prior(const LandmarkPrior& stated, std::span<SeenDepth> seen);

// Whether the first velocity is known to half of itself.
bool holds_scale(const InitialCamera& camera);

// Whether depths are learnt from the map; kAuto: where something else holds the scale.
bool learns_depths(DepthPriorSource source, const InitialCamera& camera, bool some_are_known);

class DepthPrior {
 public:
  DepthPrior(bool learns, const LandmarkPrior& stated)
      : learns_(learns), stated_(stated), of_new_(stated) {}

  bool learns() const { return learns_; }
  void learn(std::span<SeenDepth> seen) { of_new_ = learnt_depth_prior(stated_, seen); }
  bool has_learnt() const { return of_new_.inverse_depth != stated_.inverse_depth; }

  // Of a landmark initialised now.
  const LandmarkPrior& of_new() const { return of_new_; }

 private:
  bool learns_;
  LandmarkPrior stated_, of_new_;
};

}  // namespace slammot
