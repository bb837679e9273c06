// The runs of a study on disk: journals to which each finished run is appended at once
// (eval/journal/journal.h), and the sorted files made of them.
//
//   journal-I-of-N.jsonl  the finished runs of shard I
//   results.jsonl         the results by cell and seed: the same bytes however they were computed
//   timing.jsonl          what depends on the machine and the clock, in the same order
//   study.yaml            the mark of the folder, and the study's file as it was
//
// Journals stay: with them a study can be resumed, or be given more runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>

#include "eval/journal/journal.h"
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

// Runs of another identity are not of this study.
JournalIdentity identity_of(const Study& study);

// The runs in the journals of this folder. Throws InputError for a line that is none of this study,
// or, unless `mix`, of another build of the program or of a recording that has changed.
std::set<RunKey> finished_runs(const Study& study, const std::filesystem::path& folder, bool mix);

// Writes results.jsonl and timing.jsonl into `output` from the journals of all `folders`. Throws
// std::invalid_argument when runs are missing, naming one.
void merge_runs(const Study& study, const std::vector<std::filesystem::path>& folders,
                const std::filesystem::path& output, bool mix);

// Marks the folder as this study's. Throws std::invalid_argument when it is another's, when it has
// other files, or when it has runs of this shard and `resume` is false.
void claim_folder(const Study& study, const std::filesystem::path& folder, const Shard& shard,
                  bool resume);

}  // namespace slammot
