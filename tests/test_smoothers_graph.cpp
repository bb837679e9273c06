// The linear algebra of the smoother on problems whose answer is known.
#include <ceres/covariance.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <random>

#include "slammot/models/landmark_models.h"
#include "slammot/smoothers/camera_manifold.h"
#include "slammot/smoothers/ceres_solve.h"
#include "slammot/smoothers/cost_tools.h"
#include "slammot/smoothers/factors.h"
#include "slammot/smoothers/landmark_chain.h"
#include "slammot/smoothers/marginalise.h"
#include "slammot/smoothers/optimise.h"
#include "slammot/smoothers/triangularise.h"

namespace slammot {
namespace {

// A x + B y - c, four residuals of two blocks of three.
class LinearCost final : public ceres::SizedCostFunction<4, 3, 3> {
 public:
  explicit LinearCost(std::mt19937_64& engine) {
    std::normal_distribution<double> normal;
    for (double& v : A_.reshaped()) v = normal(engine);
    for (double& v : B_.reshaped()) v = normal(engine);
    for (double& v : c_.reshaped()) v = normal(engine);
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    using Block = Eigen::Map<const Eigen::Vector3d>;
    Eigen::Map<Eigen::Vector4d>(residuals, 4) = A_ * Block(x[0]) + B_ * Block(x[1]) - c_;
    write<4, 3>(jacobians, 0, A_);
    write<4, 3>(jacobians, 1, B_);
    return true;
  }

 private:
  Eigen::Matrix<double, 4, 3> A_, B_;
  Eigen::Vector4d c_;
};

// Twelve variables, each tied to the next and to one far away; every third belongs to a landmark.
Graph linear_problem(unsigned seed) {
  std::mt19937_64 engine(seed);
  Graph graph(false);
  for (int i = 0; i < 12; ++i) {
    graph.add_variable(Eigen::Vector3d::Zero(), nullptr, i % 3 == 2 ? i : -1);
  }
  for (int i = 0; i + 1 < 12; ++i)
    graph.add_factor({i, i + 1}, std::make_unique<LinearCost>(engine));
  graph.add_factor({0, 7}, std::make_unique<LinearCost>(engine));
  graph.add_factor({3, 10}, std::make_unique<LinearCost>(engine));
  return graph;
}

TEST(Marginalise, ThenSolvingIsSolvingThenMarginalising) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Graph whole = linear_problem(seed), part = linear_problem(seed);
    const Step solution = NormalEquations(whole).step();
    const std::vector<std::vector<VariableId>> kept{{4, 6, 7}, {9, 10, 11}};
    const auto P = NormalEquations(whole).covariances(kept);
    marginalise(part, {0, 1});
    marginalise(part, {2});
    marginalise(part, {3, 5, 8});
    const NormalEquations equations(part);
    const Step step = equations.step();
    const auto P_part = equations.covariances(kept);
    for (const VariableId id : {4, 6, 7, 9, 10, 11}) {
      EXPECT_LT((step.at(id) - solution.at(id)).norm(), 1e-10 * (1.0 + solution.at(id).norm()));
    }
    for (std::size_t i = 0; i < P.size(); ++i) {
      EXPECT_LT((P[i] - P_part[i]).norm(), 1e-10 * P[i].norm()) << "seed " << seed;
    }
  }
}

TEST(Marginalise, WithoutThePriorTheAnswerIsAnother) {
  Graph whole = linear_problem(1), part = linear_problem(1);
  const Step solution = NormalEquations(whole).step();
  marginalise(part, {0, 1});
  part.set_prior({}, Eigen::MatrixXd(0, 0), Eigen::VectorXd(0));
  const Step step = NormalEquations(part).step();
  EXPECT_GT((step.at(2) - solution.at(2)).norm(), 1e-3);
}

