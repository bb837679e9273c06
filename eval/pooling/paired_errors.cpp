#include "eval/pooling/paired_errors.h"

#include <algorithm>
#include <cmath>

#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

constexpr double kRounding = 1e-9;

bool are_equal(double a, double b) {
  if (!std::isfinite(a) || !std::isfinite(b)) return a == b;
  return std::abs(a - b) <= kRounding * std::max(std::abs(a), std::abs(b));
}

}  // namespace

void PairedErrors::add(double a, double b) {
  const bool equal = are_equal(a, b);
  ++pairs_;
  wins_a_ += !equal && a < b;
  wins_b_ += !equal && b < a;
  if (std::isfinite(a) && std::isfinite(b)) differences_.push_back(equal ? 0.0 : a - b);
}

Estimate PairedErrors::difference() const { return bootstrap(differences_, mean); }

}  // namespace slammot
