// The NEES of one run, frame by frame: is its mean more than chance allows, and where did it begin?
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace slammot {

// How many independent samples say as much about their mean as these correlated ones:
// n / (1 + 2 sum of autocorrelations), summed in pairs as long as a pair is positive (Geyer 1992).
// At least 1, at most n.
double effective_samples(std::vector<double> series);

// The mean of a run's NEES over its frames.
struct RunNees {
  double mean = 0.0;
  double allowed = 0.0;  // the quantile of a consistent estimator's, with this run's correlation
  std::optional<std::size_t> began;  // the sample from which it is too large, when mean > allowed

  bool exceeds() const { return mean > allowed; }
};

// `probability` that the mean of a consistent run is allowed. Where it began: the sample after
// which the sum of (NEES - 2 dof) rises to its largest value without being below zero (Page's
// CUSUM, 1954). One infinite sample (a covariance that is not positive definite) makes the mean
// infinite, from that sample on. Undefined samples are left out; none at all gives NaN.
RunNees run_nees(const std::vector<double>& series, int dof, double probability = 0.99);

}  // namespace slammot