// x^2 - y, which has another Jacobian wherever it is evaluated.
class SquareCost final : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = x[0][0] * x[0][0] - x[1][0];
    if (jacobians && jacobians[0]) jacobians[0][0] = 2.0 * x[0][0];
    if (jacobians && jacobians[1]) jacobians[1][0] = -1.0;
    return true;
  }
};

// A variable that a prior touches is linearised where it was then, and elsewhere it is not: first
// estimates (Huang, Mourikis and Roumeliotis 2010).
TEST(FirstEstimates, JacobiansBesideThePriorStay) {
  for (const bool first_estimates : {false, true}) {
    Graph graph(first_estimates);
    const Eigen::VectorXd three = Eigen::VectorXd::Constant(1, 3.0);
    const VariableId old = graph.add_variable(three, nullptr, -1);
    const VariableId x = graph.add_variable(three, nullptr, -1);
    const VariableId y = graph.add_variable(three, nullptr, -1);
    graph.add_factor({old, x}, std::make_unique<SquareCost>());
    graph.add_factor({x, old}, std::make_unique<SquareCost>());
    marginalise(graph, {old});
    const FactorId beside = graph.add_factor({x, y}, std::make_unique<SquareCost>());
    const FactorId apart = graph.add_factor({y, x}, std::make_unique<SquareCost>());
    Step step;
    step[x] = step[y] = SmallVector::Constant(1, 2.0);
    graph.move(step);
    graph.linearise();
    EXPECT_DOUBLE_EQ(graph.factors().at(beside).J[0](0, 0), first_estimates ? 6.0 : 10.0);
    EXPECT_DOUBLE_EQ(graph.factors().at(beside).r(0), 20.0);
    EXPECT_DOUBLE_EQ(graph.factors().at(apart).J[0](0, 0), 10.0);
  }
}

// Variables that rest in the far map while others leave, come back and are measured again.
TEST(FarMap, ToRestAndToReturnChangesNothing) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Graph whole = linear_problem(seed), part = linear_problem(seed);
    marginalise(part, {0}, {}, {}, {1});
    marginalise(part, {2}, {}, {}, {5, 8});
    marginalise(part, {3});
    EXPECT_EQ(part.far().dim(), 9);

    const std::vector<LinearForm> asked{{{1, 8, 9}, Eigen::MatrixXd::Identity(9, 9)}};
    const Eigen::MatrixXd P = NormalEquations(whole).covariances(asked).front();
    LinearForm form = asked.front();
    Eigen::MatrixXd P_part = replace_far(part, form);
    const std::vector<LinearForm> forms{form};
    P_part += NormalEquations(part).covariances(forms).front();
    // The order of a replaced form is that of its rows, which has not changed.
    EXPECT_LT((P - P_part).norm(), 1e-10 * P.norm()) << "seed " << seed;

    part.move(NormalEquations(part).step());
    whole.move(NormalEquations(whole).step());
    EXPECT_LT((part.value(5) - whole.value(5)).norm(), 1e-10);
    part.bring_back({5, 1});
    EXPECT_EQ(part.far().dim(), 3);
    for (Graph* graph : {&whole, &part}) {
      std::mt19937_64 engine(100 + seed);
      graph->add_factor({1, 5}, std::make_unique<LinearCost>(engine));
      graph->add_factor({5, 10}, std::make_unique<LinearCost>(engine));
    }
    part.rebase_prior();
    marginalise(part, {4, 6});
    part.move(NormalEquations(part).step());
    whole.move(NormalEquations(whole).step());
    for (const VariableId id : {1, 5, 7, 8, 9, 10, 11}) {
      EXPECT_LT((part.value(id) - whole.value(id)).norm(), 1e-9) << "seed " << seed;
    }
  }
}

