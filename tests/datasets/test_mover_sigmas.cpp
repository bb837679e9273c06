// How much movers accelerate, computed from the options and measured.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "datasets/simulation/scenario.h"
#include "datasets/simulation/scene/mover_sigmas.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

// Mean squares of differences of the truth on the horizontal axes. They smooth a sinusoid with
// w h = 0.1 by less than 0.2%; movers seen for longer weigh more and are not independent.
MoverSigmas differentiated(const ScenarioOverrides& overrides, double rate) {
  Eigen::Array2d squares = Eigen::Array2d::Zero();
  double count = 0.0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    test::for_each_triple(
        simulate("circle", overrides, seed),
        [&](const TruePoint& a, const TruePoint& b, const TruePoint& c) {
          const Eigen::Vector3d v = (c.velocity - a.velocity) * rate / 2.0;
          const Eigen::Vector3d j = (c.velocity - 2.0 * b.velocity + a.velocity) * rate * rate;
          squares += Eigen::Array2d(v.x() * v.x() + v.z() * v.z(), j.x() * j.x() + j.z() * j.z());
          count += 2.0;
        });
  }
  return {std::sqrt(squares(0) / count), std::sqrt(squares(1) / count)};
}

TEST(MoverSigmas, RmsIsThatOfTheTruthDifferentiated) {
  VolumeOptions options;
  EXPECT_EQ(rms_of_movers(options).acceleration, 0.0);
  EXPECT_EQ(rms_of_movers(options).jerk, 0.0);
  for (const auto& [lateral, braking] : {std::pair{2.0, 1.0}, {3.0, 0.0}, {0.0, 1.2}}) {
    options.manoeuvres = {0.7, lateral, braking, 4.0};
    const MoverSigmas truth = differentiated({{"manoeuvring", "0.7"},
                                              {"static", "0"},
                                              {"known", "0"},
                                              {"lateral_acceleration", std::to_string(lateral)},
                                              {"braking", std::to_string(braking)}},
                                             15.0);
    const MoverSigmas computed = rms_of_movers(options);
    EXPECT_NEAR(truth.acceleration / computed.acceleration, 1.0, 0.05);
    EXPECT_NEAR(truth.jerk / computed.jerk, 1.0, 0.05);
  }
}

// Over many movers, on each horizontal axis: the largest over all horizons of n steps of
// RMS(x(t + n dt) - x(t)) / (dt sqrt(n)), for the velocity and for the acceleration.
MoverSigmas strays(const ManoeuvreOptions& options, double dt) {
  constexpr int kHorizons = 150, kMovers = 4000;
  std::vector<Eigen::Array2d> squares(kHorizons + 1, Eigen::Array2d::Zero());
  RandomStream random(1, "strays");
  for (int i = 0; i < kMovers; ++i) {
    const double azimuth = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Vector3d course(std::sin(azimuth), 0.0, std::cos(azimuth));
    const auto m = draw_manoeuvre(options, course, random);
    for (int n = 1; m && n <= kHorizons; ++n) {
      const double v = (m->velocity(n * dt) - m->velocity(0.0)).squaredNorm();
      const double a = (m->acceleration(n * dt) - m->acceleration(0.0)).squaredNorm();
      squares[static_cast<size_t>(n)] += Eigen::Array2d(v, a) / (2.0 * kMovers * n * dt * dt);
    }
  }
  Eigen::Array2d largest = Eigen::Array2d::Zero();
  for (const Eigen::Array2d& square : squares) largest = largest.max(square.sqrt());
  return {largest(0), largest(1)};
}

TEST(MoverSigmas, WhiteNoiseCoversHowFarVelocityAndAccelerationStray) {
  for (const double period : {2.5, 4.0}) {
    VolumeOptions options;
    options.max_climb_deg = 0.0;
    options.manoeuvres = {0.5, 2.0, 1.0, period};
    const MoverSigmas truth = strays(options.manoeuvres, 1.0 / 15.0);
    const MoverSigmas computed = white_noise_of_movers(options, 1.0 / 15.0);
    EXPECT_NEAR(truth.acceleration / computed.acceleration, 1.0, 0.05) << period;
    EXPECT_NEAR(truth.jerk / computed.jerk, 1.0, 0.05) << period;
  }
}

}  // namespace
}  // namespace slammot
