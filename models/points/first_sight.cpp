#include "models/points/first_sight.h"

#include <Eigen/Cholesky>

#include "models/points/homogeneous.h"
#include "models/points/initialisation.h"
#include "models/points/observation.h"

namespace slammot {

namespace {

struct Minimum {
  Eigen::Vector3d u;
  Eigen::Matrix3d covariance;
  double square = 0.0;  // sum of squares
};

// Sum of squares at u with its normal equations; nothing where a camera does not see it.
class Problem {
 public:
  Problem(const Rig& rig, double pixel_sigma, const Observation& z,
          std::span<const Observation> others, const InverseDepthPrior& prior)
      : rig_(rig), pixel_sigma_(pixel_sigma), z_(z), others_(others), prior_(prior) {}

  std::optional<Minimum> minimum();

 private:
  bool linearise(const Eigen::Vector3d& u);
  void add_prior(const Eigen::Vector3d& u);

  const Rig& rig_;
  double pixel_sigma_;
  const Observation& z_;
  std::span<const Observation> others_;
  InverseDepthPrior prior_;
  Eigen::Matrix3d H_;  // J' J
  Eigen::Vector3d b_;  // -J' r
  double square_ = 0.0;
};

void Problem::add_prior(const Eigen::Vector3d& u) {
  const double pixel = 1.0 / z_.variance(pixel_sigma_);
  const double rho = 1.0 / (prior_.sigma * prior_.sigma);
  const Eigen::Vector3d weight(pixel, pixel, rho);
  Eigen::Vector3d r;
  r << u.head<2>() - z_.pixel, u.z() - prior_.inverse_depth;
  H_ = weight.asDiagonal();
  b_ = -weight.cwiseProduct(r);
  square_ = r.dot(weight.cwiseProduct(r));
}

// From where camera 0 stands, as any landmark that begins there.
bool Problem::linearise(const Eigen::Vector3d& u) {
  constexpr PointFunctions kPoint = point_row<Homogeneous>();  // regular at every u
  const Eigen::Quaterniond R = Eigen::Quaterniond::Identity();
  const Eigen::Vector3d r = Eigen::Vector3d::Zero();
  add_prior(u);
  const auto here = initialise(rig_.first(), kPoint, R, u.head<2>(), u.z());
  if (!here) return false;
  Eigen::Matrix3d J_u;
  J_u << here->J_pixel, here->J_inverse_depth;
  for (const Observation& z : others_) {
    const auto h = observe(rig_[z.camera], kPoint, r, R, r, here->y);
    if (!h) return false;
    const Matrix23d J = h->J_y * J_u;
    const Eigen::Vector2d residual = h->pixel - z.pixel;
    const double weight = 1.0 / z.variance(pixel_sigma_);
    H_ += weight * J.transpose() * J;
    b_ -= weight * J.transpose() * residual;
    square_ += weight * residual.squaredNorm();
  }
  return true;
}

// Gauss-Newton, a step being halved until it descends: rho is nearly linear in a pixel, so that few
// are needed.
std::optional<Minimum> Problem::minimum() {
  constexpr int kMostSteps = 50, kMostHalvings = 20;
  constexpr double kNothing = 1e-11;  // [sigma]
  Eigen::Vector3d u;
  u << z_.pixel, prior_.inverse_depth;
  if (!linearise(u)) return std::nullopt;
  for (int i = 0; i < kMostSteps; ++i) {
    const double before = square_;
    const Eigen::LLT<Eigen::Matrix3d> llt(H_);
    Eigen::Vector3d step = llt.solve(b_);
    if (step.dot(b_) < kNothing * kNothing) {
      return Minimum{u, llt.solve(Eigen::Matrix3d::Identity()), square_};
    }
    // Where nothing but rounding is left a step need not descend.
    const double rounding = 1e-12 * (1.0 + before);
    int halvings = 0;
    while (!linearise(u + step) || square_ > before + rounding) {
      if (++halvings > kMostHalvings) return std::nullopt;
      step *= 0.5;
    }
    u += step;
  }
  return std::nullopt;
}

}  // namespace

std::optional<InverseDepthPrior> prior_of_depth(const Camera& camera, const Observation& z) {
  const auto bearing = camera.unproject(z.pixel);
  if (!bearing) return std::nullopt;
  const double rho = 1.0 / (z.depth * bearing->ray.norm());
  return InverseDepthPrior{rho, rho * z.depth_sigma / z.depth};
}

FirstSight first_sight(const Rig& rig, double pixel_sigma, const Observation& z,
                       std::span<const Observation> others, const InverseDepthPrior& prior,
                       double threshold) {
  FirstSight seen;
  seen.z = z;
  seen.prior = prior;
  seen.pixel = z.pixel;
  std::optional<Minimum> best;
  for (const Observation& other : others) {
    std::vector<Observation> with = seen.others;
    with.push_back(other);
    const auto minimum = Problem(rig, pixel_sigma, z, with, prior).minimum();
    if (!minimum || minimum->square > threshold * static_cast<double>(with.size())) continue;
    seen.others = std::move(with);
    best = minimum;
  }
  seen.has_own_depth = z.has_depth() || best;
  if (best) {
    seen.pixel = best->u.head<2>();
    seen.inverse_depth = best->u.z();
    seen.covariance = best->covariance;
  }
  return seen;
}

}  // namespace slammot
