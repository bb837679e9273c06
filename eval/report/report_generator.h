// Calls the report generator, a Python program that comes with the project.
#pragma once

#include <filesystem>
#include <optional>

namespace slammot {

// The folder that holds `report/`: the environment variable SLAMMOT_SHARE, else ../share/slammot
// beside the program, else the source folder this was built from. Nothing if there is none.
std::optional<std::filesystem::path> share_folder();

// Make the page of a comparison's folder, from compare.json, or of a study's, from summary.json
// with figures and tables beside it. The exit code: 0 done, 2 bad input, 1 anything else; stderr
// says why.
int make_compare_page(const std::filesystem::path& output);
int make_study_page(const std::filesystem::path& output);

// A frame's PDF beside its JSON (apps/pictures/frame_json.h); the exit code likewise.
int make_frame_figure(const std::filesystem::path& data);

// `output`/report.html.
std::filesystem::path page_of(const std::filesystem::path& output);

}  // namespace slammot
