// Two estimators in runs that belong together: who has the smaller error, and by how much.
#pragma once

#include <vector>

#include "eval/statistics/bootstrap.h"

namespace slammot {

class PairedErrors {
 public:
  // The errors of a pair of runs. A diverged run's is infinite: it loses, and the pair has no
  // difference. Errors that differ by less than a billionth of the larger are equal: that is
  // rounding, and rounding can have one sign in all pairs.
  void add(double a, double b);

  int pairs() const { return pairs_; }
  int wins_a() const { return wins_a_; }
  int wins_b() const { return wins_b_; }
  Estimate difference() const;  // mean of a - b with its bootstrap interval

 private:
  int pairs_ = 0, wins_a_ = 0, wins_b_ = 0;
  std::vector<double> differences_;
};

}  // namespace slammot
