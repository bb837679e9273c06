#include "tests/estimators/posterior_bound.h"

#include <Eigen/Cholesky>

#include "models/camera_motion.h"
#include "models/points/observation.h"

namespace slammot::test {
namespace {

const PointFunctions& inverse_depth() { return find_point("inverse_depth"); }

// Rows of whitened residuals' Jacobian, of one landmark in all frames. The anchor is the first
// camera's position.
Eigen::MatrixXd pixel_rows(const Sequence& s, double pixel_sigma, int landmark,
                           const Eigen::Vector3d& y, Eigen::Index size) {
  const auto frames = static_cast<Eigen::Index>(s.frames.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2 * frames, size);
  for (Eigen::Index k = 0; k < frames; ++k) {
    const CameraState& camera = *s.truth[static_cast<std::size_t>(k)];
    const ObservedPixel seen = observe(s.camera, inverse_depth(), camera.position,
                                       camera.orientation, s.truth.front()->position, y)
                                   .value();
    auto rows = H.middleRows<2>(2 * k);
    rows.middleCols<6>(12 * k) = seen.J_pose;
    rows.middleCols<3>(kPosition) += seen.J_anchor;
    rows.middleCols<3>(12 * frames + 3 * landmark) = seen.J_y;
  }
  return H / pixel_sigma;
}

// Of w = x_k [-] f(x_(k-1)).
void add_motion(const Sequence& s, const MotionNoise& noise, std::size_t k, Eigen::MatrixXd& sum) {
  const double dt = s.frames[k].timestamp - s.frames[k - 1].timestamp;
  const CameraState& before = *s.truth[k - 1];
  Eigen::Matrix<double, kCameraDim, 2 * kCameraDim> J;
  J << -predict_jacobian(before, dt), Matrix12d::Identity();
  const auto at = static_cast<Eigen::Index>(12 * (k - 1));
  sum.block<24, 24>(at, at) += J.transpose() * camera_noise(noise, before, dt).llt().solve(J);
}

}  // namespace

Eigen::MatrixXd path_information(const Sequence& s, const Setup& setup) {
  const auto cameras = static_cast<Eigen::Index>(12 * s.frames.size());
  const auto size = cameras + static_cast<Eigen::Index>(3 * s.landmarks.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  sum.topLeftCorner<12, 12>().diagonal() = setup.initial.sigmas().array().pow(-2);
  for (std::size_t k = 1; k < s.frames.size(); ++k) add_motion(s, setup.camera_noise, k, sum);
  int landmark = 0;
  for (const auto& [track, truth] : s.landmarks) {
    const Eigen::Vector3d offset = truth.at(0)->position - s.truth.front()->position;
    const Eigen::MatrixXd H =
        pixel_rows(s, setup.pixel_sigma, landmark, point_at(inverse_depth(), offset), size);
    sum += H.transpose() * H;
    const Eigen::Index rho = cameras + 3 * landmark++ + 2;
    sum(rho, rho) += std::pow(setup.prior.inverse_depth_sigma, -2);
  }
  return sum;
}

Matrix12d last_camera_bound(const Eigen::MatrixXd& information, std::size_t frames) {
  const auto last = static_cast<Eigen::Index>(12 * (frames - 1));
  const Eigen::MatrixXd unit =
      Eigen::MatrixXd::Identity(information.rows(), information.cols()).middleCols<12>(last);
  return information.ldlt().solve(unit).middleRows<12>(last);
}

}  // namespace slammot::test
