// The chi-square distribution: what NEES and NIS are compared with. Computed by Boost.Math.
#pragma once

namespace slammot {

double chi_square_cdf(double x, double dof);
double chi_square_quantile(double probability, double dof);

// The mean of a chi-square variable that is kept only when below its quantile `gate_probability`: a
// gate's accepted NIS. E[x | x < q] = n F_{n+2}(q) / F_n(q); 1.685 for n = 2 and a 95% gate,
// n without one (probability 1).
double gated_mean(double gate_probability, double dof);

struct Interval {
  double lower;
  double upper;
};

// Two-sided interval of the mean NEES over `runs` independent runs: chi2inv(tails, runs n) / runs.
Interval nees_interval(int dof, int runs = 1, double probability = 0.95);

}  // namespace slammot
