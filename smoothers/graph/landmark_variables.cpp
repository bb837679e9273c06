#include "smoothers/graph/landmark_variables.h"

#include "smoothers/graph/factors.h"

namespace slammot {

namespace {

LandmarkVector base_state(const Graph& graph, const LandmarkVariables& l) {
  return landmark_state(graph.value(l.y), graph.value(*l.w));
}

std::vector<LandmarkVector> noise_values(const Graph& graph, const LandmarkVariables& l) {
  std::vector<LandmarkVector> values;
  for (const VariableId n : l.noises) values.emplace_back(graph.value(n));
  return values;
}

// The newest state's Jacobian where those of the factors are taken.
Eigen::MatrixXd jacobian_at_points(const Graph& graph, const LandmarkVariables& l) {
  const LandmarkVector base =
      landmark_state(linearisation_point(graph, l.y), linearisation_point(graph, *l.w));
  std::vector<LandmarkVector> noises;
  for (const VariableId n : l.noises) noises.emplace_back(linearisation_point(graph, n));
  return propagate(*l.chain, base, noises).J;
}

}  // namespace

std::optional<VariableId> add_scene(Graph& graph, const LandmarkPrior& prior) {
  if (!(prior.mean_sigma > 0.0)) return std::nullopt;
  const VariableId scene =
      graph.add_variable(Eigen::VectorXd::Constant(1, prior.inverse_depth), nullptr, -1);
  graph.add_factor({scene}, scene_prior_cost(prior));
  return scene;
}

std::vector<LandmarkVector> chain_states(const Graph& graph, const LandmarkVariables& l) {
  return states(*l.chain, base_state(graph, l), noise_values(graph, l));
}

ChainState newest_state(const Graph& graph, const LandmarkVariables& l) {
  if (!l.w) return static_state(graph.value(l.y));
  ChainState state = propagate(*l.chain, base_state(graph, l), noise_values(graph, l));
  if (graph.prior().first_estimates()) state.J = jacobian_at_points(graph, l);
  return state;
}

std::vector<VariableId> state_variables(const LandmarkVariables& l) {
  std::vector<VariableId> variables{l.y};
  if (l.w) variables.push_back(*l.w);
  variables.insert(variables.end(), l.noises.begin(), l.noises.end());
  return variables;
}

double refresh_noises(Graph& graph, const LandmarkVariables& l, const LandmarkPrior& prior) {
  if (!l.w) return 0.0;
  const std::vector<LandmarkVector> noises = lead_through(*l.chain, chain_states(graph, l), prior);
  double change = 0.0;
  for (std::size_t i = 0; i < noises.size(); ++i) {
    change = std::max(change, (noises[i] - graph.value(l.noises[i])).cwiseAbs().maxCoeff());
    graph.variable(l.noises[i]).value = noises[i];
  }
  return change;
}

LandmarkMarginal landmark_marginal(const Graph& graph, const LandmarkVariables& l) {
  const ChainState state = newest_state(graph, l);
  const Eigen::Index dim = state.x.size();
  LandmarkMarginal result;
  result.belief.anchor = graph.value(l.anchor);
  result.belief.y = state.x.head<3>();
  result.belief.w = state.x.tail(state.x.size() - 3);
  result.projection.variables = state_variables(l);
  result.projection.variables.insert(result.projection.variables.begin(), l.anchor);
  result.projection.J.setZero(3 + dim, 3 + state.J.cols());
  result.projection.J.topLeftCorner<3, 3>().setIdentity();
  result.projection.J.bottomRightCorner(dim, state.J.cols()) = state.J.topRows(dim);
  return result;
}

FactorId add_pixel(Graph& graph, const LandmarkVariables& l, const MeasuredPixel& z,
                   const Camera& camera, double sigma, const ceres::LossFunction* loss) {
  if (z.position == l.anchor) {
    return graph.add_factor({z.motion, l.y}, first_pixel_cost(camera, z.pixel, sigma), loss);
  }
  std::vector<VariableId> variables{z.position, z.motion, l.anchor, l.y};
  if (z.depth == 0) {
    return graph.add_factor(variables, pixel_cost(camera, z.pixel, sigma), loss);
  }
  variables.push_back(*l.w);
  variables.insert(variables.end(), l.noises.begin(), l.noises.begin() + z.depth);
  return graph.add_factor(
      variables, std::make_unique<ChainPixelCost>(camera, z.pixel, sigma, l.chain, z.depth), loss);
}

}  // namespace slammot
