// The simulator: determinism, exact geometry, honest statements, and what each scenario promises.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "slammot/datasets/random_stream.h"
#include "slammot/datasets/scenario.h"
#include "slammot/models/camera_motion.h"

namespace slammot {
namespace {

std::vector<double> numbers_of(const Sequence& s) {
  std::vector<double> numbers;
  for (size_t i = 0; i < s.frames.size(); ++i) {
    for (const Observation& z : s.frames[i].observations) {
      numbers.insert(numbers.end(), {double(z.track), z.pixel.x(), z.pixel.y()});
    }
    const CameraState& x = *s.truth[i];
    numbers.insert(numbers.end(), x.position.data(), x.position.data() + 3);
    numbers.insert(numbers.end(), x.velocity.data(), x.velocity.data() + 3);
  }
  for (const KnownLandmark& known : s.known) numbers.push_back(known.position.x());
  numbers.push_back(s.initial->state.velocity.x());
  return numbers;
}

std::optional<Eigen::Vector2d> true_pixel(const Sequence& s, size_t frame, int track) {
  const TruePoint* point = s.landmarks.at(track).at(s.frames[frame].index);
  const CameraState& x = *s.truth[frame];
  const auto p = s.camera.project(x.orientation.conjugate() * (point->position - x.position));
  return p ? std::optional(p->pixel) : std::nullopt;
}

class EveryScenario : public testing::TestWithParam<const ScenarioRow*> {
 protected:
  std::string_view name() const { return GetParam()->name; }
};

TEST_P(EveryScenario, SameSeedSameNumbersOtherSeedOtherNumbers) {
  const auto a = numbers_of(simulate(name(), {}, 7));
  EXPECT_EQ(a, numbers_of(simulate(name(), {}, 7)));
  EXPECT_NE(a, numbers_of(simulate(name(), {}, 8)));
}

TEST_P(EveryScenario, WithoutNoisePixelsAreProjections) {
  const Sequence s = simulate(name(), {{"noise", "0"}}, 1);
  EXPECT_GT(s.pixel_sigma, 0.0);
  for (size_t i = 0; i < s.frames.size(); ++i) {
    int before = -1;
    for (const Observation& z : s.frames[i].observations) {
      ASSERT_GT(z.track, before);  // each once, in increasing order
      before = z.track;
      const auto pixel = true_pixel(s, i, z.track);
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - z.pixel).norm(), 1e-9);
      EXPECT_TRUE(s.camera.in_image(z.pixel));
    }
  }
}

TEST_P(EveryScenario, PixelNoiseIsAsStatedUnlessItIsNot) {
  const Sequence s = simulate(name(), {{"noise", "2"}}, 1);
  EXPECT_EQ(s.pixel_sigma, 2.0);
  double squares = 0.0;
  int count = 0;
  for (size_t i = 0; i < s.frames.size(); ++i) {
    for (const Observation& z : s.frames[i].observations) {
      squares += (*true_pixel(s, i, z.track) - z.pixel).squaredNorm();
      count += 2;
    }
  }
  const double standard_error = 4.0 * std::sqrt(2.0 / count);
  EXPECT_NEAR(squares / count, 4.0, 4.0 * standard_error);
  EXPECT_EQ(simulate(name(), {{"stated_noise", "0.5"}}, 1).pixel_sigma, 0.5);
}

TEST_P(EveryScenario, NoiseShiftsNothingElse) {
  const Sequence a = simulate(name(), {}, 3), b = simulate(name(), {{"noise", "0.1"}}, 3);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.truth[i]->position, b.truth[i]->position);
    ASSERT_EQ(a.frames[i].observations.size(), b.frames[i].observations.size());
  }
}

TEST_P(EveryScenario, IsCompleteAndHonest) {
  const Sequence s = simulate(name(), {}, 1);
  EXPECT_EQ(s.name, std::string(name()) + "-1");
  EXPECT_TRUE(s.exact_truth);
  EXPECT_GE(s.known.size(), 4u);
  ASSERT_TRUE(s.motion && s.prior && s.initial);
  EXPECT_GT(s.motion->acceleration, 0.0);
  EXPECT_LT((s.initial->state.position - s.truth[0]->position).norm(), 0.01);
  EXPECT_LT((s.initial->state.velocity - s.truth[0]->velocity).norm(), 0.5);
  const size_t frame0 = s.frames[0].observations.size();
  EXPECT_GE(frame0, 8u);
  for (const Observation& z : s.frames[0].observations) {
    EXPECT_EQ(s.landmarks.at(z.track).label, Label::kStatic);  // what enters as static is static
  }
}

