// Every scenario: determinism, exact geometry, honest statements, refusals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "datasets/simulation/scenario.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

using test::numbers_of;

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
      const auto pixel = test::true_pixel(s, i, z.track);
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
      squares += (*test::true_pixel(s, i, z.track) - z.pixel).squaredNorm();
      count += 2;
    }
  }
  const double standard_error = 4.0 * std::sqrt(2.0 / count);
  EXPECT_NEAR(squares / count, 4.0, 4.0 * standard_error);
  EXPECT_EQ(simulate(name(), {{"stated_noise", "0.5"}}, 1).pixel_sigma, 0.5);
  const Sequence other = simulate(name(), {{"noise", "0.1"}}, 1);  // shifts nothing else
  ASSERT_EQ(s.frames.size(), other.frames.size());
  for (size_t i = 0; i < s.frames.size(); ++i) {
    EXPECT_EQ(s.truth[i]->position, other.truth[i]->position);
    ASSERT_EQ(s.frames[i].observations.size(), other.frames[i].observations.size());
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
  EXPECT_GE(s.frames[0].observations.size(), 8u);
}

TEST(FirstFrame, HasMoversUnlessTheyAreDrawnAgain) {
  const auto movers = [](const char* scenario, const ScenarioOverrides& overrides) {
    const Sequence s = simulate(scenario, overrides, 1);
    return std::ranges::count_if(s.frames[0].observations, [&](const Observation& z) {
      return s.landmarks.at(z.track).label == Label::kMoving;
    });
  };
  for (const char* scenario : {"circle", "square"}) {
    SCOPED_TRACE(scenario);
    EXPECT_GE(movers(scenario, {{"frames", "5"}, {"moving", "600"}}), 4);
    EXPECT_EQ(movers(scenario, {{"frames", "5"}, {"moving", "600"}, {"first_moving", "2"}}), 2);
    EXPECT_EQ(movers(scenario, {{"frames", "5"}, {"moving", "600"}, {"first_moving", "0"}}), 0);
  }
}

TEST_P(EveryScenario, TruthVelocitiesAreDerivatives) {
  if (name() == "model_matched") return;  // a random walk has none
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
  const auto reason = [&](const ScenarioOverrides& overrides) {
    return test::refusal_of([&] { simulate(name(), overrides, 1); });
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

}  // namespace

void PrintTo(const ScenarioRow* row, std::ostream* out) { *out << row->name; }

namespace {

INSTANTIATE_TEST_SUITE_P(Table, EveryScenario, testing::ValuesIn(rows()),
                         [](const auto& row) { return std::string(row.param->name); });

// So many of either class are right, what is stated is as often true, whoever is right at a lower
// share is right at a higher one, and nothing else is drawn otherwise.
TEST(OddsFromOutside, AreTrueAsOftenAsTheyState) {
  const ScenarioOverrides few_move{{"moving", "100"}};
  const Sequence without = simulate("circle", few_move, 1);
  EXPECT_TRUE(without.p_static.empty());
  std::set<int> right_before;
  for (const double q : {0.6, 0.9}) {
    ScenarioOverrides set = few_move;
    set["odds_right"] = std::to_string(q);
    const Sequence s = simulate("circle", set, 1);
    EXPECT_EQ(numbers_of(s), numbers_of(without));
    ASSERT_EQ(s.p_static.size(), s.landmarks.size());
    std::map<double, std::pair<int, int>> static_of;  // by what is stated: how many rest, of all
    for (const auto& [track, p] : s.p_static) {
      auto& [rest, all] = static_of[p];
      rest += s.landmarks.at(track).label == Label::kStatic ? 1 : 0;
      ++all;
    }
    ASSERT_EQ(static_of.size(), 2u);
    for (const auto& [p, count] : static_of) {
      const double n = count.second;
      EXPECT_NEAR(count.first / n, p, 4.0 * std::sqrt(p * (1.0 - p) / n));
    }
    const double answers_static = static_of.rbegin()->first;
    std::set<int> right;
    for (const auto& [track, p] : s.p_static) {
      const bool says_static = p == answers_static;
      if (says_static == (s.landmarks.at(track).label == Label::kStatic)) right.insert(track);
    }
    const auto n = static_cast<double>(s.p_static.size());
    EXPECT_NEAR(static_cast<double>(right.size()) / n, q, 4.0 * std::sqrt(q * (1.0 - q) / n));
    EXPECT_TRUE(std::ranges::includes(right, right_before));
    right_before = right;
  }
  EXPECT_THROW(simulate("helix", {{"odds_right", "1.1"}}, 1), std::invalid_argument);
}

TEST(Scenario, AnUnknownNameAndTooMuchAreRefused) {
  EXPECT_THROW(simulate("circles", {}, 1), std::invalid_argument);
  for (const char* key : {"frames", "static", "width", "loop_frames"}) {
    ScenarioOverrides many{{"frames", "1"}, {"moving", "0"}, {"static", "0"}};
    many[key] = "100001";
    EXPECT_THROW(simulate("circle", many, 1), std::invalid_argument) << key;
  }
}

}  // namespace
}  // namespace slammot
