// Where a command may write: into a folder that is new or empty, or in place of what this program
// wrote there before. Nothing else is ever replaced, and no input.
#pragma once

#include <filesystem>
#include <string_view>

namespace slammot {

// A folder of this kind is known by how its mark, the first file written there, begins.
struct OutputKind {
  std::string_view name;
  std::string_view mark;
  std::string_view begins;
};

inline constexpr OutputKind kSequenceOutput{"a sequence", "sequence.yaml", "# written by slammot"};
// Beside a sequence, in the same folder: how it was tracked, or rendered.
inline constexpr OutputKind kTrackingOutput{"a description of tracking", "track.yaml",
                                            "version: \""};
inline constexpr OutputKind kRoomOutput{"a rendered room", "room.yaml", "format: slammot-room-1"};
inline constexpr OutputKind kRunOutput{"a run", "run.yaml", "format: slammot-run-1"};
inline constexpr OutputKind kComparisonOutput{"a comparison", "compare.json",
                                              "{\n \"format\": \"slammot-compare-1\""};
inline constexpr OutputKind kStudyOutput{
    "a study", "study.yaml", "# Copied by slammot: what it made of it stands beside it.\n"};
inline constexpr OutputKind kPicturesOutput{"pictures", "pictures.yaml",
                                            "format: slammot-pictures-1"};

// How the names begin of what this program puts into a folder for a while, or to lock it: no
// output.
inline constexpr std::string_view kHidden = ".slammot-";

// Throws std::invalid_argument if `folder` may not be written to. `replace` allows an earlier
// output of this kind to be replaced. `input` is never replaced.
void require_output(const std::filesystem::path& folder, const OutputKind& kind, bool replace,
                    const std::filesystem::path& input = {});

// Throws std::invalid_argument if a file with the mark's name is there and somebody else's.
void require_own_mark(const std::filesystem::path& folder, const OutputKind& kind);

// Whether the mark is there.
bool is_own(const std::filesystem::path& folder, const OutputKind& kind);

// Whether nothing is in the folder, or only what a killed program left; true if there is none.
bool is_vacant(const std::filesystem::path& folder);

}  // namespace slammot
