// The harness is calibrated, and would tell if it were not.
//
// On a small `matched`, where everything is drawn as it is stated, theory fixes the mean NEES and
// NIS of an EKF linearised at the truth. The mean over the frames of a run is one sample, however
// its frames are correlated; over runs the interval of the mean is Student's. With right statements
// it holds the degrees of freedom; with any one of them off by 10% it does not, on the same draws.
// The same at full length, with the batch: eval/studies/calibration.yaml.
//
// The theory is of first order: depths are drawn within 3% (at 15%, the default, the NEES of a
// landmark's position is 3.5 at its birth already, because 1/rho is not Gaussian).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/metrics/nees.h"
#include "eval/run/run.h"
#include "eval/statistics/chi_square.h"
#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

constexpr int kRuns = 80;           // seeds 1 to 80
constexpr double kStudent = 3.418;  // two-sided 99.9%, 79 degrees of freedom

const ScenarioOverrides kScene = {{"frames", "40"},
                                  {"visible", "30"},
                                  {"known", "10"},
                                  {"moving_fraction", "1"},
                                  {"noise", "0.5"},
                                  {"inverse_depth_sigma", "0.006"},
                                  {"object_acceleration", "0.3"}};

enum Statistic {
  kPose,
  kCameraVelocity,
  kCameraTurn,
  kLandmarkPosition,
  kLandmarkVelocity,
  kFirstPosition,  // at first sight: what the priors say
  kFirstVelocity,
  kInnovation,
  kStatistics
};
constexpr int kDof[] = {6, 3, 3, 3, 3, 3, 3, 2};

using RunMeans = std::array<double, kStatistics>;
using Misstatement = void (*)(slammot::Setup&);

RunResult run_ideal(const Sequence& sequence, Misstatement misstate) {
  Configuration configuration;
  configuration.model.landmark = "dynamic_inverse_depth";
  configuration.model.classifier.name = "truth";
  configuration.model.labels.rule = LabelRule::kOneWay;
  configuration.model.depth_prior = DepthPriorSource::kFixed;
  configuration.model.gate = {1.0, 1.0};  // rejects nothing, and so selects nothing
  configuration.ekf.linearisation = FilterLinearisation::kIdeal;
  slammot::Setup setup = make_setup(sequence, configuration);
  misstate(setup);
  return drive(sequence, *find_estimator("ekf").make(setup, configuration));
}

double mean_camera_nees(const Sequence& sequence, const RunResult& run, int part) {
  std::vector<double> values;
  for (std::size_t i = 1; i < run.filtered.size(); ++i) {
    const CameraEstimate& camera = run.filtered[i];
    const Vector12d error = boxminus(*sequence.truth[i], camera.state);
    values.push_back(nees(error.segment<3>(part), camera.covariance.block<3, 3>(part, part)));
  }
  return mean(values);
}

double mean_landmark_nees(const Sequence& sequence, const RunResult& run,
                          double LandmarkSample::*part, bool at_first_sight) {
  const int known = static_cast<int>(sequence.known.size());  // they have the first tracks
  std::vector<double> values;
  for (const LandmarkSample& s : run.samples) {
    const bool counts = s.track >= known && (s.observations == 1 || !at_first_sight);
    if (counts && !std::isnan(s.*part)) values.push_back(s.*part);
  }
  return mean(values);
}

RunMeans means_of(const Sequence& sequence, const RunResult& run) {
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.totals.rejected + run.totals.out_of_view, 0);
  constexpr auto kPositionNees = &LandmarkSample::position_nees;
  constexpr auto kVelocityNees = &LandmarkSample::velocity_nees;
  return {pose_consistency(pair_with_truth(sequence, run.filtered)).pose.mean,
          mean_camera_nees(sequence, run, kVelocity),
          mean_camera_nees(sequence, run, kAngularVelocity),
          mean_landmark_nees(sequence, run, kPositionNees, false),
          mean_landmark_nees(sequence, run, kVelocityNees, false),
          mean_landmark_nees(sequence, run, kPositionNees, true),
          mean_landmark_nees(sequence, run, kVelocityNees, true),
          run.totals.nis_sum / run.totals.accepted};
}

