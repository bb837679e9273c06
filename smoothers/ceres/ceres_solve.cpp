#include "smoothers/ceres/ceres_solve.h"

#include <ceres/solver.h>

#include <algorithm>
#include <cmath>

#include "estimation/estimator.h"
#include "smoothers/ceres/cost_functions.h"
#include "smoothers/ceres/manifolds.h"
#include "smoothers/scale/noise_scale.h"

namespace slammot {

namespace {

ceres::Solver::Options solver_options(int max_iterations, double function_tolerance) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = function_tolerance;
  options.parameter_tolerance = 1e-14;
  options.gradient_tolerance = 1e-12;
  options.use_nonmonotonic_steps = true;  // stiff motion factors: see optimise.h
  options.logging_type = ceres::SILENT;
  return options;
}

// u(v) of a motion at the estimate; 0: its noise is in metres (noise_scale.h).
double speed(const Graph& graph, const CameraMotionFactor& f) {
  if (graph.models().noise_tells_scale) return 0.0;
  return unit_of_speed(graph.camera(f.to).velocity, unknown_speed(f.weight));
}

std::vector<double> speeds(const Graph& graph) {
  std::vector<double> all;
  for (const CameraMotionFactor& f : graph.motions) all.push_back(speed(graph, f));
  return all;
}

// Relative to what they were.
double largest_change(const std::vector<double>& before, const std::vector<double>& after) {
  double largest = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] > 0.0) largest = std::max(largest, std::abs(after[i] / before[i] - 1.0));
  }
  return largest;
}

constexpr double kSameSpeed = 1e-7;  // a relative change of it

// Adds a graph's factors to a problem.
class Builder {
 public:
  explicit Builder(Graph& graph) : graph_(graph), problem_(std::make_unique<ceres::Problem>()) {
    graph.variables.for_each([&](Variable& v) {
      const auto size = static_cast<int>(v.value.size());
      if (v.is_orientation) {
        problem_->AddParameterBlock(v.value.data(), size, new OrientationManifold);
      } else {
        problem_->AddParameterBlock(v.value.data(), size);
      }
      if (v.is_constrained || v.is_considered) problem_->SetParameterBlockConstant(v.value.data());
    });
  }

  CeresProblem build() {
    add_cameras();
    for (GraphLandmark& l : graph_.landmarks) {
      if (graph_.is_solved_jointly(l)) add_landmark(l);
    }
    const MarginalPrior& prior = graph_.prior().active;
    if (prior.cols() > 0) {
      std::vector<double*> blocks;
      for (const MarginalPrior::Block& b : prior.blocks()) {
        if (b.variable->is_considered) continue;
        blocks.push_back(value(b.variable->id));
      }
      problem_->AddResidualBlock(marginal_prior_cost(prior).release(), nullptr, blocks);
    }
    return {std::move(problem_), waiting_};
  }

 private:
  double* value(VariableId id) { return graph_.variables[id].value.data(); }

  void add_cameras() {
    const auto blocks = [&](const GraphCamera& c) {
      return std::vector<double*>{value(c.position), value(c.orientation), value(c.rates)};
    };
    if (graph_.initial) {
      problem_->AddResidualBlock(initial_camera_cost(graph_.initial->initial).release(), nullptr,
                                 blocks(graph_.initial->camera));
    }
    for (const CameraMotionFactor& f : graph_.motions) {
      std::vector<double*> both = blocks(f.from);
      for (double* block : blocks(f.to)) both.push_back(block);
      problem_->AddResidualBlock(camera_motion_cost(f.weight, f.dt, speed(graph_, f)).release(),
                                 nullptr, both);
    }
    if (!graph_.scene) return;
    const ScenePrior& scene = *graph_.scene;
    add_gaussian(value(scene.scene), Eigen::VectorXd::Constant(1, scene.inverse_depth),
                 Eigen::VectorXd::Constant(1, scene.sigma));
  }

  void add_gaussian(double* block, const Eigen::VectorXd& mean, const Eigen::VectorXd& sigmas) {
    problem_->AddResidualBlock(gaussian_cost(mean, sigmas).release(), nullptr,
                               std::vector<double*>{block});
  }

  void add_landmark(GraphLandmark& l) {
    const PointFunctions& point = graph_.models().point();
    if (lacks_infinity(point)) {
      problem_->SetManifold(value(l.y), new FarPointManifold(point, graph_.farthest(l)));
    }
    add_birth(l);
    if (l.w_prior.unit > 0.0) {
      problem_->AddResidualBlock(motion_prior_cost(graph_.models(), l.w_prior).release(), nullptr,
                                 std::vector<double*>{value(l.y), value(l.w)});
    } else if (l.w_prior.rows() > 0) {
      add_gaussian(value(l.w), Eigen::VectorXd::Zero(l.w_prior.rows()), l.w_prior.sigmas);
    }
    for (ChainStep& step : l.chain) {
      const Eigen::Index dim = step.noise.size();
      add_gaussian(step.noise.data(), Eigen::VectorXd::Zero(dim), Eigen::VectorXd::Ones(dim));
    }
    for (const GraphPixel& pixel : l.pixels) add_pixel(l, pixel);
  }

  void add_birth(const GraphLandmark& l) {
    std::vector<double*> blocks{value(l.y)};
    if (l.birth.kind == BirthPrior::Kind::kNone) return;
    if (l.birth.kind == BirthPrior::Kind::kSharedDepth) blocks.push_back(value(l.birth.scene));
    if (l.birth.kind == BirthPrior::Kind::kKnown) blocks = {value(l.anchor), value(l.y)};
    problem_->AddResidualBlock(birth_cost(graph_.models().point(), l.birth).release(), nullptr,
                               blocks);
  }

  void add_pixel(GraphLandmark& l, const GraphPixel& pixel) {
    std::vector<double*> blocks{value(pixel.position), value(pixel.orientation), value(l.anchor),
                                value(l.y)};
    if (pixel.z.here) blocks = {value(pixel.orientation), value(l.y)};
    Cost cost;
    if (pixel.depth == 0) {
      cost = pixel_cost(graph_.models(), pixel.z);
    } else {
      blocks.push_back(value(l.w));
      for (int i = 0; i < pixel.depth; ++i) {
        blocks.push_back(l.chain[static_cast<std::size_t>(i)].noise.data());
      }
      cost = chain_pixel_cost(graph_.models(), pixel.z, l.chain, pixel.depth);
    }
    // A landmark that starts behind its camera has no residual there: as in Graph::linearise its
    // measurement counts for nothing until the others have brought it to the front.
    double unused[2];
    if (!cost->Evaluate(blocks.data(), unused, nullptr)) {
      ++waiting_;
      return;
    }
    problem_->AddResidualBlock(cost.release(), nullptr, blocks);
  }

  Graph& graph_;
  std::unique_ptr<ceres::Problem> problem_;
  int waiting_ = 0;
};

}  // namespace

CeresProblem ceres_problem(Graph& graph) { return Builder(graph).build(); }

CeresSolution solve_with_ceres(Graph& graph, int max_iterations, double function_tolerance) {
  const std::vector<double> before = speeds(graph);
  const CeresProblem built = ceres_problem(graph);
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(max_iterations, function_tolerance), built.problem.get(), &summary);
  if (!summary.IsSolutionUsable()) throw Diverged("no solution: " + summary.message);
  const bool has_settled = largest_change(before, speeds(graph)) <= kSameSpeed;
  return {built.waiting, static_cast<int>(summary.iterations.size()),
          summary.termination_type == ceres::CONVERGENCE && has_settled};
}

}  // namespace slammot
