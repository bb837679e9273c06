#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "eval/metrics/nees.h"
#include "eval/run/alternatives.h"
#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

const double kAbsurd = std::log(10.0);  // of the mean NEES over its degrees of freedom
const double kFitting = std::log(1.5);

Matrix6d unchanged(const Matrix6d& P, bool) { return P; }

// The 21 numbers in their order, laid out by rows of the lower triangle.
Matrix6d lower_triangle(const Matrix6d& P, bool) {
  Matrix6d other;
  for (int i = 0, row = 0, column = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      other(row, column) = other(column, row) = P(i, j);
      if (column++ == row) column = 0, ++row;
    }
  }
  return other;
}

// Of the same correlations.
Matrix6d squared(const Matrix6d& P, bool) {
  const Eigen::Matrix<double, 6, 1> sigma = P.diagonal().cwiseSqrt();
  return sigma.asDiagonal() * P * sigma.asDiagonal();
}

Matrix6d in_radians(const Matrix6d& P, bool rotation_first) {
  Eigen::Matrix<double, 6, 1> unit = Eigen::Matrix<double, 6, 1>::Ones();
  unit.segment<3>(rotation_first ? 0 : 3).setConstant(std::numbers::pi / 180.0);
  return unit.asDiagonal() * P * unit.asDiagonal();
}

Matrix6d inverse(const Matrix6d& P, bool) { return P.inverse(); }

struct Layout {
  const char* name;
  Matrix6d (*as)(const Matrix6d& P, bool rotation_first);
};

constexpr Layout kLayouts[] = {{"", unchanged},
                               {"with rotations in degrees", in_radians},
                               {"as standard deviations, squared,", squared},
                               {"as a lower triangle by rows", lower_triangle},
                               {"as information, inverted,", inverse}};

struct Fit {
  double misfit = std::numeric_limits<double>::infinity();  // largest |log(mean NEES / dof)|
  const char* part = "pose";
  double mean = 0.0;  // NEES of that part
};

// Of the parts that have a NEES; the pose is named where it has one.
Fit fit_of(const std::vector<PosePair>& pairs) {
  const PoseConsistency consistency = pose_consistency(pairs);
  const std::pair<const char*, const NeesSummary*> parts[] = {{"pose", &consistency.pose},
                                                              {"rotation", &consistency.rotation},
                                                              {"position", &consistency.position}};
  Fit fit;
  bool named = false;
  for (const auto& [name, summary] : parts) {
    if (std::isnan(summary->mean)) continue;
    const double misfit = std::abs(std::log(summary->mean / summary->dof));
    fit.misfit = named ? std::max(fit.misfit, misfit) : misfit;
    if (named) continue;
    named = true;
    fit.part = name;
    fit.mean = summary->mean;
  }
  return fit;
}

Fit fit_as(std::vector<PosePair> pairs, const Layout& layout, const ErrorConvention& convention) {
  const bool rotation_first = convention.order == ErrorConvention::Order::kRotationFirst;
  for (PosePair& pair : pairs) {
    auto P = pair.estimate.covariance.topLeftCorner<6, 6>();
    P = to_our_error(layout.as(P, rotation_first), convention, pair.estimate.state);
  }
  return fit_of(pairs);
}

struct Alternative {
  std::string name;
  Fit fit;
};

// The best of one group of alternatives, if it fits; of those that chance does not tell apart the
// first: the mean of `poses` NEES of 3 degrees of freedom has a relative variance of 2 / (3 poses).
std::optional<Alternative> best_of(const std::vector<Alternative>& group, std::size_t poses) {
  const double tie = 2.0 * std::sqrt(2.0 / (3.0 * static_cast<double>(poses)));
  const Alternative* best = nullptr;
  for (const Alternative& a : group) {
    if (!(a.fit.misfit < kFitting)) continue;
    if (best == nullptr || a.fit.misfit < best->fit.misfit - tie) best = &a;
  }
  return best == nullptr ? std::nullopt : std::optional(*best);
}

int words_changed(const ErrorConvention& a, const ErrorConvention& b) {
  return (a.order != b.order) + (a.rotation != b.rotation) + (a.position != b.position);
}

// What changes less comes first.
std::optional<Alternative> fitting(const std::vector<PosePair>& pairs,
                                   const ErrorConvention& stated) {
  std::vector<Alternative> conventions, layouts, both;
  std::vector<ErrorConvention> others = error_conventions();
  std::ranges::stable_sort(others, {},
                           [&](const auto& other) { return words_changed(other, stated); });
  for (const Layout& layout : kLayouts) {
    const bool plain = layout.as == unchanged;
    if (!plain) layouts.push_back({layout.name, fit_as(pairs, layout, stated)});
    for (const ErrorConvention& other : others) {
      const std::string option = "with --error-convention " + to_string(other);
      const std::string name = plain ? option : std::string(layout.name) + " and " + option;
      (plain ? conventions : both).push_back({name, fit_as(pairs, layout, other)});
    }
  }
  for (const auto* group : {&conventions, &layouts, &both}) {
    if (auto found = best_of(*group, pairs.size())) return found;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> other_covariances(const std::vector<PosePair>& as_written,
                                             const ErrorConvention& stated) {
  constexpr std::size_t kFewest = 10;  // poses: a mean over fewer is no sign
  if (as_written.size() < kFewest) return std::nullopt;
  const Fit read = fit_as(as_written, kLayouts[0], stated);
  if (!(read.misfit > kAbsurd)) return std::nullopt;
  const auto other = fitting(as_written, stated);
  if (!other) return std::nullopt;
  return fmt::format("NEES of the {} {:.4g} as read; {} {:.4g}", read.part, read.mean, other->name,
                     other->fit.mean);
}

}  // namespace slammot
