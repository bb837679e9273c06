#include "models/chi_square.h"

#include <cmath>

namespace slammot {

double pixel_threshold(double probability) { return -2.0 * std::log1p(-probability); }

double log_chi_square_tail(double x, int n) {
  double term = 1.0, sum = 0.0;
  for (int k = 0; k < n; ++k) {
    sum += term;
    term *= 0.5 * x / (k + 1);
  }
  return -0.5 * x + std::log(sum);
}

double as_of_one_pixel(double nis, int pixels) {
  return pixels == 1 ? nis : -2.0 * log_chi_square_tail(nis, pixels);
}

}  // namespace slammot
