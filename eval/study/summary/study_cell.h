// The runs of one cell, taken one by one, and what they say together: an entry of `cells` in
// summary.json.
#pragma once

#include <cstdint>

#include "eval/pooling/frame_statistics.h"
#include "eval/statistics/run_nees.h"
#include "eval/study/study.h"
#include "eval/study/summary/study_landmarks.h"

namespace slammot {

class CellSummary {
 public:
  CellSummary(const StudyCell& cell, const MetricTable& metrics) : cell_(cell), metrics_(metrics) {}

  void add(const nlohmann::ordered_json& run);            // a line of results.jsonl
  void add_timing(const nlohmann::ordered_json& timing);  // a line of timing.jsonl
  nlohmann::ordered_json json() const;

  // By seed, of the poses that are judged: position RMSE over the run (ATE Sim(3) where the truth
  // is measured), infinite of one that diverged; what it states of it; and the mean NEES of its
  // poses.
  const std::map<std::uint64_t, double>& position_rmse() const { return position_rmse_; }
  const std::map<std::uint64_t, double>& stated_sigma() const { return stated_sigma_; }
  const std::map<std::uint64_t, double>& pose_nees() const { return pose_nees_; }

 private:
  struct Scalar {
    Pooled pooled;
    std::vector<double> samples;
  };
  // A mechanism over the runs that state it.
  struct Acting {
    std::string key, because;
    int on = 0;
    long acted = 0;
  };
  void add_frames(std::uint64_t seed, const nlohmann::ordered_json& frames);
  nlohmann::ordered_json nees_by_run() const;
  void add_statements(std::uint64_t seed, const nlohmann::ordered_json& run);
  void add_counts(const nlohmann::ordered_json& run);
  void add_in_force(const nlohmann::ordered_json& mechanisms);
  nlohmann::ordered_json in_force() const;
  void add_values(Scope scope, const nlohmann::ordered_json& values, const std::string& prefix);

  const StudyCell& cell_;
  const MetricTable& metrics_;
  int runs_ = 0;
  bool aligned_ = false;  // the truth is measured: compared by the error after alignment
  nlohmann::ordered_json diverged_ = nlohmann::ordered_json::array();
  nlohmann::ordered_json failed_ = nlohmann::ordered_json::array();
  nlohmann::ordered_json warnings_ = nlohmann::ordered_json::array();  // of each run that warns
  std::map<std::uint64_t, double> position_rmse_, stated_sigma_, pose_nees_;
  std::map<std::uint64_t, std::pair<RunNees, nlohmann::ordered_json>> run_nees_;  // and its frame
  std::map<std::string, Scalar> scalars_;
  std::vector<std::pair<std::string, Acting>> in_force_;  // by name, in the order stated
  int stating_ = 0;                                       // runs that state what is in force
  FrameStatistics frames_;
  nlohmann::ordered_json axes_;  // of the first seed
  LandmarkAges ages_;
  RecordedTracks tracks_;
  std::map<std::string, std::array<long, 3>> counts_;  // right, wrong, undecided
  std::map<std::string, double> coverage_;
  std::map<std::string, std::vector<double>> timing_;
  std::map<std::string, double> stages_;
};

}  // namespace slammot
