// Calls the judge of many runs and its pages: the Python package slammot, which comes with the
// project.
#pragma once

#include <filesystem>

namespace slammot {

// Each returns the exit code: 0 done, 2 bad input, 1 anything else; stderr says why.

// The page of a comparison's folder and what its runs say together (pooled.json), from
// compare.json; with `table` that is printed too.
int make_compare_page(const std::filesystem::path& output, bool table = false);

// What the runs of a study say together (summary.json, runs.csv), from its plan.json and its runs;
// page, figures and tables. Where `record` is not empty, also table.md and summary.json in
// `record`/`name` (docs/reproducing.md).
struct RecordOptions {
  std::filesystem::path record;
  std::string name, command;
};
int make_study_page(const std::filesystem::path& output, const RecordOptions& options = {});

// A frame's PDF beside its JSON (apps/pictures/frame_json.h).
int make_frame_figure(const std::filesystem::path& data);

// `run`/timeline.html: the run over its sequence, or over `sequence` if that is not empty.
int make_timeline_page(const std::filesystem::path& run, const std::filesystem::path& sequence);

// `output`/report.html, `run`/timeline.html.
std::filesystem::path page_of(const std::filesystem::path& output);
std::filesystem::path timeline_of(const std::filesystem::path& run);

}  // namespace slammot
