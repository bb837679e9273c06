// The step that Gauss-Newton does not see: along the scale.
//
// Where next to nothing tells the scale, a frame may end a few per cent from the least cost: pixels
// do not change along n(x) = dx / d(log scale), so that no residual tells the stopping rule
// (optimise.h) that a step is due. What is left differs from frame to frame, and poses of different
// frames are then of different scales. Along x(t) = S(t) x the prior is quadratic in t
// (scale_chart.h), pixels and relative spreads of depth are constant, and the few other factors are
// asked for their Jacobian along n.
#pragma once

#include "smoothers/graph/graph.h"

namespace slammot {

// x := S(t) x for the t of least cost. Stored linearisations stay as they are. Returns t.
double slide_along_scale(Graph& graph);

// |J n|^2 and J n . r of everything that tells the scale, at the estimate.
Eigen::Vector2d information_of_scale(const Graph& graph);

}  // namespace slammot
