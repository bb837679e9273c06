// The comparison page of runs that were made before, here or elsewhere.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/run/evaluate.h"

namespace slammot {

// Writes compare.json and, for each run, a folder in this program's formats: poses at the times of
// the frames, covariances in its error convention. Throws std::invalid_argument if a run would be
// written over, if two of an estimator have the same poses on the same sequence, or if only some
// of the sequences have exact truth.
void report_runs(const std::vector<JudgedRun>& runs, const std::filesystem::path& output,
                 const std::string& command);

}  // namespace slammot
