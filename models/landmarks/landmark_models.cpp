#include "models/landmarks/landmark_models.h"

#include "models/find_row.h"
#include "models/landmarks/dynamic_inverse_depth.h"
#include "models/landmarks/scaled_velocity.h"

namespace slammot {
namespace {

template <LandmarkModel M>
constexpr LandmarkFunctions row(std::string_view description) {
  return {M::kName,
          description,
          true,
          [](const Vector6d& x, double dt) { return M::predict(x, dt); },
          [](const Vector6d& x, double dt) { return M::predict_jacobian(x, dt); },
          [](const Vector6d& x, double sigma_a, double dt) {
            return landmark_noise_root<M>(x, sigma_a, dt);
          },
          [](const Eigen::Vector3d& y, const Eigen::Vector3d& v) { return M::motion_of(y, v); },
          [](const Vector6d& x) { return M::density_scale(x); },
          [](const LandmarkPrior& prior) { return M::prior_sigma(prior); },
          [](const Vector6d& x) { return M::velocity(x); },
          [](const Vector6d& x) { return M::velocity_jacobian(x); }};
}

// Static points only: a model whose landmarks never become free, so that any M serves.
constexpr LandmarkFunctions inverse_depth() {
  LandmarkFunctions functions = row<DynamicInverseDepth>("static points only, Civera et al. 2008");
  functions.name = "inverse_depth";
  functions.can_move = false;
  return functions;
}

constexpr LandmarkFunctions kTable[] = {
    inverse_depth(),
    row<DynamicInverseDepth>("the thesis: inverse depth and velocity in metres (2.3)"),
    row<ScaledVelocity>("velocity times inverse depth: modified polar coordinates"),
};

}  // namespace

std::span<const LandmarkFunctions> landmark_table() { return kTable; }

const LandmarkFunctions& find_landmark(const std::string& name) {
  return find_row(landmark_table(), name, "landmark model");
}

}  // namespace slammot
