#include "eval/metrics/true_rotations.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "eval/metrics/accuracy.h"

namespace slammot {
namespace {

constexpr double kTurns = 5.0;  // [deg], more than a consistent estimate of no turn is off

using Rotations = std::vector<Eigen::Quaterniond>;

// The largest angle between `first` and a rotation [deg].
double farthest_deg(const Eigen::Quaterniond& first, const Rotations& rotations) {
  double farthest = 0.0;
  for (const auto& q : rotations) farthest = std::max(farthest, first.angularDistance(q));
  return farthest * 180.0 / std::numbers::pi;
}

double span_deg(const Rotations& rotations) {
  double span = 0.0;
  for (const auto& q : rotations) span = std::max(span, farthest_deg(q, rotations));
  return span;
}

}  // namespace

std::optional<EqualRotations> equal_rotations(const std::vector<PosePair>& pairs,
                                              bool after_alignment, bool trusted) {
  constexpr double kEqual = 1e-6;  // [deg]
  if (pairs.size() < 2 || failed_at(pairs, after_alignment)) return std::nullopt;
  Rotations truth, run;
  for (const PosePair& pair : pairs) {
    truth.push_back(pair.truth.orientation);
    run.push_back(pair.estimate.state.orientation);
  }
  const double of_truth = farthest_deg(truth.front(), truth);
  const double of_run = farthest_deg(run.front(), run);
  if (of_truth <= kEqual && of_run > kTurns) {
    return EqualRotations{!trusted,
                          fmt::format("all true rotations are equal, while those of the "
                                      "run span {:.1f} deg{}",
                                      span_deg(run), trusted ? "" : ": rotations are not judged")};
  }
  if (of_run <= kEqual && of_truth > kTurns) {
    return EqualRotations{false, fmt::format("all rotations of the run are equal, while the true "
                                             "ones span {:.1f} deg",
                                             span_deg(truth))};
  }
  return std::nullopt;
}

}  // namespace slammot