// x1 = F x0 + G n with an invertible Q = G G': the substitution against the factor Q^-1/2 (x1 - F
// x0).
TEST(Marginalise, AdvanceIsTheTimeUpdate) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  Matrix6d F = Matrix6d::Identity(), G = Matrix6d::Zero(), P0 = Matrix6d::Zero();
  for (int i = 0; i < 36; ++i) {
    F.data()[i] += 0.2 * normal(engine);
    G.data()[i] = normal(engine);
    P0.data()[i] = normal(engine);
  }
  P0 = P0 * P0.transpose() + Matrix6d::Identity();
  Graph graph(false);
  const VariableId y = graph.add_variable(Eigen::Vector3d::Zero(), nullptr, 1);
  const VariableId w = graph.add_variable(Eigen::Vector3d::Zero(), nullptr, 1);
  const Matrix6d root = P0.inverse().llt().matrixU();
  graph.set_prior({y, w}, root, Eigen::VectorXd::Zero(6));
  const VariableId n = graph.add_variable(Vector6d::Zero(), nullptr, 1);
  graph.add_factor({n}, noise_prior_cost());
  const Vector6d next = Vector6d::Constant(0.5);
  marginalise(graph, {n}, {{y, w, n, F.inverse(), G, next}});
  const std::vector<std::vector<VariableId>> both{{y, w}};
  const Matrix6d P = NormalEquations(graph).covariances(both).front();
  const Matrix6d expected = F * P0 * F.transpose() + G * G.transpose();
  EXPECT_LT((P - expected).norm(), 1e-12 * expected.norm());
  EXPECT_EQ(graph.value(y), SmallVector(next.head<3>()));
}

TEST(Triangularise, KeepsTheGram) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  for (const auto& [rows, cols] : {std::pair{70, 70}, {120, 90}, {40, 90}, {5, 3}, {3, 5}}) {
    Eigen::MatrixXd A(rows, cols);
    for (double& v : A.reshaped()) v = normal(engine);
    for (int i = 0; i < rows / 2; ++i) A.row(i).head(std::min(i, cols)).setZero();
    const Eigen::MatrixXd R = triangularise(A);
    EXPECT_LT((R.transpose() * R - A.transpose() * A).norm(), 1e-12 * A.squaredNorm());
    EXPECT_EQ(R.rows(), cols);
    EXPECT_EQ(R.triangularView<Eigen::StrictlyLower>().toDenseMatrix().norm(), 0.0);
  }
}

Camera pinhole() { return {640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}}; }

CameraState camera_at(double x, double turn) {
  CameraState c;
  c.position = {x, 0.1 * x, 0.0};
  c.orientation = exp_so3(Eigen::Vector3d(0.0, turn, 0.02));
  c.velocity = {1.0, 0.1, 0.0};
  c.angular_velocity = {0.0, turn, 0.0};
  return c;
}

// Three cameras, eight static landmarks anchored at the first: enough for every kind of block.
struct SmallScene {
  MotionManifold manifold;
  Graph graph{false};
  std::vector<VariableId> positions, motions, ys;

  SmallScene() {
    std::mt19937_64 engine(7);
    std::normal_distribution<double> normal;
    InitialCamera initial;
    initial.state = camera_at(0.0, 0.0);
    initial.position_sigma = initial.rotation_sigma = 0.01;
    for (int i = 0; i < 3; ++i) {
      Eigen::VectorXd position(3), motion(kMotionSize);
      camera_to_blocks(camera_at(0.3 * i, 0.05 * i), position.data(), motion.data());
      positions.push_back(graph.add_variable(position, nullptr, -1));
      motions.push_back(graph.add_variable(motion, &manifold, -1));
    }
    graph.add_factor({positions[0], motions[0]}, initial_camera_cost(initial));
    MotionNoise noise{2.0, 1.0};
    for (std::size_t i = 1; i < 3; ++i) {
      graph.add_factor({positions[i - 1], motions[i - 1], positions[i], motions[i]},
                       camera_motion_cost(camera_noise(noise, initial.state, 0.3), 0.3));
    }
    for (int l = 0; l < 8; ++l) {
      const Eigen::Vector3d y(0.1 * normal(engine), 0.1 * normal(engine), 0.2);
      ys.push_back(graph.add_variable(y, nullptr, l));
      graph.add_factor({ys.back()}, inverse_depth_prior_cost({0.2, 0.05, 2.0}));
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector2d z(320.0 + 40.0 * normal(engine) - 25.0 * static_cast<double>(i),
                                240.0 + 40.0 * normal(engine));
        if (i == 0) {
          graph.add_factor({motions[0], ys.back()}, first_pixel_cost(pinhole(), z, 30.0));
        } else {
          graph.add_factor({positions[i], motions[i], positions[0], ys.back()},
                           pixel_cost(pinhole(), z, 30.0));
        }
      }
    }
  }
};

