// Movers that turn and brake: their motion, how much they accelerate, computed from the options and
// measured, and what the scenario `manoeuvres` promises.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "datasets/simulation/scenario.h"
#include "datasets/simulation/scene/mover_sigmas.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

using test::numbers_of;

Manoeuvre example(std::uint64_t seed) {
  RandomStream random(seed, "example");
  return *draw_manoeuvre({1.0, 2.0, 1.0, 4.0}, {0.5, 0.1, 1.2}, random);
}

TEST(Manoeuvre, VelocityAndAccelerationAreDerivatives) {
  constexpr double kStep = 1e-5;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Manoeuvre m = example(seed);
    for (double t = -3.0; t < 30.0; t += 0.0937) {
      const Eigen::Vector3d moved = m.offset(t + kStep) - m.offset(t - kStep);
      const Eigen::Vector3d sped = m.velocity(t + kStep) - m.velocity(t - kStep);
      ASSERT_LT((moved / (2.0 * kStep) - m.velocity(t)).norm(), 1e-9) << seed << " " << t;
      ASSERT_LT((sped / (2.0 * kStep) - m.acceleration(t)).norm(), 1e-9) << seed << " " << t;
    }
  }
}

TEST(Manoeuvre, StaysWithinItsBoundsAndComesNearThem) {
  const Eigen::Vector3d along = Eigen::Vector3d(0.5, 0.1, 1.2).normalized();
  double braking = 0.0, lateral = 0.0, slowing = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Manoeuvre m = example(seed);
    for (double t = 0.0; t < 60.0; t += 0.01) {
      const Eigen::Vector3d a = m.acceleration(t);
      const double part = a.dot(along);
      braking = std::max(braking, std::abs(part));
      lateral = std::max(lateral, (a - part * along).norm());
      slowing = std::max(slowing, -m.velocity(t).dot(along));
      ASSERT_LE(m.offset(t).norm(), m.reach());
      ASSERT_LT(std::abs((a - part * along).y()), 1e-12);  // turning is horizontal
    }
  }
  EXPECT_LE(braking, 1.0);
  EXPECT_GT(braking, 0.95);
  EXPECT_LE(lateral, 2.0);
  EXPECT_GT(lateral, 1.9);
  EXPECT_LE(slowing, largest_slowing({1.0, 2.0, 1.0, 4.0}));
  EXPECT_GT(slowing, 0.8 * largest_slowing({1.0, 2.0, 1.0, 4.0}));
}

// Simpson's rule over two steps of h: p2 - p0 = h / 3 (v0 + 4 v1 + v2), but for h^5 / 90
// max |d^4 v / dt^4|, which is at most w^3 |a| with w = 2 pi / 3.
TEST(Manoeuvres, PositionsIntegrateVelocities) {
  constexpr double kStep = 0.1;
  const double bound = std::pow(2.0 * std::numbers::pi / 3.0, 3) * std::hypot(2.0, 1.0) / 90.0;
  int count = 0;
  test::for_each_triple(
      simulate("square",
               {{"manoeuvring", "1"}, {"static", "50"}, {"rate", "10"}, {"frames", "100"}}, 1),
      [&](const TruePoint& a, const TruePoint& b, const TruePoint& c) {
        const Eigen::Vector3d sum = a.velocity + 4.0 * b.velocity + c.velocity;
        const Eigen::Vector3d moved = c.position - a.position;
        EXPECT_LE((moved - kStep / 3.0 * sum).norm(), bound * std::pow(kStep, 5));
        ++count;
      });
  EXPECT_GT(count, 1000);
}

TEST(Manoeuvres, HalfOfTheMoversKeepTheirVelocity) {
  int steady = 0, swaying = 0;
  for (const std::uint64_t seed : {1u, 2u}) {
    const Sequence s = simulate("manoeuvres", {}, seed);
    for (const auto& [track, landmark] : s.landmarks) {
      EXPECT_EQ(landmark.label, track < 300 ? Label::kStatic : Label::kMoving);
      if (landmark.label == Label::kStatic || landmark.by_frame.size() < 2) continue;
      const auto& points = landmark.by_frame;
      const bool same = points.begin()->second.velocity == points.rbegin()->second.velocity;
      (same ? steady : swaying) += 1;
    }
  }
  const double movers = steady + swaying;
  EXPECT_NEAR(swaying / movers, 0.5, 4.0 * 0.5 / std::sqrt(movers));
}

