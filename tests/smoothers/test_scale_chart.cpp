// The coordinates in which a change of scale is a straight line, and a prior in them.
#include "smoothers/graph/scale_chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/smoothers/fixture/cameras.h"
#include "tests/smoothers/fixture/prior_laws.h"

namespace slammot {
namespace {

// A prior over a camera, a mean depth and two landmarks, whose estimate has moved on.
struct Kept {
  std::mt19937_64 engine{7};
  Variables variables;
  std::vector<Variable*> all;
  Prior both{MarginalPrior(false, true), ConditionalMap(true)};
  MarginalPrior& prior = both.active;

  Eigen::VectorXd normals(Eigen::Index size) {
    std::normal_distribution<double> normal;
    return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(engine); });
  }
  Variable& add(const SmallVector& value, ScaleOrbit orbit, bool is_orientation = false) {
    Variable& v = variables.add(value, is_orientation, false);
    v.orbit = orbit;
    all.push_back(&v);
    return v;
  }
  explicit Kept(const PointFunctions& point) {
    using Kind = ScaleOrbit::Kind;
    const ScaleOrbit of_point{Kind::kPoint, Eigen::Vector3d::Zero(), &point};
    add(Eigen::Vector3d(1.0, 2.0, 3.0), {Kind::kPosition, Eigen::Vector3d(0.5, 0.0, -1.0)});
    add(test::camera_at(0.3, 0.2).orientation.coeffs(), {}, true);
    add((Eigen::Matrix<double, 6, 1>() << 1.0, 0.2, 2.0, 0.1, 0.2, 0.3).finished(), {Kind::kRates});
    add(Eigen::VectorXd::Constant(1, 0.3), {Kind::kInverse});
    for (const double rho : {0.4, 0.15}) {
      add(point.of({0.3 - rho, -0.2, 0.9}, rho, Eigen::Vector3d::Zero()), of_point).tells_scale =
          true;
    }
    Eigen::Index n = 0;
    int core = 0;
    for (Variable* v : all) {
      v->core = core;
      core += v->dim();
      n += v->dim();
    }
    Eigen::MatrixXd R = normals(n * n).reshaped(n, n).triangularView<Eigen::Upper>();
    R.diagonal().array() += 20.0;
    prior.set(all, R, normals(n));
  }
  void move(double by) {
    for (Variable* v : all) {
      v->value = plus(v->is_orientation, v->value, by * normals(v->dim()));
    }
  }
  void scale(double t) {
    for (Variable* v : all) {
      if (!v->is_orientation) v->value = v->orbit.at(v->value, t);
    }
  }
  Eigen::VectorXd direction() const {
    Eigen::VectorXd n = Eigen::VectorXd::Zero(prior.cols());
    for (const PriorBlock& b : prior.blocks()) {
      if (b.variable->is_orientation) continue;
      n.segment(b.offset, b.dim()) = b.variable->orbit.direction(b.variable->value);
    }
    return n;
  }
};

struct ScaleCharts : testing::TestWithParam<std::string> {
  Kept at{find_point(GetParam())};
};

TEST_P(ScaleCharts, WhatIsKnownOfTheScaleStaysWhileTheEstimateMoves) {
  const Eigen::VectorXd stated = at.prior.R() * at.direction();
  for (int i = 0; i < 5; ++i) {
    at.move(0.03);
    EXPECT_LT((at.prior.jacobian() * at.direction() - stated).norm(), 1e-9 * stated.norm());
    EXPECT_NEAR(at.prior.along_scale()(0), stated.squaredNorm(), 1e-9 * stated.squaredNorm());
    if (i % 2 == 1) at.prior.relinearise();
  }
}

TEST_P(ScaleCharts, AChangeOfScaleIsAStraightLine) {
  at.move(0.02);
  const Eigen::VectorXd before = at.prior.residual();
  const Eigen::VectorXd slope = at.prior.jacobian() * at.direction();
  const double lambda = at.prior.chart().lambda();
  at.scale(0.3);
  EXPECT_NEAR(at.prior.chart().lambda(), lambda + 0.3, 1e-12);
  EXPECT_LT((at.prior.residual() - before - 0.3 * slope).norm(), 1e-9 * before.norm());
}

TEST_P(ScaleCharts, KeepTheLawsOfAPrior) {
  at.move(0.05);
  const Eigen::MatrixXd J = at.prior.jacobian();
  test::expect_jacobian_of_the_residual(at.prior, at.variables, 1e-6 * J.norm());
  test::expect_normal_equations(at.prior, at.prior.cols(), J, at.prior.residual(), 1e-10);
  test::expect_the_same_when_relinearised(at.both);
  test::expect_normal_equations(at.prior, at.prior.cols(), at.prior.jacobian(), at.prior.residual(),
                                1e-10);  // the Gram that is kept is relinearised too
}

// An inactive variable that is a landmark of the prior follows it exactly, however the scale moves.
TEST_P(ScaleCharts, TheMapGrowsWithTheWorld) {
  ConditionalMap map(true);
  const Variable& y = *at.all.back();
  int total = 0;
  for (Variable* v : at.all) {
    v->column = total;
    total += v->dim();
  }
  map.relinearise(at.prior, total);
  Variable copy = y;
  copy.id = 1000;
  map.deactivate(copy, y.column);
  const auto error = [&] {
    const double of_gain =
        (map.gain({1000}, at.prior.chart()).middleCols<3>(y.column) - Eigen::Matrix3d::Identity())
            .norm();
    return std::max(of_gain, (map.value(1000, at.prior.chart()) - y.value).norm() / y.value.norm());
  };
  at.move(0.02);
  at.scale(0.2);
  EXPECT_LT(error(), 1e-9);
  map.relinearise(at.prior.chart());
  at.prior.relinearise();
  EXPECT_LT(error(), 1e-9);
  at.scale(0.2);
  EXPECT_LT(error(), 1e-9);
  at.move(0.01);  // to first order from now on
  EXPECT_LT(error(), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Points, ScaleCharts,
                         testing::Values("inverse_depth", "xyz", "log_inverse_depth",
                                         "homogeneous"));

}  // namespace
}  // namespace slammot
