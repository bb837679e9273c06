// The chi-square gate of all estimators: a measurement passes when its innovation is
// no longer, by its own covariance, than the stated part of correct ones are.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>

namespace slammot {

class PixelGate {
 public:
  // `probability` of a correct measurement passing; `pixel_sigma` [px].
  PixelGate(double probability, double pixel_sigma)
      : threshold_(-2.0 * std::log1p(-probability)), variance_(pixel_sigma * pixel_sigma) {}

  // nu' S^-1 nu with S = H P H' + sigma^2 I.
  double nis(const Eigen::Vector2d& nu, const Eigen::Matrix2d& HPHt) const {
    Eigen::Matrix2d S = HPHt;
    S.diagonal().array() += variance_;
    return nu.dot(S.inverse() * nu);
  }

  bool passes(double nis) const { return nis <= threshold_; }  // NaN does not

 private:
  double threshold_;  // chi-square quantile with 2 degrees of freedom, in closed form
  double variance_;
};

}  // namespace slammot
