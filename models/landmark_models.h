// The table of landmark models: one line adds one. What estimators use of a model M is gathered in
// a row of functions, so that an estimator is compiled once and not once for each model.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "slammot/models/landmark.h"
#include "slammot/models/landmark_estimate.h"
#include "slammot/models/options.h"

namespace slammot {

struct LandmarkFunctions {
  std::string_view name;
  std::string_view description;
  bool can_move = true;  // false: every landmark is static, whatever the classifier says

  Vector6d (*predict)(const Vector6d& x, double dt);
  Matrix6d (*predict_jacobian)(const Vector6d& x, double dt);
  Matrix6d (*noise_root)(const Vector6d& predicted, double sigma_a, double dt);
  Eigen::Vector3d (*motion_of)(const Eigen::Vector3d& y, const Eigen::Vector3d& v);
  double (*density_scale)(const Vector6d& x);
  double (*prior_sigma)(const LandmarkPrior& prior);
  LandmarkEstimate (*estimate)(const TrackRecord& record, const LandmarkBelief& belief);
};

std::span<const LandmarkFunctions> landmark_table();

// Throws std::invalid_argument for an unknown name.
const LandmarkFunctions& find_landmark(const std::string& name);

// The classifier options a landmark model leaves room for.
inline ClassifierOptions classifier_for(const LandmarkFunctions& landmark,
                                        ClassifierOptions options) {
  if (!landmark.can_move) options.name = "all_static";
  return options;
}

}  // namespace slammot
