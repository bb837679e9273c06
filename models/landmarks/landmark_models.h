// The table of landmark models (all_models.h adds one), each with every point parametrisation. What
// estimators use of a model M is gathered in a row of functions, so that an estimator is compiled
// once and not once for each model.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "models/landmarks/landmark.h"
#include "models/points/point_functions.h"

namespace slammot {

struct LandmarkFunctions {
  std::string_view name;
  std::string_view description;
  bool can_move = true;           // false: every landmark is static, whatever the classifier says
  int motion = 3;                 // numbers of w
  bool motion_in_metres = false;  // w grows with the scale; else it is in units of the depth
  PointFunctions point;           // of y

  int dim() const { return 3 + motion; }  // of x = (y, w)

  // As the members of the concept LandmarkModel; `noise_root` is landmark_noise_root().
  LandmarkVector (*predict)(const LandmarkVector& x, double dt);
  LandmarkMatrix (*predict_jacobian)(const LandmarkVector& x, double dt);
  LandmarkMatrix (*noise_root)(const LandmarkVector& predicted, const LandmarkPrior& prior,
                               double dt);
  MotionVector (*motion_of)(const Eigen::Vector3d& y, const Eigen::Vector3d& v);
  double (*density_scale)(const LandmarkVector& x);
  MotionVector (*prior_sigmas)(const LandmarkPrior& prior);
  Eigen::Vector3d (*velocity)(const LandmarkVector& x);
  VelocityJacobian (*velocity_jacobian)(const LandmarkVector& x);
};

// F_yw: of a landmark that rests at y, dy/dw had it moved with w for dt. 3 x motion.
inline BoundedMatrix<3, Eigen::Dynamic, 3, kMaxMotion> moved_from_rest(
    const LandmarkFunctions& landmark, const Eigen::Vector3d& y, double dt) {
  const LandmarkVector at_rest = landmark_state(y, MotionVector::Zero(landmark.motion));
  return landmark.predict_jacobian(at_rest, dt).topRightCorner(3, landmark.motion);
}

// The row of a model.
template <LandmarkModel M>
constexpr LandmarkFunctions landmark_row() {
  using X = StateOf<M>;
  return {M::kName,
          M::kDescription,
          true,
          M::kMotion,
          M::kMotionInMetres,
          point_row<typename M::Point>(),
          [](const LandmarkVector& x, double dt) -> LandmarkVector { return M::predict(X(x), dt); },
          [](const LandmarkVector& x, double dt) -> LandmarkMatrix {
            return M::predict_jacobian(X(x), dt);
          },
          [](const LandmarkVector& x, const LandmarkPrior& prior, double dt) -> LandmarkMatrix {
            return landmark_noise_root<M>(X(x), prior, dt);
          },
          [](const Eigen::Vector3d& y, const Eigen::Vector3d& v) -> MotionVector {
            return M::motion_of(y, v);
          },
          [](const LandmarkVector& x) { return M::density_scale(X(x)); },
          [](const LandmarkPrior& prior) -> MotionVector { return M::prior_sigmas(prior); },
          [](const LandmarkVector& x) -> Eigen::Vector3d { return M::velocity(X(x)); },
          [](const LandmarkVector& x) -> VelocityJacobian { return M::velocity_jacobian(X(x)); }};
}

// All rows: all models with the first parametrisation of point_table(), with the next, ...
std::span<const LandmarkFunctions> landmark_table();

// All models with one parametrisation.
std::span<const LandmarkFunctions> landmark_table(const PointFunctions& point);

// A model of a user's own program: a row for each parametrisation, as landmark_rows() of
// extra_model.h makes them. Before anything is looked up; throws std::invalid_argument for a name
// that is taken.
void add_landmarks(std::span<const LandmarkFunctions> rows);

// By the names of model and parametrisation; throws std::invalid_argument for an unknown one.
const LandmarkFunctions& find_landmark(const std::string& name, const std::string& point);

}  // namespace slammot
