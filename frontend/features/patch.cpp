#include "frontend/features/patch.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace slammot {
namespace {

constexpr int kHalf = Patch::kHalf;
constexpr int kArea = Patch::kArea;
constexpr int kIterations = 20;
constexpr double kConverged = 0.01;   // [px], far below the noise
constexpr double kGreyNoise = 2.0;    // [grey levels] of a camera's pixel
constexpr double kWorstSigma = 0.15;  // [px] of the place of a patch under that noise
constexpr double kLeastArea = 0.25, kMostArea = 4.0;  // of the warp's determinant

using Values = Eigen::Matrix<double, kArea, 1>;

// Bilinear samples under the warp; false if one lies outside.
bool sample(const cv::Mat& image, const Warp& warp, Values& values) {
  const Eigen::Vector2d reach = kHalf * warp.A.cwiseAbs().rowwise().sum();
  if (!(warp.t.x() - reach.x() >= 0.0 && warp.t.y() - reach.y() >= 0.0 &&
        warp.t.x() + reach.x() < image.cols - 1 && warp.t.y() + reach.y() < image.rows - 1)) {
    return false;
  }
  int i = 0;
  for (int y = -kHalf; y <= kHalf; ++y) {
    for (int x = -kHalf; x <= kHalf; ++x, ++i) {
      const double u = warp.A(0, 0) * x + warp.A(0, 1) * y + warp.t.x();
      const double v = warp.A(1, 0) * x + warp.A(1, 1) * y + warp.t.y();
      const int column = static_cast<int>(u), row = static_cast<int>(v);
      const double a = u - column, b = v - row;
      const uchar* above = image.ptr<uchar>(row) + column;
      const uchar* below = above + image.step;
      values(i) = (1.0 - b) * ((1.0 - a) * above[0] + a * above[1]) +
                  b * ((1.0 - a) * below[0] + a * below[1]);
    }
  }
  return true;
}

// Zero mean and unit length; returns the length it had.
double normalise(Values& values) {
  values.array() -= values.mean();
  const double length = values.norm();
  if (length > 0.0) values /= length;
  return length;
}

// W(x) <- W(dW^-1(x)), dW(x) = (I + D) x + d.
Warp composed(const Warp& warp, const Eigen::Matrix<double, 6, 1>& step) {
  Eigen::Matrix2d B;
  B << 1.0 + step(0), step(1), step(2), 1.0 + step(3);
  Warp result;
  result.A = warp.A * B.inverse();
  result.t = warp.t - result.A * step.tail<2>();
  return result;
}

}  // namespace

std::optional<Patch> Patch::cut(const cv::Mat& image, const Eigen::Vector2d& centre) {
  Patch patch;
  Values right, left, below, above;
  const auto shifted = [&](double x, double y) {
    return Warp{Eigen::Matrix2d::Identity(), centre + Eigen::Vector2d(x, y)};
  };
  if (!sample(image, shifted(0, 0), patch.values_) || !sample(image, shifted(1, 0), right) ||
      !sample(image, shifted(-1, 0), left) || !sample(image, shifted(0, 1), below) ||
      !sample(image, shifted(0, -1), above)) {
    return std::nullopt;
  }
  const double length = normalise(patch.values_);
  if (!(length > 0.0)) return std::nullopt;
  const Values gx = (right - left) / (2.0 * length), gy = (below - above) / (2.0 * length);
  int i = 0;
  for (int y = -kHalf; y <= kHalf; ++y) {
    for (int x = -kHalf; x <= kHalf; ++x, ++i) {
      patch.gradients_.row(i) << gx(i) * x, gx(i) * y, gy(i) * x, gy(i) * y, gx(i), gy(i);
    }
  }
  using Hessian = Eigen::Matrix<double, 6, 6>;
  const Eigen::SelfAdjointEigenSolver<Hessian> solver(
      Hessian(patch.gradients_.transpose() * patch.gradients_));
  const auto& eigenvalues = solver.eigenvalues();
  if (!(eigenvalues(0) > 1e-8 * eigenvalues(5))) return std::nullopt;
  patch.inverse_hessian_ = solver.eigenvectors() * eigenvalues.cwiseInverse().asDiagonal() *
                           solver.eigenvectors().transpose();
  const double noise = kGreyNoise / length;
  const double variance = patch.inverse_hessian_.bottomRightCorner<2, 2>().trace() * noise * noise;
  if (!(variance < kWorstSigma * kWorstSigma)) return std::nullopt;
  patch.sigma_ = std::sqrt(variance / 2.0);
  return patch;
}

// Of least squares: s^2 H^-1, with s^2 the mean square of the residual; two more of its degrees of
// freedom are gain and bias.
double Patch::sigma_of(const Warp& warp, const Values& residual) const {
  const double s2 = residual.squaredNorm() / (kArea - 8);
  const Eigen::Matrix2d C = inverse_hessian_.bottomRightCorner<2, 2>();
  return std::sqrt(s2 * (warp.A * C * warp.A.transpose()).trace() / 2.0);
}

std::optional<Patch::Fit> Patch::align(const cv::Mat& image, const Warp& guess) const {
  Fit fit{guess};
  Values values;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (!sample(image, fit.warp, values)) return std::nullopt;
    if (!(normalise(values) > 0.0)) return std::nullopt;
    fit.correlation = values.dot(values_);
    const Eigen::Matrix<double, 6, 1> step =
        inverse_hessian_ * (gradients_.transpose() * (values - values_));
    fit.warp = composed(fit.warp, step);
    const double area = fit.warp.A.determinant();
    if (!(area > kLeastArea && area < kMostArea)) return std::nullopt;
    const double moved = (fit.warp.A * step.tail<2>()).norm();
    if (moved < kConverged && kHalf * step.head<4>().cwiseAbs().maxCoeff() < 10.0 * kConverged) {
      fit.sigma = sigma_of(fit.warp, values - values_);
      return fit;
    }
  }
  return std::nullopt;
}

}  // namespace slammot