TEST(NormalEquations, CovariancesAreThoseOfCeres) {
  SmallScene scene;
  optimise(scene.graph, 50, 1e-20);
  scene.graph.linearise();
  const std::vector<std::vector<VariableId>> sets{{scene.positions[2], scene.motions[2]},
                                                  {scene.positions[0], scene.ys[3]}};
  const auto P = NormalEquations(scene.graph).covariances(sets);
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  for (const auto& [id, v] : scene.graph.variables()) {
    problem.AddParameterBlock(scene.graph.data(id), static_cast<int>(v.value.size()),
                              const_cast<ceres::Manifold*>(v.manifold));
  }
  for (const auto& [id, f] : scene.graph.factors()) {
    std::vector<double*> blocks;
    for (const VariableId v : f.variables) blocks.push_back(scene.graph.data(v));
    problem.AddResidualBlock(f.cost.get(), nullptr, blocks);
  }
  ceres::Covariance::Options dense;
  dense.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance oracle(dense);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    std::vector<const double*> blocks;
    for (const VariableId id : sets[k]) blocks.push_back(scene.graph.data(id));
    ASSERT_TRUE(oracle.Compute(blocks, &problem));
    Eigen::Matrix<double, -1, -1, Eigen::RowMajor> expected(P[k].rows(), P[k].cols());
    ASSERT_TRUE(oracle.GetCovarianceMatrixInTangentSpace(blocks, expected.data()));
    EXPECT_LT((P[k] - expected).norm(), 1e-9 * expected.norm());
  }
}

TEST(Optimise, FindsTheMinimumThatCeresFinds) {
  SmallScene ours, theirs;
  optimise(ours.graph, 50, 1e-20);
  solve_with_ceres(theirs.graph);
  const NormalEquations equations(ours.graph);
  for (const auto& [id, v] : ours.graph.variables()) {
    const std::vector<std::vector<VariableId>> own{{id}};
    const Eigen::VectorXd sigma = equations.covariances(own).front().diagonal().cwiseSqrt();
    const Eigen::VectorXd d = minus(v.manifold, v.value, theirs.graph.value(id));
    EXPECT_LT(d.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-4) << id;
  }
}

