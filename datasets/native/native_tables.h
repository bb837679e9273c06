// The CSV files of the native folder, from their text.
#pragma once

#include "datasets/sequence/sequence.h"
#include "datasets/sequence/true_poses.h"

namespace slammot {

// frames.csv: fills frames (without observations) and images.
void read_frames(const std::filesystem::path& file, std::string_view text, Sequence& sequence);

// other_images.csv, in any order: fills other_images.
void read_other_images(const std::filesystem::path& file, std::string_view text,
                       Sequence& sequence);

// observations.csv, in any order: fills the observations of the frames.
void read_observations(const std::filesystem::path& file, std::string_view text, const Rig& rig,
                       std::vector<Frame>& frames);

// groundtruth.tum.
std::vector<TimedPose> read_poses(const std::filesystem::path& file, std::string_view text);

// landmarks.csv, of a sequence with this many frames.
std::map<int, TrueLandmark> read_landmarks(const std::filesystem::path& file, std::string_view text,
                                           size_t frames);

// known.csv.
std::vector<KnownLandmark> read_known(const std::filesystem::path& file, std::string_view text);

// priors.csv: probabilities of rest, by track.
std::map<int, double> read_priors(const std::filesystem::path& file, std::string_view text);

}  // namespace slammot
