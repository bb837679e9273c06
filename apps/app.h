// The program: all commands. Exit codes: 0 done, 1 the run failed, 2 bad usage or bad input.
//
// A program of a user's own is this one with more rows in its tables (docs/extending.md):
//   int main(int argc, char** argv) { return slammot::app::main(argc, argv, {.classifiers = ..}); }
#pragma once

#include <map>
#include <string>
#include <vector>

#include "datasets/readers/reader.h"
#include "datasets/simulation/scenario.h"
#include "estimation/classification.h"
#include "eval/configuration/registry.h"
#include "eval/metrics/metric.h"
#include "models/landmarks/extra_model.h"

#ifndef SLAMMOT_INSTALLED_SHARE
#define SLAMMOT_INSTALLED_SHARE ""  // found beside the program, or in the source tree
#endif

namespace slammot::app {

struct Extras {
  std::string program = "slammot";           // its name in messages and results
  std::vector<LandmarkFunctions> landmarks;  // landmark_rows<Model>()
  std::vector<ClassifierRow> classifiers;
  std::vector<EstimatorRow> estimators;
  std::vector<ReaderRow> readers;
  std::vector<ScenarioRow> scenarios;  // scenario_row<Options, simulate>(name, description)
  MetricTable metrics;
  std::map<std::string, double> numbers;  // configuration keys and their defaults; a classifier
                                          // finds them in ClassifierOptions::own
};

// `share`: the folder of the report's files, where it is not found from the program's path.
int run(int argc, char** argv, const Extras& extras, const char* share);

inline int main(int argc, char** argv, const Extras& extras = {}) {
  return run(argc, argv, extras, SLAMMOT_INSTALLED_SHARE);
}

}  // namespace slammot::app
