#include "eval/statistics/chi_square.h"

#include <boost/math/distributions/chi_squared.hpp>

namespace slammot {

using Distribution = boost::math::chi_squared_distribution<double>;

double chi_square_cdf(double x, double dof) {
  return x <= 0.0 ? 0.0 : boost::math::cdf(Distribution(dof), x);
}

double chi_square_quantile(double probability, double dof) {
  return boost::math::quantile(Distribution(dof), probability);
}

double gated_mean(double gate_probability, double dof) {
  if (gate_probability == 1.0) return dof;  // no gate
  const double gate = chi_square_quantile(gate_probability, dof);
  return dof * chi_square_cdf(gate, dof + 2.0) / gate_probability;
}

Interval nees_interval(int dof, int runs, double probability) {
  const double tail = (1.0 - probability) / 2.0;
  const Distribution distribution(static_cast<double>(dof) * runs);
  // The complement keeps the upper tail exact for tiny tails.
  return {boost::math::quantile(distribution, tail) / runs,
          boost::math::quantile(boost::math::complement(distribution, tail)) / runs};
}

}  // namespace slammot
