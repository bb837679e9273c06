// Chi-square distributions of even degrees of freedom, in closed form: pixels have two each.
#pragma once

namespace slammot {

// The 2-dof chi-square quantile, in closed form.
double pixel_threshold(double probability);

// log P(chi-square(2n) > x) = -x/2 + log sum_{k<n} (x/2)^k / k!, exact for even degrees of freedom.
double log_chi_square_tail(double x, int n);

// The chi-square value of 2 degrees of freedom that is as probable as `nis` of 2 `pixels`.
double as_of_one_pixel(double nis, int pixels);

}  // namespace slammot
