// The runs of a study on disk: a journal to which each finished run is appended at once, and the
// sorted files made of it.
//
//   journal-I-of-N.jsonl  a line {"result": .., "timing": ..} per finished run, in order of
//   finishing results.jsonl         the results by cell and seed: the same bytes however they were
//   computed timing.jsonl          what depends on the machine and the clock, in the same order
//   study.yaml            the study's file as it was
//
// Journals stay: with them a study can be resumed, or be given more runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <set>
#include <utility>

#include "eval/study/study_run.h"

namespace slammot {

struct Shard {
  int index = 1;  // 1 .. count
  int count = 1;

  // Scattered, so that no shard gets all the runs of one slow estimator.
  bool has(int task) const {
    return scattered(task) % static_cast<std::uint64_t>(count) ==
           static_cast<std::uint64_t>(index - 1);
  }
  std::string journal() const;  // the file's name

 private:
  static std::uint64_t scattered(int task);
};

using RunKey = std::pair<int, std::uint64_t>;  // cell, seed

// The runs in the journals of this folder. A line that was being written when the program was
// killed is no run. Throws InputError for a line that is none.
std::set<RunKey> finished_runs(const std::filesystem::path& folder);

// Appends, one whole line at a time, from any thread.
class Journal {
 public:
  // Cuts off a line that was left half written. Throws std::runtime_error if it cannot be written.
  Journal(const std::filesystem::path& folder, const Shard& shard);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  void append(const StudyRun& run);

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::mutex mutex_;
};

// Writes results.jsonl and timing.jsonl into `output` from the journals of all `folders`. Throws
// std::invalid_argument when runs are missing, naming one.
void merge_runs(const Study& study, const std::vector<std::filesystem::path>& folders,
                const std::filesystem::path& output);

// Marks the folder as this study's. Throws std::invalid_argument when it is another's, or when it
// has runs of this shard and `resume` is false.
void claim_folder(const Study& study, const std::filesystem::path& folder, const Shard& shard,
                  bool resume);

}  // namespace slammot
