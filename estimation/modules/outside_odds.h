// What something else than the measurements says of a track, as a network's masks do: a probability
// of rest (priors.csv). Its odds stand in place of the classifier's prior odds o_0.
//
// So it is evidence beside that of the measurements, the logarithm of its odds over o_0, and is
// added to theirs: where the classifier is asked, and where one that is held at its birth is in
// doubt (label_revision.h). One that moves rather than rests is free from its first pixel. It does
// not count where innovations undo a label, nor where rest is beyond doubt and its motion
// forgotten: what was said wrongly must stay open to measurements.
#pragma once

#include <map>

#include "estimation/options.h"

namespace slammot {

class OutsideOdds {
 public:
  // `p_static` by track; `prior_odds`: of all others.
  OutsideOdds(const std::map<int, double>& p_static, double prior_odds);

  bool speaks_of(int track) const { return evidence_.contains(track); }
  // Of rest, a logarithm; 0 where nothing is said.
  double evidence(int track) const;
  // What is believed of it at its birth, where `births` is of those of which nothing is said.
  Births births(int track, Births births) const;

 private:
  double log_prior_odds_;
  std::map<int, double> evidence_;
};

}  // namespace slammot
