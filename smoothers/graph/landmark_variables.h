// A landmark as variables of a graph, in the window and in the batch alike: y at its base, and
// while it is free w and the noises of its chain (landmark_chain.h).
#pragma once

#include <optional>

#include "estimation/landmark_estimate.h"
#include "smoothers/graph/landmark_chain.h"
#include "smoothers/graph/state_projection.h"

namespace slammot {

struct LandmarkVariables {
  VariableId anchor = 0;           // camera position at its birth
  VariableId y = 0;                // at the base
  std::optional<VariableId> w;     // at the base; none when static
  std::shared_ptr<Chain> chain;    // from the base on; none when static
  std::vector<VariableId> noises;  // of the chain's steps
};

// The states (y, w) from the base to the end of the chain.
std::vector<Vector6d> chain_states(const Graph& graph, const LandmarkVariables& landmark);

// The last of them with its Jacobian, taken where the factors' are, and the variables that this one
// stands for.
ChainState newest_state(const Graph& graph, const LandmarkVariables& landmark);
std::vector<VariableId> state_variables(const LandmarkVariables& landmark);

// The noises follow the landmark's depth (lead_through); the largest change of one, in sigmas.
double refresh_noises(Graph& graph, const LandmarkVariables& landmark, double sigma_a);

// What a landmark's estimate is made of: its belief without the covariance, and the projection
// whose covariance that is, on the anchor and the newest state (6 rows when static, else 9).
struct LandmarkMarginal {
  LandmarkBelief belief;
  StateProjection projection;
};
LandmarkMarginal landmark_marginal(const Graph& graph, const LandmarkVariables& landmark);

// A pixel measured by the camera (position, motion), `depth` steps after the base.
struct MeasuredPixel {
  VariableId position = 0, motion = 0;
  Eigen::Vector2d pixel;
  int depth = 0;
};
FactorId add_pixel(Graph& graph, const LandmarkVariables& landmark, const MeasuredPixel& z,
                   const Camera& camera, double sigma, const ceres::LossFunction* loss);

}  // namespace slammot
