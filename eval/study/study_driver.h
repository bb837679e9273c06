// Runs a study, or a shard of it, on several threads.
#pragma once

#include <functional>

#include "eval/study/study_store.h"

namespace slammot {

struct StudyOptions {
  std::filesystem::path output;
  Shard shard;
  int jobs = 1;
  bool mix = false;                                   // see JournalRules
  std::function<void(int done, int total)> progress;  // called under a lock; may be empty
};

// Runs what the folder does not hold yet, and returns how many that were. The results depend
// neither on the jobs nor on the shards. claim_folder() beforehand, merge_runs() when all shards
// are done.
int run_study(const Study& study, const StudyOptions& options);

}  // namespace slammot
