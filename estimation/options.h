// What all estimators share beyond the sequence's own statements: which models, which thresholds,
// which policy. A difference between two estimators run with equal ModelOptions is a difference
// between estimators.
#pragma once

#include <string>

namespace slammot {

// Admission, removal and the size of the map; see track_policy.h.
struct TrackPolicy {
  int max_landmarks = 1000;    // landmarks in the state at once; later births wait
  int max_visible = 60;        // births wait while this many landmarks are being measured
  int lost_after = 5;          // frames without an accepted measurement until a landmark is lost
  int missed_after = 30;       // frames that should have shown it, until a static one is lost
  std::string retain = "map";  // map: static landmarks stay while unseen; window: they are lost too
};

struct ClassifierOptions {
  std::string name = "thesis";    // a row of classifier_table()
  double static_threshold = 1.6;  // t_s [(m/s)^-3], thesis (3.1)
  double moving_threshold =
      3.583;                     // t_m, thesis (3.2): sqrt of the 0.995 quantile of chi-square(3)
  double static_factor = 100.0;  // bayes_factor: odds for v = 0 from which a landmark is static
  double moving_factor = 0.01;   // bayes_factor: odds for v = 0 below which it is moving
};

// Whether labels may be taken back; see label_policy.h.
struct LabelOptions {
  std::string name = "reversible";  // one_way (thesis) | reversible
  int window = 10;                  // reversible: innovations that testify against a static label
  double probability = 1e-4;        // reversible: of a right label being rejected in a frame
};

struct ModelOptions {
  std::string landmark = "scaled_velocity";  // a row of the estimators' landmark tables
  std::string collapse =
      "condition";  // on static: `drop` marginalises v (thesis), `condition` uses v = 0
  double gate_probability = 0.95;  // of a correct measurement passing the chi-square gate
  ClassifierOptions classifier;
  LabelOptions labels;
  TrackPolicy policy;
  std::string depth_prior = "auto";  // of newborn landmarks: stated | map | auto, see depth_prior.h
};

}  // namespace slammot
