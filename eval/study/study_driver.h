// Runs a study, or a shard of it, on several threads.
#pragma once

#include <functional>

#include "eval/run/run.h"
#include "eval/study/study_store.h"

namespace slammot {

struct StudyProgress {
  int runs_done = 0, runs = 0;
  int frames_done = 0, frames = 0;  // of the runs under way
  double parts_done = 0.0;          // of them, in runs
};

struct StudyOptions {
  std::filesystem::path output;
  Shard shard;
  int jobs = 1;
  bool mix = false;              // see JournalRules
  CheckRotation check_rotation;  // of every run; may be empty
  // After each frame and each run, under a lock; may be empty.
  std::function<void(const StudyProgress&)> progress;
};

struct StudyCount {
  int ran = 0, kept = 0;  // runs that were done, and that the folder held
};

// Runs what the folder does not hold yet. The results depend
// neither on the jobs nor on the shards. claim_folder() beforehand, merge_runs() when all shards
// are done.
StudyCount run_study(const Study& study, const StudyOptions& options);

}  // namespace slammot
