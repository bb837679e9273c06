// The table of landmark models: one line adds one. What estimators use of a model M is gathered in
// a row of functions, so that an estimator is compiled once and not once for each model.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "models/landmarks/landmark.h"

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
  Eigen::Vector3d (*velocity)(const Vector6d& x);
  Matrix36d (*velocity_jacobian)(const Vector6d& x);
};

std::span<const LandmarkFunctions> landmark_table();

// Throws std::invalid_argument for an unknown name.
const LandmarkFunctions& find_landmark(const std::string& name);

}  // namespace slammot