TEST_P(EveryScenario, TruthVelocitiesAreDerivatives) {
  if (name() == "matched") return;  // a random walk has none
  ScenarioOverrides fine{{"rate", "600"}, {"frames", "12000"}, {"static", "0"}, {"moving", "0"}};
  fine["loop_frames"] = "18000";
  if (name().starts_with("helix")) fine = {{"rate", "600"}, {"frames", "4000"}};
  const Sequence s = simulate(name(), fine, 1);
  for (size_t i = 1; i + 1 < s.frames.size(); ++i) {
    const double dt = 2.0 / 600.0;
    const CameraState& a = *s.truth[i - 1];
    const CameraState& b = *s.truth[i + 1];
    EXPECT_LT(((b.position - a.position) / dt - s.truth[i]->velocity).norm(), 1e-4);
    const Eigen::Quaterniond turn = a.orientation.conjugate() * b.orientation;
    const Eigen::Vector3d omega = log_so3(turn) / dt;
    EXPECT_LT((omega - s.truth[i]->angular_velocity).norm(), 1e-4);
  }
}

TEST_P(EveryScenario, RefusesUnknownKeysAndBadValues) {
  const auto reason = [&](const ScenarioOverrides& overrides) -> std::string {
    try {
      simulate(name(), overrides, 1);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(reason({{"nosuch", "1"}}).find("unknown key 'nosuch'"), std::string::npos);
  EXPECT_NE(reason({{"nosuch", "1"}}).find("noise"), std::string::npos);
  EXPECT_NE(reason({{"noise", "x"}}).find("noise: 'x' is not a finite number"), std::string::npos);
  EXPECT_NE(reason({{"frames", "0"}}).find("at least 1"), std::string::npos);
  EXPECT_NE(reason({{"rate", "0"}}).find("greater than 0"), std::string::npos);
  const std::string qualified = std::string(name()) + ".frames";
  EXPECT_EQ(simulate(name(), {{qualified, "5"}}, 1).frames.size(), 5u);
  EXPECT_FALSE(GetParam()->parameters().empty());
}

std::vector<const ScenarioRow*> rows() {
  std::vector<const ScenarioRow*> rows;
  for (const ScenarioRow& row : scenario_table()) rows.push_back(&row);
  return rows;
}
INSTANTIATE_TEST_SUITE_P(Table, EveryScenario, testing::ValuesIn(rows()),
                         [](const auto& row) { return std::string(row.param->name); });

TEST(Scenario, UnknownNameIsRefused) {
  EXPECT_THROW(simulate("circles", {}, 1), std::invalid_argument);
}

TEST(Circle, EnoughIsSeenAndMoversAreAsFastAsTheyShould) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Sequence s = simulate("circle", {}, seed);
    ASSERT_EQ(s.frames.size(), 600u);
    for (const Frame& frame : s.frames) EXPECT_GE(frame.observations.size(), 8u) << frame.index;
    int moving_late = 0;
    for (const auto& [track, landmark] : s.landmarks) {
      EXPECT_EQ(landmark.label, track < 300 ? Label::kStatic : Label::kMoving);
      EXPECT_LT(track, 588);
      if (landmark.label == Label::kStatic) continue;
      for (const auto& [frame, point] : landmark.by_frame) {
        EXPECT_GE(point.velocity.norm(), 1.0 - 1e-12);
        EXPECT_LE(point.velocity.norm(), 2.0 + 1e-12);
        moving_late += frame >= 500;
      }
    }
    EXPECT_GT(moving_late, 200);
  }
}

TEST(Circle, GoesRoundAndOverItsStartAgainAtAChangingSpeed) {
  const Sequence s = simulate("circle", {}, 1);
  for (size_t i = 0; i < 150; ++i) {
    EXPECT_LT(boxminus(*s.truth[i + 450], *s.truth[i]).norm(), 1e-9);
  }
  EXPECT_LT(s.truth[0]->position.norm(), 1e-12);
  EXPECT_LT(s.truth[0]->orientation.vec().norm(), 1e-12);
  std::set<int> first, again;
  for (const Observation& z : s.frames[0].observations) first.insert(z.track);
  for (const Observation& z : s.frames[450].observations) again.insert(z.track);
  for (const KnownLandmark& known : s.known) EXPECT_EQ(again.count(known.track), 1u);
  double least = 1e9, most = 0.0;
  for (const auto& x : s.truth) {
    least = std::min(least, x->velocity.norm());
    most = std::max(most, x->velocity.norm());
    EXPECT_NEAR((x->position - Eigen::Vector3d(10, 0, 0)).norm(), 10.0, 1e-9);
  }
  EXPECT_GT(most / least, 2.0);
}

