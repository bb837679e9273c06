#include "smoothers/solver/ceres_solve.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include "estimation/estimator.h"

namespace slammot {

namespace {

ceres::Problem::Options nothing_owned() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

ceres::Solver::Options solver_options(int max_iterations) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.gradient_tolerance = 1e-12;
  options.use_nonmonotonic_steps = true;  // stiff motion factors: see optimise.h
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

CeresSolution solve_with_ceres(Graph& graph, int max_iterations) {
  ceres::Problem problem(nothing_owned());
  for (const auto& [id, v] : graph.variables()) {
    problem.AddParameterBlock(graph.variable(id).value.data(), static_cast<int>(v.value.size()),
                              const_cast<ceres::Manifold*>(v.manifold));
  }
  CeresSolution solution;
  for (const auto& [id, factor] : graph.factors()) {
    std::vector<double*> blocks;
    for (const VariableId v : factor.variables) blocks.push_back(graph.variable(v).value.data());
    // A landmark that starts behind its camera has no residual there: as in Graph::linearise its
    // measurement counts for nothing until the others have brought it to the front.
    Eigen::VectorXd unused(factor.cost->num_residuals());
    if (!factor.cost->Evaluate(blocks.data(), unused.data(), nullptr)) {
      ++solution.waiting;
      continue;
    }
    problem.AddResidualBlock(factor.cost.get(), const_cast<ceres::LossFunction*>(factor.loss),
                             blocks);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(max_iterations), &problem, &summary);
  if (summary.termination_type != ceres::CONVERGENCE) {
    throw Diverged("no solution: " + summary.message);
  }
  solution.iterations = static_cast<int>(summary.iterations.size());
  return solution;
}

}  // namespace slammot
