// Writes a sequence as a native folder: what read_native() reads back is equal bit for bit, but for
// the velocities of the truth, for which the format has no place.
#pragma once

#include "datasets/output/output_files.h"
#include "datasets/sequence/sequence.h"

namespace slammot {

enum class NativeParts { kAll, kWithoutObservations };

// Throws std::invalid_argument for a file of a sequence in the folder that this program did not
// write there: its names stand in the first line of sequence.yaml.
void require_own_files(const std::filesystem::path& folder);

// Makes the folder if need be and replaces the files of a sequence in it, all or none; optional
// files that this sequence does not have are removed: ask require_output() first. Frames are
// numbered 0, 1, 2...; throws std::invalid_argument if they are not, for what the reader would
// refuse, or as require_own_files(), and std::runtime_error if a file cannot be written.
void write_native(const Sequence& sequence, const std::filesystem::path& folder,
                  NativeParts parts = NativeParts::kAll);

// The same, with more files beside them, when `files` are put in place. track.yaml and room.yaml of
// an earlier sequence are left out.
void add_native(const Sequence& sequence, const std::filesystem::path& folder, NativeParts parts,
                OutputFiles& files);

}  // namespace slammot
