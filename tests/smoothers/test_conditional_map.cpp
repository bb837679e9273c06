// The conditional map against graphs in which every variable stays active.
#include <gtest/gtest.h>

#include "smoothers/graph/factors.h"
#include "smoothers/graph/state_projection.h"
#include "smoothers/solver/marginalise.h"
#include "smoothers/solver/normal_equations.h"
#include "tests/smoothers/linear_problem.h"

namespace slammot {
namespace {

// Variables that rest in the far map while others leave, come back and are measured again.
TEST(ConditionalMap, ToDeactivateAndReactivateChangesNothing) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Graph whole = test::linear_problem(seed), part = test::linear_problem(seed);
    marginalise(part, {0}, {}, {}, {1});
    marginalise(part, {2}, {}, {}, {5, 8});
    marginalise(part, {3});
    EXPECT_EQ(part.prior().inactive.dim(), 9);

    const std::vector<StateProjection> asked{{{1, 8, 9}, Eigen::MatrixXd::Identity(9, 9)}};
    const Eigen::MatrixXd P = NormalEquations(whole).covariances(asked).front();
    std::vector<StateProjection> active = asked;
    Eigen::MatrixXd P_part = substitute_inactive(part, active.front());
    P_part += NormalEquations(part).covariances(active).front();
    EXPECT_LT((P - P_part).norm(), 1e-10 * P.norm()) << "seed " << seed;

    part.retract(NormalEquations(part).step());
    whole.retract(NormalEquations(whole).step());
    EXPECT_LT((part.value(5) - whole.value(5)).norm(), 1e-10);
    EXPECT_LT((values(part).at(8) - whole.value(8)).norm(), 1e-10);
    part.reactivate({5, 1});
    EXPECT_EQ(part.prior().inactive.dim(), 3);
    for (Graph* graph : {&whole, &part}) {
      std::mt19937_64 engine(100 + seed);
      graph->add_factor({1, 5}, std::make_unique<test::LinearCost>(engine));
      graph->add_factor({5, 10}, std::make_unique<test::LinearCost>(engine));
    }
    part.prior().relinearise();
    marginalise(part, {4, 6});
    part.retract(NormalEquations(part).step());
    whole.retract(NormalEquations(whole).step());
    for (const VariableId id : {1, 5, 7, 8, 9, 10, 11}) {
      EXPECT_LT((part.value(id) - whole.value(id)).norm(), 1e-9) << "seed " << seed;
    }
  }
}

// That an active variable is zero, stated by conditioning and by a factor of small sigma: the rest
// of the prior and the inactive variables must agree.
TEST(ConditionalMap, ConditioningOnZeroIsAFactorThatSaysSo) {
  constexpr double kSigma = 1e-5;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Graph stated = test::linear_problem(seed), measured = test::linear_problem(seed);
    for (Graph* graph : {&stated, &measured}) {
      graph->retract(NormalEquations(*graph).step());
      marginalise(*graph, {0, 2, 3}, {}, {}, {1});
      ASSERT_TRUE(graph->prior().active.find(4));
      marginalise(*graph, {5});  // factors of 4 other than the prior are gone
    }
    measured.add_factor({4}, motion_prior_cost(kSigma));
    measured.retract(NormalEquations(measured).step());
    stated.prior().condition_on_zero(4);
    EXPECT_FALSE(stated.prior().active.find(4));
    stated.remove_variables({4});
    stated.retract(NormalEquations(stated).step());
    for (const VariableId id : {1, 6, 7, 8, 9, 10, 11}) {
      EXPECT_LT((stated.value(id) - measured.value(id)).norm(), 1e-6) << "seed " << seed;
    }
  }
}

TEST(Graph, KeepsWhatThePriorTouches) {
  Graph graph = test::linear_problem(1);
  marginalise(graph, {0});
  EXPECT_THROW(graph.remove_variables({1}), std::logic_error);
}

}  // namespace
}  // namespace slammot