TEST(Circle, PriorIsThatOfThePopulation) {
  const Sequence a = simulate("circle", {}, 1), b = simulate("circle", {}, 2);
  EXPECT_EQ(a.prior->inverse_depth, b.prior->inverse_depth);
  EXPECT_EQ(a.prior->inverse_depth_sigma, b.prior->inverse_depth_sigma);
  std::set<int> seen;
  double sum = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Sequence s = simulate("circle", {}, seed);
    seen.clear();
    for (const Frame& frame : s.frames) {
      for (const Observation& z : frame.observations) {
        if (!seen.insert(z.track).second || frame.index == 0) continue;
        const auto i = static_cast<size_t>(frame.index);
        sum +=
            1.0 / (s.landmarks.at(z.track).at(frame.index)->position - s.truth[i]->position).norm();
        ++count;
      }
    }
  }
  EXPECT_NEAR(sum / count, a.prior->inverse_depth,
              4.0 * a.prior->inverse_depth_sigma / std::sqrt(count));
}

TEST(Circle, KnownPointsAreOffByTheirSigma) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Sequence s = simulate("circle", {{"known_sigma", "0.01"}, {"frames", "2"}}, seed);
    ASSERT_EQ(s.known.size(), 4u);
    for (const KnownLandmark& known : s.known) {
      squares += (known.position - s.landmarks.at(known.track).at(0)->position).squaredNorm();
    }
  }
  EXPECT_NEAR(squares / 120.0 / 1e-4, 1.0, 4.0 * std::sqrt(2.0 / 120.0));
}

TEST(Square, RunsAtConstantSpeedOnFourLinesAndClosesThem) {
  const Sequence s = simulate("square", {}, 1);
  const double speed = s.truth[0]->velocity.norm();
  int straight = 0;
  for (const auto& x : s.truth) {
    EXPECT_NEAR(x->velocity.norm(), speed, 1e-9);
    straight += x->angular_velocity.norm() < 1e-9;
    const Eigen::Vector3d p = x->position - Eigen::Vector3d(10, 0, 0);
    EXPECT_LE(p.lpNorm<Eigen::Infinity>(), 10.0 + 1e-9);
  }
  EXPECT_GT(straight, 400);
  for (size_t i = 0; i < 150; ++i) {
    EXPECT_LT(boxminus(*s.truth[i + 450], *s.truth[i]).norm(), 1e-9);
  }
}

TEST(Helix, TargetsAreSeenThroughout) {
  for (const char* name : {"helix", "helix_unobservable"}) {
    const Sequence s = simulate(name, {}, 1);
    EXPECT_EQ(s.frames.size(), 150u);
    EXPECT_EQ(s.known.size(), 39u);
    EXPECT_EQ(s.landmarks.at(1).label, Label::kStatic);
    EXPECT_EQ(s.landmarks.at(2).at(1)->velocity, Eigen::Vector3d(1, 0, 0));
    EXPECT_EQ(s.landmarks.at(3).at(1)->velocity, Eigen::Vector3d(0, 0, 0.5));
    for (const Frame& frame : s.frames) {
      std::set<int> tracks;
      for (const Observation& z : frame.observations) tracks.insert(z.track);
      for (const int target : {1, 2, 3}) {
        EXPECT_EQ(tracks.count(target), frame.index == 0 ? 0u : 1u) << name << frame.index;
      }
      EXPECT_GE(tracks.size(), 10u) << name << frame.index;
    }
  }
}

TEST(HelixUnobservable, TheParallelMoverLooksLikeTheStaticTarget) {
  const Sequence s = simulate("helix_unobservable", {}, 1);
  const Sequence observable = simulate("helix", {}, 1);
  double apart = 0.0;
  for (size_t i = 1; i < s.frames.size(); ++i) {
    EXPECT_LT((*true_pixel(s, i, 1) - *true_pixel(s, i, 3)).norm(), 1e-9);
    apart = std::max(apart, (*true_pixel(observable, i, 1) - *true_pixel(observable, i, 3)).norm());
  }
  EXPECT_GT(apart, 10.0);
}

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

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
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
    const Sequence s = simulate("matched", {}, seed);
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

TEST(RandomStream, IsFixedAndNormal) {
  RandomStream a(1, "x"), b(1, "x"), c(1, "y"), d(2, "x");
  const double first = a.uniform(0, 1);
  EXPECT_EQ(first, b.uniform(0, 1));
  EXPECT_NE(first, c.uniform(0, 1));
  EXPECT_NE(first, d.uniform(0, 1));
  std::vector<double> values;
  for (int i = 0; i < 100000; ++i) values.push_back(a.normal());
  expect_normal(values, 0.0, 1.0);
}

}  // namespace
}  // namespace slammot
