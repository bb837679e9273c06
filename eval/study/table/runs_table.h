// runs.csv of a study's folder: a row per run, for pandas, R and spreadsheets. Made of
// results.jsonl and timing.jsonl, in their order.
#pragma once

#include <filesystem>

#include "eval/study/study.h"

namespace slammot {

// Throws InputError where the folder's results are not those of this study.
void write_runs_table(const Study& study, const std::filesystem::path& folder);

}  // namespace slammot
