// A landmark's own part in a marginalisation: its rows that leave the graph, and the substitution
// that takes its base along its chain.
//
// The base moves on by d steps: x_0 = f^-1(.. x_d, n_1 .. n_d), so that in every row
//   dx_0 = Psi dx_d + N dn,   from dx_k = F_{k+1}^-1 (dx_{k+1} - G_{k+1} dn_{k+1}).
// This is the time update of a square-root information filter (Bierman 1977): Q = G G' is never
// inverted and may be singular. What only these rows touch is eliminated here, by a small QR;
// what is left goes into that of the prior. Where the prior holds x_0, the noises are first rotated
// so that only as many of them as x has numbers reach it: dx_0 = Psi dx_d + noise_gain dn.
#pragma once

#include <limits>

#include "smoothers/graph/graph.h"
#include "smoothers/linear/triangularise.h"

namespace slammot {

struct Departure {
  LandmarkId landmark = 0;
  int steps = 0;          // of the chain that the base moves on
  bool all_rows = false;  // else the oldest camera's only; `steps` is then the whole chain
  bool absorbs_prior_of_w = false;
  bool forgets_w = false;  // it is static from then on
  bool leaves = false;     // all of it
  double until = kNever;   // measurements up to this time go too [s]

  bool takes(const GraphPixel& pixel, VariableId oldest) const {
    return all_rows || pixel.position == oldest || pixel.time <= until;
  }
  static constexpr double kNever = -std::numeric_limits<double>::infinity();
};

class LocalElimination {
 public:
  void compute(const Graph& graph, const Departure& departure, VariableId oldest);

  const Departure& departure() const { return departure_; }

  // What the rows touch; `variable` -1: the noise of the substitution.
  struct Segment {
    VariableId variable = -1;
    int column = 0, dim = 0;
  };
  const std::vector<Segment>& segments() const { return segments_; }
  // The rows that are left, with the residual as last column.
  auto rows() const { return (*A_).bottomRows((*A_).rows() - eliminated_rows_); }
  Eigen::Index residual_column() const { return (*A_).cols() - 1; }

  // Whether the prior holds x_0, and the noise's columns.
  bool substitutes() const { return substitutes_; }
  int noise_dim() const { return substitutes_ ? static_cast<int>(noise_gain.cols()) : 0; }
  LandmarkMatrix Psi, noise_gain;
  LandmarkVector next;   // x_d at the current estimate
  int noise_column = 0;  // in the marginalisation

 private:
  void lay_out(const Graph& graph, const GraphLandmark& landmark, VariableId oldest);
  int place_own(const Graph& graph, const GraphLandmark& l);
  int place_touched(const Graph& graph, const GraphLandmark& l, VariableId oldest, int column);
  Eigen::Index count_rows(const GraphLandmark& l, VariableId oldest) const;
  int column_of(VariableId id) const;  // of one of the segments
  Eigen::Index fill_birth(Eigen::Index row, const GraphLandmark& l);
  void fill(const GraphLandmark& landmark, VariableId oldest);
  void fill_on_state(Eigen::Index row, Eigen::Index rows, int depth, LandmarkMatrix coefficient,
                     const GraphLandmark& landmark);
  void rotate_noises();
  void follow_chain(const Graph& graph, const GraphLandmark& landmark);
  bool takes_birth(const GraphLandmark& landmark, VariableId oldest) const {
    return departure_.all_rows || landmark.anchor == oldest;
  }

  Departure departure_;
  bool substitutes_ = false;
  int dim_ = 3;                                               // of x
  int noises_ = 0;                                            // columns of all noises
  int eliminated_ = 0;                                        // columns
  int y_column_ = 0, w_column_ = 0, constrained_column_ = 0;  // -1: none
  Eigen::Index eliminated_rows_ = 0;
  std::vector<Segment> segments_;
  GrowingMatrix N_, A_;
  Triangularise triangularise_;
  std::vector<int> starts_;
};

}  // namespace slammot
