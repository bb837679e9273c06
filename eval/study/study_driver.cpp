#include "eval/study/study_driver.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <map>
#include <mutex>
#include <system_error>

namespace slammot {
namespace {

// What all threads have done, told to one listener.
class SharedProgress {
 public:
  SharedProgress(const StudyOptions& options, int runs_done, int runs)
      : tell_(options.progress), runs_done_(runs_done), runs_(runs) {}

  void frame(int task, int done, int total) {
    if (!tell_) return;
    const std::lock_guard lock(mutex_);
    under_way_[task] = {done, total};
    tell();
  }
  void run(int task) {
    if (!tell_) return;
    const std::lock_guard lock(mutex_);
    under_way_.erase(task);
    ++runs_done_;
    tell();
  }

 private:
  struct Frames {
    int done, total;
  };

  void tell() const {
    StudyProgress progress{runs_done_, runs_};
    for (const auto& [task, frames] : under_way_) {
      progress.frames_done += frames.done;
      progress.frames += frames.total;
      progress.parts_done += static_cast<double>(frames.done) / frames.total;
    }
    tell_(progress);
  }

  const std::function<void(const StudyProgress&)>& tell_;
  std::mutex mutex_;
  std::map<int, Frames> under_way_;  // by task
  int runs_done_, runs_;
};

}  // namespace

StudyCount run_study(const Study& study, const StudyOptions& options) {
  Journal journal(options.output, options.shard.journal(), identity_of(study));
  const std::set<RunKey> finished =
      finished_runs(study, options.output, options.mix);  // of nobody else from now on
  const int cells = static_cast<int>(study.cells.size());
  // All cells of one seed first, so that what an interrupted study leaves is paired.
  std::vector<int> tasks;
  int of_shard = 0;
  for (int task = 0, all = study.tasks(); task < all; ++task) {
    if (!study.computes(task) || !options.shard.has(task)) continue;
    ++of_shard;
    if (finished.count({task % cells, study.seed(task / cells)}) == 0) tasks.push_back(task);
  }
  const int count = static_cast<int>(tasks.size());
  SharedProgress progress(options, of_shard - count, of_shard);
  const auto one = [&](int i) {
    const int task = tasks[static_cast<std::size_t>(i)];
    const StudyRun run =
        run_study_cell(study, task % cells, task / cells,
                       {.progress = [&](int done, int total) { progress.frame(task, done, total); },
                        .check_rotation = options.check_rotation});
    journal.append(run.result, run.timing);
    progress.run(task);
  };
  // One run is one task, taken in order by whichever thread is free. After an error nobody begins.
  std::atomic<int> next = 0;
  const auto work = [&] {
    try {
      for (int i = next++; i < count; i = next++) one(i);
    } catch (...) {
      next = count;
      throw;
    }
  };
  std::vector<std::future<void>> workers;
  const int jobs = std::min(std::max(options.jobs, 1), count);
  try {
    while (std::ssize(workers) < jobs) {
      workers.push_back(std::async(std::launch::async, work));
    }
  } catch (const std::system_error&) {
    if (workers.empty()) work();  // fewer threads than asked for do the same
  }
  for (std::future<void>& worker : workers) worker.get();
  return {count, of_shard - count};
}

}  // namespace slammot
