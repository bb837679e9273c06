// What the runs of a cell say together of landmarks: by the number of their measurements, and of
// the recorded tracks in every frame.
#pragma once

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "eval/statistics/bootstrap.h"

namespace slammot {

class LandmarkAges {
 public:
  void add(const nlohmann::ordered_json& landmarks);  // of one run (docs/formats.md)
  nlohmann::ordered_json json() const;

 private:
  struct Age {
    std::vector<double> statics, movings, velocities;  // errors, of all runs
    std::vector<RunSum> position_nees, velocity_nees;  // by run
  };
  std::map<int, Age> ages_;  // by number of measurements
};

class RecordedTracks {
 public:
  void add(const nlohmann::ordered_json& tracks);  // of one run
  nlohmann::ordered_json json() const;             // medians over the runs

 private:
  using ByAxis = std::array<std::vector<double>, 3>;
  struct Moment {
    ByAxis velocity, sigma, truth;
  };
  std::map<int, std::map<int, Moment>> tracks_;  // by track and frame
};

}  // namespace slammot
