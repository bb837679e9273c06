// The posterior Cramer-Rao bound, and what it is not: the covariance of an EKF linearised at the
// truth of one trajectory (estimator `ideal_covariance`).
//
// The world is `model_matched` with static landmarks of frame 0 at given pixels, so that all draws
// have the same variables: drawn are the camera's start and path, the depths and the pixel noise.
// No image edge ends a track, for what an edge selects has no Fisher information.
#include "tests/estimators/fixture/posterior_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "datasets/simulation/scenario.h"
#include "datasets/simulation/scene/random_stream.h"
#include "eval/configuration/setup.h"
#include "eval/run/run.h"
#include "eval/statistics/chi_square.h"
#include "eval/statistics/statistics.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

constexpr int kFrames = 20, kLandmarks = 20;
constexpr double kNormal = 3.291;  // two-sided 99.9%

// The scenario's own priors, and priors so narrow that the information hardly depends on the draw.
const ScenarioOverrides kWide = {{"frames", "20"}, {"known", "0"}};
const ScenarioOverrides kNarrow = {{"frames", "20"},
                                   {"known", "0"},
                                   {"inverse_depth_sigma", "0.002"},
                                   {"acceleration", "0.05"},
                                   {"angular_acceleration", "0.02"},
                                   {"initial_velocity_sigma", "0.02"},
                                   {"initial_angular_velocity_sigma", "0.01"}};

void place_landmarks(Sequence& sequence, unsigned seed) {
  RandomStream pixels(1, "given pixels"), depths(seed, "depths");
  const CameraState& first = *sequence.truth.front();
  const LandmarkPrior& prior = *sequence.prior;
  sequence.landmarks.clear();
  for (int track = 0; track < kLandmarks; ++track) {
    const double u = pixels.uniform(0.0, sequence.camera.width);
    const double v = pixels.uniform(0.0, sequence.camera.height);
    const Eigen::Vector3d ray = sequence.camera.unproject({u, v})->ray.normalized();
    const double rho = prior.inverse_depth + prior.inverse_depth_sigma * depths.normal();
    const Eigen::Vector3d position = first.position + first.orientation * (ray / rho);
    sequence.landmarks[track].by_frame[0] = {position, Eigen::Vector3d::Zero()};
  }
}

void measure_all(Sequence& sequence, unsigned noise_seed) {
  RandomStream random(noise_seed, "pixel noise");
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const CameraState& camera = *sequence.truth[i];
    Frame& frame = sequence.frames[i];
    frame.observations.clear();
    for (const auto& [track, landmark] : sequence.landmarks) {
      const Eigen::Vector3d ray =
          camera.orientation.conjugate() * (landmark.at(0)->position - camera.position);
      const Eigen::Vector2d error = sequence.pixel_sigma * random.normals<2>();
      frame.observations.push_back({track, sequence.camera.project(ray)->pixel + error});
    }
  }
}

Sequence draw(const ScenarioOverrides& world, unsigned seed) {
  Sequence sequence = simulate("model_matched", world, seed);
  place_landmarks(sequence, seed);
  measure_all(sequence, seed);
  return sequence;
}

// Landmarks are drawn from the stated prior.
Configuration stated() {
  Configuration configuration;
  configuration.model.depth_prior = DepthPriorSource::kFixed;
  return configuration;
}

Eigen::MatrixXd information_of(const Sequence& sequence) {
  return test::path_information(sequence, make_setup(sequence, stated()));
}

CameraEstimate last(const Sequence& sequence, const char* estimator) {
  Configuration configuration = stated();
  configuration.model.gate = {1.0, 1.0};
  const RunResult run = run_estimator(sequence, configuration, estimator);
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.totals.rejected + run.totals.out_of_view, 0);
  return run.filtered.back();
}

double variance(const Matrix12d& P) { return P.topLeftCorner<3, 3>().trace(); }  // of the position

double squared_error(const Sequence& sequence) {
  const CameraState estimate = last(sequence, "true_labels").state;
  return (estimate.position - sequence.truth.back()->position).squaredNorm();
}

// Mean and its 99.9% interval.
Interval interval_of(const std::vector<double>& samples) {
  const double centre = mean(samples), n = static_cast<double>(samples.size());
  double squares = 0.0;
  for (const double x : samples) squares += (x - centre) * (x - centre);
  const double half = kNormal * std::sqrt(squares / (n - 1.0) / n);
  return {centre - half, centre + half};
}

struct Bound {
  Matrix12d bound;                           // from the mean of the information
  Matrix12d mean_ideal = Matrix12d::Zero();  // mean of its inverse
  std::vector<double> ideal;                 // position's variance in each draw
};

