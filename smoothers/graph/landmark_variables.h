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

// The mean inverse depth of the scene with its prior; nothing when it is known (mean_sigma = 0).
std::optional<VariableId> add_scene(Graph& graph, const LandmarkPrior& prior);

// The states (y, w) from the base to the end of the chain, at the current estimate. For a free
// landmark only.
std::vector<LandmarkVector> chain_states(const Graph& graph, const LandmarkVariables& landmark);

// The newest state at the current estimate, with its Jacobian (3 rows when static) with respect to
// state_variables(), taken at their linearisation points as in the factors. A static landmark may
// be inactive.
ChainState newest_state(const Graph& graph, const LandmarkVariables& landmark);

// y, and while the landmark is free w and the noises of its chain.
std::vector<VariableId> state_variables(const LandmarkVariables& landmark);

// Renews G of the chain and the noises, so that the states stay (lead_through). Returns the largest
// change of a noise, in sigmas; 0 for a static landmark.
double refresh_noises(Graph& graph, const LandmarkVariables& landmark, const LandmarkPrior& prior);

// What a landmark's estimate is made of: its belief without the covariance, and the projection
// whose covariance that is, on the anchor and the newest state (6 rows when static, else 9).
struct LandmarkMarginal {
  LandmarkBelief belief;
  StateProjection projection;
};
LandmarkMarginal landmark_marginal(const Graph& graph, const LandmarkVariables& landmark);

// A pixel [px] measured by the camera (position, motion), `depth` steps after the base.
struct MeasuredPixel {
  VariableId position = 0, motion = 0;
  Eigen::Vector2d pixel;
  int depth = 0;
};
// Adds its factor, in the form that fits: measured from the anchor, from a static or base state, or
// along the chain. `sigma` in px.
FactorId add_pixel(Graph& graph, const LandmarkVariables& landmark, const MeasuredPixel& z,
                   const Camera& camera, double sigma, const ceres::LossFunction* loss);

}  // namespace slammot
