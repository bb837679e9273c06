#include "eval/run/evaluate.h"

#include <limits>

#include "datasets/readers/reader.h"
#include "eval/metrics/label_truth.h"
#include "eval/output/run_files.h"
#include "eval/output/run_reader.h"

namespace slammot {
namespace {

// The sequence judged against decides what is true, not the file of the run.
void take_truth_from(const Sequence& sequence, RunResult& run) {
  const std::vector<PosePair> pairs = pair_with_truth(sequence, run.filtered);
  const int last = pairs.empty() ? std::numeric_limits<int>::max() : pairs.back().frame;
  const std::map<int, Label> truths = labels_when_last_measured(sequence, last);
  for (ClassificationRecord& record : run.classification) {
    const auto truth = truths.find(record.track);
    record.truth.reset();
    if (truth != truths.end()) record.truth = truth->second;
  }
}

}  // namespace

NamedMetrics evaluate_run(const std::filesystem::path& folder,
                          const std::optional<std::filesystem::path>& against) {
  StoredRun stored = read_run(folder);
  const std::optional<std::filesystem::path> path = against ? against : stored.sequence;
  if (!path) {
    throw InputError(folder / run_files::kDescription, 0,
                     "names no sequence: give one with --against");
  }
  const Sequence sequence = read_sequence(*path);
  take_truth_from(sequence, stored.run);
  std::string label = folder.filename().string();
  if (label.empty()) label = folder.parent_path().filename().string();  // a trailing slash
  return {label, stored.estimator.empty() ? label : stored.estimator, stored.landmark,
          compute_metrics(sequence, stored.run, stored.gate_probability)};
}

}  // namespace slammot