Bound bound_of(const ScenarioOverrides& world, unsigned draws) {
  Bound result;
  Eigen::MatrixXd sum = information_of(draw(world, 1));
  sum.setZero();
  for (unsigned seed = 1; seed <= draws; ++seed) {
    const Eigen::MatrixXd information = information_of(draw(world, seed));
    const Matrix12d P = test::last_camera_bound(information, kFrames);
    sum += information / draws;
    result.mean_ideal += P / draws;
    result.ideal.push_back(variance(P));
  }
  result.bound = test::last_camera_bound(sum, kFrames);
  return result;
}

// The information along one trajectory is what `ideal_covariance` inverts.
TEST(PosteriorBound, OfASingleDrawIsTheIdealCovariance) {
  const Sequence sequence = draw(kWide, 1);
  const Matrix12d one = test::last_camera_bound(information_of(sequence), kFrames);
  const Matrix12d P = last(sequence, "ideal_covariance").covariance;
  EXPECT_LT(test::relative_difference(one, P), 1e-6);
}

// (E J)^-1 is at most E(J^-1), by Jensen; with narrow priors they are nearly equal. With wide ones
// scale is hardly observable along each path, a direction that differs from path to path: the mean
// information knows it, and the bound is far below.
TEST(PosteriorBound, IsBelowTheMeanOfTheIdealCovariances) {
  for (const bool wide : {false, true}) {
    const Bound found = bound_of(wide ? kWide : kNarrow, 200);
    const auto [least, largest] = std::ranges::minmax(found.ideal);
    std::printf("bound %.4f m, ideal sigma %.4f m (%.4f to %.4f)\n",
                std::sqrt(variance(found.bound)), std::sqrt(variance(found.mean_ideal)),
                std::sqrt(least), std::sqrt(largest));
    const Vector12d scale = found.bound.diagonal().cwiseSqrt().cwiseInverse();
    const Matrix12d excess =
        scale.asDiagonal() * (found.mean_ideal - found.bound) * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Matrix12d> eigen(excess);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0);
    const double ratio = std::sqrt(variance(found.bound) / variance(found.mean_ideal));
    EXPECT_GT(ratio, wide ? 0.05 : 0.95);
    EXPECT_LT(ratio, wide ? 0.3 : 1.0);
  }
}

TEST(PosteriorBound, IsAttainedAndNotBeatenByTheEkf) {
  constexpr unsigned kDraws = 400;
  const double bound = variance(bound_of(kNarrow, kDraws).bound);
  std::vector<double> ratios;
  for (unsigned seed = 1; seed <= kDraws; ++seed) {
    ratios.push_back(squared_error(draw(kNarrow, seed)) / bound);
  }
  const Interval found = interval_of(ratios);
  std::printf("mean squared error over the bound: [%.3f, %.3f]\n", found.lower, found.upper);
  EXPECT_GT(found.upper, 1.0);
  EXPECT_LT(found.lower, 1.0);
}

// Along one trajectory, over draws of the pixel noise from `first` on.
Interval squared_error_over_ideal(unsigned seed, unsigned first, unsigned draws) {
  Sequence sequence = draw(kNarrow, seed);
  const double ideal = variance(last(sequence, "ideal_covariance").covariance);
  std::vector<double> ratios;
  for (unsigned noise = first; noise < first + draws; ++noise) {
    measure_all(sequence, noise);
    ratios.push_back(squared_error(sequence) / ideal);
  }
  return interval_of(ratios);
}

// Twenty trajectories find the extreme ones; other draws of the noise then judge these two.
TEST(IdealCovariance, IsNoBoundAlongItsTrajectory) {
  constexpr unsigned kDraws = 30, kOtherDraws = 200;
  unsigned lowest = 0, highest = 0;
  double least = 1.0, largest = 1.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Interval found = squared_error_over_ideal(seed, 1, kDraws);
    if (found.upper < least) std::tie(least, lowest) = std::pair(found.upper, seed);
    if (found.lower > largest) std::tie(largest, highest) = std::pair(found.lower, seed);
  }
  ASSERT_GT(lowest, 0u);
  ASSERT_GT(highest, 0u);
  const Interval low = squared_error_over_ideal(lowest, kDraws + 1, kOtherDraws);
  const Interval high = squared_error_over_ideal(highest, kDraws + 1, kOtherDraws);
  std::printf("trajectory %u: [%.3f, %.3f], %u: [%.3f, %.3f]\n", lowest, low.lower, low.upper,
              highest, high.lower, high.upper);
  EXPECT_LT(low.upper, 1.0);
  EXPECT_GT(high.lower, 1.0);
}

}  // namespace
}  // namespace slammot
