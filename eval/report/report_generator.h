// Calls the report generator, a Python program that comes with the project.
#pragma once

#include <filesystem>
#include <optional>

namespace slammot {

// The folder that holds `report/`: the environment variable SLAMMOT_SHARE, else ../share/slammot
// beside the program, else the source folder this was built from. Nothing if there is none.
std::optional<std::filesystem::path> share_folder();

// Make `output`/report.html of a comparison's or a study's folder. The exit code: 0 done, 2 bad
// input, which the generator has named on stderr, 1 anything else.
int make_compare_page(const std::filesystem::path& output);
int make_study_page(const std::filesystem::path& output);

// Writes `output`/report.html from `output`/compare.json. Returns its path, or nothing if the
// generator is missing or failed (it says why on stderr).
std::optional<std::filesystem::path> write_compare_report(const std::filesystem::path& output);

// The same from a study's summary.json; figures and tables go to `output`/figures and
// `output`/tables.
std::optional<std::filesystem::path> write_study_report(const std::filesystem::path& output);

}  // namespace slammot
