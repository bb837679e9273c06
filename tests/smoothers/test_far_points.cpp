// Points whose parametrisation has no infinity, where measurements say that they are far away.
#include <gtest/gtest.h>

#include <random>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"
#include "smoothers/graph/residuals.h"
#include "tests/smoothers/fixture/scene.h"

namespace slammot {
namespace {

constexpr double kE = 2.718281828459045;
constexpr double kNoLimit = 0.0;

const PointFunctions& log_point() { return find_point("log_inverse_depth"); }
const PointFunctions& xyz_point() { return find_point("xyz"); }

TEST(FarPoints, AreThoseWithoutInfinity) {
  EXPECT_FALSE(lacks_infinity(find_point("inverse_depth")));
  EXPECT_FALSE(lacks_infinity(find_point("homogeneous")));
  EXPECT_TRUE(lacks_infinity(log_point()));
  EXPECT_TRUE(lacks_infinity(xyz_point()));
}

Eigen::Vector3d draw(std::mt19937_64& engine, double size) {
  std::normal_distribution<double> normal(0.0, size);
  const double x = normal(engine), y = normal(engine);
  return {x, y, normal(engine)};
}

TEST(FarPoints, ASmallStepIsLeftAsItIs) {
  std::mt19937_64 engine(2);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d y = Eigen::Vector3d(0.3, -0.1, 2.0) + draw(engine, 0.1);
    const Eigen::Vector3d step = draw(engine, 0.1);
    for (const PointFunctions* point : {&log_point(), &xyz_point()}) {
      const LimitedStep limited = limited_step(*point, y, step, kNoLimit);
      EXPECT_EQ(limited.step, step) << point->name;
      EXPECT_FALSE(limited.is_short) << point->name;
    }
  }
}

// By a factor of e, nearer and farther, and in the direction in which the step leads.
TEST(FarPoints, DepthChangesByAFactor) {
  std::mt19937_64 engine(1);
  int limited = 0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d y = draw(engine, 0.5), step = draw(engine, 3.0);
    for (const PointFunctions* point : {&log_point(), &xyz_point()}) {
      const Eigen::Vector3d to = y + limited_step(*point, y, step, kNoLimit).step;
      const double ratio = point->inverse_depth(to) / point->inverse_depth(y);
      EXPECT_LT(ratio, kE * (1.0 + 1e-12)) << point->name;
      EXPECT_GT(ratio, (1.0 - 1e-12) / kE) << point->name;
      const double whole = point->inverse_depth(y + step) / point->inverse_depth(y);
      if (whole > kE || whole < 1.0 / kE) {
        ++limited;
        EXPECT_TRUE(limited_step(*point, y, step, kNoLimit).is_short);
        EXPECT_NEAR(ratio, whole > kE ? kE : 1.0 / kE, 1e-12) << point->name;
      }
      const Eigen::Vector3d ahead = point->ray(y + step).direction;
      EXPECT_LT((point->ray(to).direction - ahead).norm(), 1e-12) << point->name;
    }
  }
  EXPECT_GT(limited, 100);
}

TEST(FarPoints, NoneIsFartherThanTheLimit) {
  const Eigen::Vector3d step(0.0, 0.0, -0.5);
  Eigen::Vector3d y(0.0, 0.0, std::log(0.0101));
  y += limited_step(log_point(), y, step, 0.01).step;
  EXPECT_NEAR(log_point().inverse_depth(y), 0.01, 1e-15);
  y += limited_step(log_point(), y, step, 0.01).step;
  EXPECT_NEAR(log_point().inverse_depth(y), 0.01, 1e-15);
  EXPECT_FALSE(limited_step(log_point(), y, step, 0.01).is_short);
  // One that is beyond stays there, or comes nearer.
  EXPECT_EQ(limited_step(log_point(), y, step, 0.02).step, Eigen::Vector3d::Zero());
  EXPECT_EQ(limited_step(log_point(), y, -step, 0.02).step, -step);
}

TEST(FarPoints, TheLimitIsAHundredthOfTheBirthsMean) {
  const test::Scene scene(3, {{"scaled_velocity", "log_inverse_depth"}, false});
  const Graph& graph = scene.graph;
  const GraphLandmark& plain = graph[test::Scene::kPlain];
  EXPECT_GT(plain.birth.inverse_depth, 0.0);
  EXPECT_EQ(graph.farthest(plain), 0.01 * plain.birth.inverse_depth);
  EXPECT_EQ(graph.farthest(graph[test::Scene::kBrief]),
            0.01 * graph.variables[graph.scene->scene].value(0));
  EXPECT_EQ(graph.farthest(graph[test::Scene::kKnown]), 0.0);
}

// In the first frames pixel noise asks for points beyond infinity. The camera moves by 1.7 m.
TEST(FarPoints, DoNotEndTheSmoothers) {
  const Sequence sequence = simulate("circle", {{"frames", "12"}}, 21);
  const auto expect_near = [&](const char* estimator, const char* point,
                               const Assignment& also = {"window.solver", "own"}) {
    SCOPED_TRACE(std::string(estimator) + ' ' + point + ' ' + also.value);
    Configuration configuration;
    assign(configuration, {"point", point});
    assign(configuration, also);
    const RunResult run = run_estimator(sequence, configuration, estimator);
    ASSERT_FALSE(run.diverged);
    const CameraState& last = (run.smoothed.empty() ? run.filtered : run.smoothed).back().state;
    EXPECT_LT((last.position - sequence.truth.back()->position).norm(), 0.1);
  };
  for (const char* point : {"log_inverse_depth", "xyz"}) {
    expect_near("window", point);
    expect_near("window", point, {"window.solver", "ceres"});
    expect_near("batch", point);
  }
  expect_near("window", "log_inverse_depth", {"window.linearisation", "fej"});
}

}  // namespace
}  // namespace slammot
