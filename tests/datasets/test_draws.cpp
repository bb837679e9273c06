// What is drawn at random: all that the scenario `matched` draws from the models.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "datasets/simulation/scenario.h"
#include "eval/statistics/statistics.h"
#include "models/camera_motion.h"

namespace slammot {
namespace {

// What `matched` draws, over seeds.
struct Draws {
  std::vector<double> inverse_depths, velocities, accelerations, camera, initial;
};

void add_draws(const Sequence& s, Draws& draws) {
  std::set<int> seen;
  for (const KnownLandmark& known : s.known) seen.insert(known.track);
  for (const Frame& frame : s.frames) {
    const auto i = static_cast<size_t>(frame.index);
    for (const Observation& z : frame.observations) {
      if (!seen.insert(z.track).second) continue;
      const TruePoint& p = *s.landmarks.at(z.track).at(frame.index);
      draws.inverse_depths.push_back(1.0 / (p.position - s.truth[i]->position).norm());
      if (s.landmarks.at(z.track).label == Label::kMoving)
        draws.velocities.push_back(p.velocity.x());
    }
  }
  for (const auto& [track, landmark] : s.landmarks) {
    for (const auto& [frame, p] : landmark.by_frame) {
      const auto next = landmark.by_frame.find(frame + 1);
      if (next == landmark.by_frame.end()) continue;
      draws.accelerations.push_back((next->second.velocity - p.velocity).y() * 15.0);
    }
  }
  const Matrix12d Q = camera_noise({1.0, 0.3}, *s.truth[0], 1.0 / 15.0);
  for (size_t i = 1; i < s.truth.size(); ++i) {
    const Vector12d w = boxminus(*s.truth[i], predict(*s.truth[i - 1], 1.0 / 15.0));
    draws.camera.push_back(w.dot(Q.llt().solve(w)) / 12.0);
  }
  const Vector12d e = boxminus(*s.truth[0], s.initial->state);
  draws.initial.push_back(e.head<6>().squaredNorm() / 6e-6);
  draws.initial.push_back(e.tail<6>().squaredNorm() / 6e-2);
}

// Mean and standard deviation within 4 standard errors.
void expect_normal(const std::vector<double>& values, double mu, double sigma) {
  const double n = static_cast<double>(values.size());
  ASSERT_GT(n, 200);
  EXPECT_NEAR(mean(values), mu, 4.0 * sigma / std::sqrt(n));
  double squares = 0.0;
  for (const double v : values) squares += (v - mu) * (v - mu);
  EXPECT_NEAR(squares / n / (sigma * sigma), 1.0, 4.0 * std::sqrt(2.0 / n));
}

TEST(Matched, DrawsFromTheModels) {
  Draws draws;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Sequence s = simulate("model_matched", {}, seed);
    ASSERT_EQ(s.frames.size(), 150u);
    for (const Frame& frame : s.frames) EXPECT_EQ(frame.observations.size(), 30u);
    add_draws(s, draws);
  }
  expect_normal(draws.inverse_depths, 0.2, 0.03);
  expect_normal(draws.velocities, 0.0, 1.0);
  expect_normal(draws.accelerations, 0.0, 0.1);
  const double n = static_cast<double>(draws.camera.size());
  EXPECT_NEAR(mean(draws.camera), 1.0, 4.0 * std::sqrt(2.0 / 12.0 / n));
  EXPECT_NEAR(mean(draws.initial), 1.0, 4.0 * std::sqrt(2.0 / 6.0 / 40.0));
}

// Montiel's noise: (v, omega) gains an impulse, and the step is taken with the gain.
TEST(Draws, ImpulsesMoveTheCameraInTheirOwnStep) {
  constexpr double kDt = 1.0 / 15.0;
  std::vector<double> impulses;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Sequence s = simulate("model_matched", {{"impulse", "1"}, {"frames", "40"}}, seed);
    for (size_t i = 1; i < s.truth.size(); ++i) {
      CameraState x = *s.truth[i - 1];
      const CameraState& y = *s.truth[i];
      const Eigen::Vector3d V = y.velocity - x.velocity;
      const Eigen::Vector3d Omega = y.angular_velocity - x.angular_velocity;
      for (int axis = 0; axis < 3; ++axis) {
        impulses.push_back(V(axis) / (1.0 * kDt));
        impulses.push_back(Omega(axis) / (0.3 * kDt));
      }
      x.velocity += V;
      x.angular_velocity += Omega;
      EXPECT_LT(boxminus(y, predict(x, kDt)).norm(), 1e-12);
    }
  }
  expect_normal(impulses, 0.0, 1.0);
  EXPECT_THROW(simulate("model_matched", {{"impulse", "2"}}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