Interval student_interval(const std::vector<double>& samples) {
  const double centre = mean(samples), n = static_cast<double>(samples.size());
  double squares = 0.0;
  for (const double x : samples) squares += (x - centre) * (x - centre);
  const double half = kStudent * std::sqrt(squares / (n - 1.0) / n);
  return {centre - half, centre + half};
}

std::array<Interval, kStatistics> intervals(Misstatement misstate) {
  std::array<std::vector<double>, kStatistics> samples;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const Sequence sequence = simulate("model_matched", kScene, seed);
    const RunMeans means = means_of(sequence, run_ideal(sequence, misstate));
    for (std::size_t i = 0; i < kStatistics; ++i) samples[i].push_back(means[i]);
  }
  std::array<Interval, kStatistics> result;
  std::transform(samples.begin(), samples.end(), result.begin(), student_interval);
  return result;
}

TEST(Calibration, WhatIsStatedRightIsBelieved) {
  const auto found = intervals([](slammot::Setup&) {});
  for (std::size_t i = 0; i < kStatistics; ++i) {
    std::printf("%zu: %d in [%.3f, %.3f]\n", i, kDof[i], found[i].lower, found[i].upper);
    EXPECT_LT(found[i].lower, kDof[i]) << i;
    EXPECT_GT(found[i].upper, kDof[i]) << i;
  }
}

struct Wrong {
  const char* what;
  Misstatement state;
  Statistic told_by;
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.what; }

class Misstated : public testing::TestWithParam<Wrong> {};

TEST_P(Misstated, ByTenPercentIsFound) {
  const Wrong& wrong = GetParam();
  const int dof = kDof[wrong.told_by];
  const Interval found = intervals(wrong.state)[wrong.told_by];
  std::printf("%s: %d not in [%.3f, %.3f]\n", wrong.what, dof, found.lower, found.upper);
  EXPECT_TRUE(found.upper < dof || found.lower > dof);
}

constexpr double kWrong = 0.9;

// The truth is read for Jacobians only. Landmarks at 0.9 of their distance have Jacobians with
// respect to every position that are 1/0.9 times as large.
void scale_jacobians(slammot::Setup& setup) {
  auto shifted = std::make_shared<Truth>(*setup.truth);
  for (auto& [track, landmark] : shifted->landmarks) {
    for (auto& [frame, point] : landmark.by_frame) {
      const Eigen::Vector3d& from = shifted->cameras.at(frame).position;
      point.position = from + kWrong * (point.position - from);
    }
  }
  setup.truth = shifted;
}

using S = slammot::Setup;
INSTANTIATE_TEST_SUITE_P(
    Calibration, Misstated,
    testing::Values(
        Wrong{"pixel_noise", [](S& s) { s.pixel_sigma *= kWrong; }, kInnovation},
        // 10% in the weight is 5% in sigma.
        Wrong{"weight", [](S& s) { s.pixel_sigma /= std::sqrt(kWrong); }, kInnovation},
        Wrong{"acceleration", [](S& s) { s.camera_noise.acceleration *= kWrong; }, kCameraVelocity},
        Wrong{"angular_acceleration", [](S& s) { s.camera_noise.angular_acceleration *= kWrong; },
              kCameraTurn},
        Wrong{"object_acceleration", [](S& s) { s.prior.acceleration *= kWrong; },
              kLandmarkVelocity},
        Wrong{"depth_prior", [](S& s) { s.prior.inverse_depth_sigma *= kWrong; }, kFirstPosition},
        Wrong{"velocity_prior", [](S& s) { s.prior.max_speed *= kWrong; }, kFirstVelocity},
        Wrong{"jacobian", scale_jacobians, kPose}),
    [](const auto& wrong) { return std::string(wrong.param.what); });

}  // namespace
}  // namespace slammot