TEST(Manoeuvres, NobodyManoeuvringIsTheCircle) {
  const auto circle = numbers_of(simulate("circle", {}, 2));
  EXPECT_EQ(numbers_of(simulate("manoeuvres", {{"manoeuvring", "0"}}, 2)), circle);
  EXPECT_EQ(numbers_of(simulate("circle", {{"braking", "9"}}, 2)), circle);
  EXPECT_NE(numbers_of(simulate("manoeuvres", {}, 2)), circle);
}

TEST(Manoeuvres, WhoStopsDoesNotManoeuvre) {
  const ScenarioOverrides all_stop{{"stopping", "1"}, {"parked", "0"}};
  ScenarioOverrides both = all_stop;
  both["manoeuvring"] = "1";
  EXPECT_EQ(numbers_of(simulate("move_stop_move", all_stop, 1)),
            numbers_of(simulate("move_stop_move", both, 1)));
}

// Lines just too far to be seen, from which movers sway into view: each frame that sees them
// counts.
TEST(Manoeuvres, WhoSwaysIntoViewIsRecorded) {
  RecordingOptions options;
  options.frames = 60;
  options.field_of_view_deg = 10.0;
  const std::vector<CameraState> trajectory(60);
  RandomStream random(1, "lines");
  std::vector<ScenePoint> points;
  int expected = 0;
  for (int track = 0; track < 50; ++track) {
    ScenePoint& point = points.emplace_back(ScenePoint{track, {-2.0, 0.0, 12.5}, {1.0, 0.0, 0.0}});
    point.manoeuvre = draw_manoeuvre({1.0, 2.0, 0.5, 4.0}, point.velocity, random);
    for (int i = 0; i < options.frames; ++i) {
      const Eigen::Vector3d position = point.at(options.time(i));
      expected += view(simulated_camera(options), options, trajectory[0], position).has_value();
    }
  }
  int recorded = 0;
  for (const Frame& frame : record(options, trajectory, points, 1).frames) {
    recorded += static_cast<int>(frame.observations.size());
  }
  EXPECT_GT(expected, 100);
  EXPECT_EQ(recorded, expected);
}

TEST(Manoeuvres, TheAccelerationStatedIsTheRmsOfTheTrueOneWhereNobodyStops) {
  VolumeOptions options;
  for (const double share : {0.5, 1.0}) {
    options.manoeuvres.share = share;
    const Sequence s = simulate("circle", {{"manoeuvring", std::to_string(share)}}, 1);
    EXPECT_EQ(s.prior->acceleration, rms_of_movers(options).acceleration);
  }
  EXPECT_NEAR(simulate("manoeuvres", {}, 1).prior->acceleration, 0.557, 0.002);
  const ScenarioOverrides hardly{{"lateral_acceleration", "0.01"}, {"braking", "0"}};
  EXPECT_EQ(simulate("manoeuvres", hardly, 1).prior->acceleration, kLeastObjectAcceleration);
  const double stops = simulate("move_stop_move", {}, 1).prior->acceleration;
  EXPECT_GE(simulate("move_stop_move", {{"manoeuvring", "1"}}, 1).prior->acceleration, stops);
}

TEST(Manoeuvres, BadParametersAreRefusedWithAReason) {
  const auto reason = [](const ScenarioOverrides& overrides) {
    return test::refusal_of([&] { simulate("circle", overrides, 1); });
  };
  EXPECT_EQ(reason({{"manoeuvring", "1.5"}}), "manoeuvring: must be at most 1, not 1.5");
  EXPECT_EQ(reason({{"manoeuvring", "-0.1"}}), "manoeuvring: must be at least 0, not -0.1");
  EXPECT_EQ(reason({{"lateral_acceleration", "-1"}}),
            "lateral_acceleration: must be at least 0, not -1");
  EXPECT_EQ(reason({{"braking", "-1"}}), "braking: must be at least 0, not -1");
  EXPECT_EQ(reason({{"manoeuvre_period", "0"}}), "manoeuvre_period: must be greater than 0, not 0");
  EXPECT_EQ(
      reason({{"manoeuvring", "0.1"}, {"braking", "2"}}),
      "braking, manoeuvre_period: slow a mover by 1.59 m/s, which must be less than min_speed "
      "(1 m/s)");
}

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

}  // namespace
}  // namespace slammot
