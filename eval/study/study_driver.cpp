#include "eval/study/study_driver.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>

namespace slammot {

int run_study(const Study& study, const StudyOptions& options) {
  Journal journal(options.output, options.shard.journal(), identity_of(study));
  const std::set<RunKey> finished =
      finished_runs(study, options.output, options.mix);  // of nobody else from now on
  const int cells = static_cast<int>(study.cells.size());
  // All cells of one seed first, so that what an interrupted study leaves is paired.
  std::vector<int> tasks;
  int of_shard = 0;
  for (int task = 0, all = study.tasks(); task < all; ++task) {
    if (!study.has_task(task) || !options.shard.has(task)) continue;
    ++of_shard;
    if (finished.count({task % cells, study.seed(task / cells)}) == 0) tasks.push_back(task);
  }
  std::mutex mutex;
  const int count = static_cast<int>(tasks.size());
  int done = of_shard - count;
  const auto one = [&](int i) {
    const int task = tasks[static_cast<std::size_t>(i)];
    const StudyRun run = run_study_cell(study, task % cells, task / cells);
    journal.append(run.result, run.timing);
    const std::lock_guard lock(mutex);
    ++done;
    if (options.progress) options.progress(done, of_shard);
  };
  // One run is one task, taken in order by whichever thread is free.
  std::atomic<int> next = 0;
  tbb::task_arena arena(options.jobs);
  arena.execute([&] {
    tbb::parallel_for(0, options.jobs, [&](int) {
      for (int i = next++; i < count; i = next++) one(i);
    });
  });
  return count;
}

}  // namespace slammot
