// The posterior Cramer-Rao bound (Van Trees 1968; Tichavsky, Muravchik & Nehorai 1998) of the last
// camera, and the covariance of an EKF linearised at the truth of one trajectory (estimator
// `ideal_covariance`).
//
// The information of the whole path and of all landmarks is that of prior, motion and pixels, each
// linearised at the truth, in *expectation* over prior, motion and noise. The bound is a block of
// its inverse; Tichavsky's recursion is the same inverse, eliminating one camera at a time.
//
// The world is `model_matched` with static landmarks of frame 0 at given pixels, so that all draws
// have the same variables: drawn are the camera's start and path, the depths and the pixel noise.
// No image edge ends a track, for what an edge selects has no Fisher information.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "datasets/simulation/random/random_stream.h"
#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "eval/run/run.h"
#include "eval/statistics/statistics.h"
#include "models/points/observation.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

constexpr int kFrames = 20, kLandmarks = 20;
constexpr int kCameras = kCameraDim * kFrames, kSize = kCameras + 3 * kLandmarks;

// The scenario's own priors, and priors so narrow that the information hardly depends on the draw.
const ScenarioOverrides kWide = {{"frames", "20"}, {"known", "0"}};
const ScenarioOverrides kNarrow = {{"frames", "20"},
                                   {"known", "0"},
                                   {"inverse_depth_sigma", "0.002"},
                                   {"acceleration", "0.05"},
                                   {"angular_acceleration", "0.02"},
                                   {"initial_velocity_sigma", "0.02"},
                                   {"initial_angular_velocity_sigma", "0.01"}};

Sequence draw(const ScenarioOverrides& world, unsigned seed) {
  Sequence s = simulate("model_matched", world, seed);
  RandomStream pixels(1, "given pixels"), depths(seed, "depths"), noise(seed, "pixel noise");
  const CameraState& first = *s.truth.front();
  s.landmarks.clear();
  for (int track = 0; track < kLandmarks; ++track) {
    const double u = pixels.uniform(0.0, s.camera.width);
    const double v = pixels.uniform(0.0, s.camera.height);
    const Eigen::Vector3d ray = s.camera.unproject({u, v})->ray.normalized();
    const double rho = s.prior->inverse_depth + s.prior->inverse_depth_sigma * depths.normal();
    const Eigen::Vector3d position = first.position + first.orientation * (ray / rho);
    s.landmarks[track].by_frame[0] = {position, Eigen::Vector3d::Zero()};
  }
  for (std::size_t i = 0; i < s.frames.size(); ++i) {
    const CameraState& x = *s.truth[i];
    s.frames[i].observations.clear();
    for (const auto& [track, landmark] : s.landmarks) {
      const Eigen::Vector3d ray =
          x.orientation.conjugate() * (landmark.at(0)->position - x.position);
      const Eigen::Vector2d error = s.pixel_sigma * noise.normals<2>();
      s.frames[i].observations.push_back({track, s.camera.project(ray)->pixel + error});
    }
  }
  return s;
}

// Landmarks are drawn from the stated prior, and nothing is rejected.
Configuration stated() {
  Configuration configuration;
  configuration.model.depth_prior = DepthPriorSource::kFixed;
  configuration.model.gate = {1.0, 1.0};
  return configuration;
}

// Of each camera 12 numbers (camera_state.h), then of each landmark 3 (inverse_depth.h), at the
// truth of one draw.
Eigen::MatrixXd path_information(const Sequence& s) {
  const slammot::Setup setup = make_setup(s, stated());
  const PointFunctions& point = find_point("inverse_depth");
  const Eigen::Vector3d anchor = s.truth.front()->position;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kSize, kSize);
  sum.topLeftCorner<12, 12>().diagonal() = setup.initial.sigmas().array().pow(-2);
  for (int k = 1; k < kFrames; ++k) {  // of w = x_k [-] f(x_(k-1))
    const auto i = static_cast<std::size_t>(k);
    const double dt = s.frames[i].timestamp - s.frames[i - 1].timestamp;
    const CameraState& before = *s.truth[i - 1];
    Eigen::Matrix<double, kCameraDim, 2 * kCameraDim> J;
    J << -predict_jacobian(before, dt), Matrix12d::Identity();
    sum.block<24, 24>(12 * (k - 1), 12 * (k - 1)) +=
        J.transpose() * camera_noise(setup.camera_noise, before, dt).llt().solve(J);
  }
  int at = kCameras;
  for (const auto& [track, truth] : s.landmarks) {
    const Eigen::Vector3d y = point_at(point, truth.at(0)->position - anchor);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2 * kFrames, kSize);  // of its whitened pixels
    for (int k = 0; k < kFrames; ++k) {
      const CameraState& x = *s.truth[static_cast<std::size_t>(k)];
      const ObservedPixel seen =
          observe(s.camera, point, x.position, x.orientation, anchor, y).value();
      auto rows = H.middleRows<2>(2 * k);
      rows.middleCols<6>(12 * k) = seen.J_pose / setup.pixel_sigma;
      rows.middleCols<3>(kPosition) += seen.J_anchor / setup.pixel_sigma;
      rows.middleCols<3>(at) = seen.J_y / setup.pixel_sigma;
    }
    sum += H.transpose() * H;
    sum(at + 2, at + 2) += std::pow(setup.prior.inverse_depth_sigma, -2);
    at += 3;
  }
  return sum;
}

// The last camera's block of the inverse.
Matrix12d last_camera_bound(const Eigen::MatrixXd& information) {
  const Eigen::MatrixXd unit =
      Eigen::MatrixXd::Identity(kSize, kSize).middleCols<12>(kCameras - 12);
  return information.ldlt().solve(unit).middleRows<12>(kCameras - 12);
}

CameraEstimate last(const Sequence& sequence, const char* estimator) {
  const RunResult run = run_estimator(sequence, stated(), estimator);
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.totals.rejected + run.totals.out_of_view, 0);
  return run.filtered.back();
}

// The information along one trajectory is what `ideal_covariance` inverts.
TEST(PosteriorBound, OfASingleDrawIsTheIdealCovariance) {
  const Sequence sequence = draw(kWide, 1);
  const Matrix12d P = last(sequence, "ideal_covariance").covariance;
  EXPECT_LT(test::relative_difference(last_camera_bound(path_information(sequence)), P), 1e-6);
}

TEST(PosteriorBound, IsAttainedAndNotBeatenByTheEkf) {
  constexpr unsigned kDraws = 100, kOfTheBound = 20;
  constexpr double kNormal = 3.291;  // two-sided 99.9%
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kSize, kSize);
  std::vector<double> squares;
  for (unsigned seed = 1; seed <= kDraws; ++seed) {
    const Sequence sequence = draw(kNarrow, seed);
    if (seed <= kOfTheBound) information += path_information(sequence) / kOfTheBound;
    const CameraState estimate = last(sequence, "true_labels").state;
    squares.push_back((estimate.position - sequence.truth.back()->position).squaredNorm());
  }
  const double bound = last_camera_bound(information).topLeftCorner<3, 3>().trace();
  const double centre = mean(squares);
  double deviation = 0.0;
  for (const double x : squares) deviation += (x - centre) * (x - centre) / (kDraws - 1.0);
  const double half = kNormal * std::sqrt(deviation / kDraws);
  std::printf("mean squared error over the bound: [%.3f, %.3f]\n", (centre - half) / bound,
              (centre + half) / bound);
  EXPECT_GT(centre + half, bound);
  EXPECT_LT(centre - half, bound);
}

}  // namespace
}  // namespace slammot
