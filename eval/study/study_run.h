// One run of a study, and what is kept of it.
#pragma once

#include <nlohmann/json.hpp>

#include "eval/run/run.h"
#include "eval/study/study.h"

namespace slammot {

// Ages, in measurements, at which the errors of landmarks are recorded.
inline constexpr int kRecordedAges[] = {1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 50, 75, 100};

// What one run leaves. `result` depends on the study, the cell and the seed alone; `timing` on the
// machine and the clock. docs/formats.md gives the fields.
struct StudyRun {
  nlohmann::ordered_json result;
  nlohmann::ordered_json timing;
};

// Never throws for what the estimator does: a run that fails is recorded as diverged, with the
// reason. Throws InputError or std::invalid_argument for a sequence or a configuration with which
// nothing can run, or a recording that has changed since the study was read.
StudyRun run_study_cell(const Study& study, int cell, int run, DriveOptions options);

}  // namespace slammot
