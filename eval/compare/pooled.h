// What the runs of an estimator say together, and what two estimators say beside each other, for
// runs made now or read back.
//
// Estimates are means over runs (root mean squares of RMSEs) with 95% bootstrap intervals over
// runs. ANEES is the mean over runs and frames. Runs are paired where they were judged against the
// same sequence, in their order; a diverged run loses, and
// runs with poses of shares of the frames that differ by more than a tenth are no pair.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "eval/metrics/metrics.h"
#include "eval/output/metrics_json.h"

namespace slammot {

class Pool {
 public:
  // Runs of one name are of one estimator.
  void add(const std::string& name, const Sequence& sequence, const RunResult& run,
           const RunMetrics& metrics);

  // The entries `estimators` and `pairs` of compare.json (docs/formats.md).
  Json estimators() const;
  Json pairs() const;

 private:
  struct Run {
    std::string sequence;  // its SHA-256
    RunMetrics metrics;
    Json frames;                       // judged_frames()
    std::map<int, double> timestamps;  // of the frames judged
    double error = 0.0;                // by which it is compared: infinite where it diverged
  };

  static Json estimator_json(const std::string& name, const std::vector<Run>& runs);
  Json pair_json(const std::string& a, const std::string& b) const;

  std::vector<std::string> names_;  // in their order
  std::map<std::string, std::vector<Run>> runs_;
  std::string key_;  // of the metric that is compared
};

}  // namespace slammot