// Each cost function's Jacobian, brought to the tangent space, against central differences there.
void expect_gradients(const ceres::CostFunction& cost, std::vector<SmallVector> values,
                      const MotionManifold& manifold) {
  using RowMajorMatrix = Eigen::Matrix<double, -1, -1, Eigen::RowMajor>;
  const auto manifold_of = [&](const SmallVector& v) {
    return v.size() == kMotionSize ? &manifold : nullptr;
  };
  const auto residuals = [&](const std::vector<SmallVector>& x, double** jacobians) {
    std::vector<const double*> blocks;
    for (const SmallVector& v : x) blocks.push_back(v.data());
    Eigen::VectorXd r(cost.num_residuals());
    EXPECT_TRUE(cost.Evaluate(blocks.data(), r.data(), jacobians));
    return r;
  };
  std::vector<RowMajorMatrix> ambient;
  for (const SmallVector& v : values) ambient.emplace_back(cost.num_residuals(), v.size());
  std::vector<double*> jacobians;
  for (RowMajorMatrix& J : ambient) jacobians.push_back(J.data());
  residuals(values, jacobians.data());
  for (std::size_t k = 0; k < values.size(); ++k) {
    const MotionManifold* m = manifold_of(values[k]);
    RowMajorMatrix P = RowMajorMatrix::Identity(values[k].size(), values[k].size());
    if (m) {
      P.resize(kMotionSize, kMotionDim);
      m->PlusJacobian(values[k].data(), P.data());
    }
    const Eigen::MatrixXd J = ambient[k] * P;
    for (Eigen::Index i = 0; i < J.cols(); ++i) {
      constexpr double kStep = 1e-5;
      SmallVector d = SmallVector::Zero(J.cols());
      d(i) = kStep;
      std::vector<SmallVector> ahead = values, behind = values;
      ahead[k] = plus(m, values[k], d);
      behind[k] = plus(m, values[k], -d);
      const Eigen::VectorXd numeric =
          (residuals(ahead, nullptr) - residuals(behind, nullptr)) / (2.0 * kStep);
      ASSERT_LT((numeric - J.col(i)).norm(), 1e-6 * std::max(J.norm(), 1.0))
          << "block " << k << " column " << i;
    }
  }
}

TEST(Factors, JacobiansOnTheManifold) {
  MotionManifold manifold;
  std::mt19937_64 engine(11);
  std::normal_distribution<double> normal;
  const auto vector = [&](double s) {
    return Eigen::Vector3d(s * normal(engine), s * normal(engine), s * normal(engine));
  };
  for (int k = 0; k < 200; ++k) {
    CameraState a = camera_at(normal(engine), 0.3 * normal(engine));
    CameraState b = predict(a, 0.1);
    b = boxplus(b, Vector12d(Vector12d::Random() * 0.05));
    SmallVector pa(3), ma(kMotionSize), pb(3), mb(kMotionSize);
    camera_to_blocks(a, pa.data(), ma.data());
    camera_to_blocks(b, pb.data(), mb.data());
    InitialCamera initial;
    initial.state = b;
    initial.position_sigma = initial.rotation_sigma = 0.1;
    expect_gradients(*initial_camera_cost(initial), {pa, ma}, manifold);
    const Matrix12d Q = camera_noise({1.0, 1.0}, a, 0.1);
    expect_gradients(*camera_motion_cost(Q, 0.1), {pa, ma, pb, mb}, manifold);
    const SmallVector anchor = a.position + vector(0.3);
    const Eigen::Vector3d ray = a.orientation * Eigen::Vector3d(0.2 * normal(engine), 0.1, 1.0);
    SmallVector y(3), w = vector(0.3);
    y << angles(ray, 0.0), 0.2;
    expect_gradients(*pixel_cost(pinhole(), {300, 200}, 1.0), {pa, ma, anchor, y}, manifold);
    expect_gradients(*first_pixel_cost(pinhole(), {300, 200}, 1.0), {ma, y}, manifold);
    const SmallVector mean = SmallVector::Constant(1, 0.3);
    expect_gradients(*shared_inverse_depth_cost({}), {y, mean}, manifold);
    expect_gradients(*known_landmark_cost({1, vector(2.0), 0.1}), {anchor, y}, manifold);
    for (const LandmarkFunctions& landmark : landmark_table()) {
      auto chain = std::make_shared<Chain>(Chain{&landmark, {}});
      std::vector<SmallVector> blocks{pa, ma, anchor, y, w};
      for (int i = 0; i < 3; ++i) {
        Vector6d x;
        x << y, w;
        chain->steps.push_back({0.1, landmark.noise_root(x, 1.0, 0.1)});
        SmallVector noise(6);
        for (double& v : noise) v = normal(engine);
        blocks.push_back(noise);
      }
      expect_gradients(ChainPixelCost(pinhole(), {300, 200}, 1.0, chain, 3), blocks, manifold);
    }
  }
}

}  // namespace
}  // namespace slammot
