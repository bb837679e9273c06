// Order statistics and means of samples. Every function of no samples is NaN (null in JSON), so
// that "nothing was measured" is never mistaken for zero. Infinite samples are legal.
#pragma once

#include <vector>

namespace slammot {

double mean(const std::vector<double>& samples);
double root_mean_square(const std::vector<double>& samples);
double maximum(const std::vector<double>& samples);

// The quantile p in [0, 1], linear between order statistics (Hyndman & Fan's type 7, as numpy).
double quantile(std::vector<double> samples, double p);
inline double median(std::vector<double> samples) { return quantile(std::move(samples), 0.5); }

}  // namespace slammot
