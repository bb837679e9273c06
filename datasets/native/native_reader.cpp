#include "datasets/native/native_reader.h"

#include "datasets/native/native_format.h"
#include "datasets/native/native_settings.h"
#include "datasets/native/native_tables.h"
#include "datasets/output/output_files.h"
#include "datasets/sequence/sequence_hints.h"
#include "datasets/sequence/sha256.h"
#include "datasets/text/text_table.h"

namespace slammot {
namespace {

struct Source {
  std::filesystem::path file;
  std::string text;
};

// Reads the folder's files and keeps the hash of what was read.
class Folder {
 public:
  explicit Folder(std::filesystem::path path) : path_(std::move(path)) {
    if (!std::filesystem::is_directory(path_)) throw InputError(path_, 0, "no such folder");
  }

  Source required(std::string_view name) {
    Source source{path_ / name, read_text_file(path_ / name)};
    hash_.add(source.text);
    return source;
  }
  std::optional<Source> optional(std::string_view name) {
    if (!is_there(path_ / name)) return std::nullopt;
    return required(name);
  }
  std::string sha256() const { return hash_.hex(); }

 private:
  std::filesystem::path path_;
  Sha256 hash_;
};

Sequence settings_and_frames(Folder& folder, const std::filesystem::path& path) {
  Sequence sequence;
  sequence.folder = path;
  const Source settings = folder.required(native::kSettings);
  read_settings(settings.file, settings.text, sequence);
  const Source frames = folder.required(native::kFrames);
  read_frames(frames.file, frames.text, sequence);
  return sequence;
}

void read_others(Folder& folder, Sequence& sequence) {
  const auto images = folder.optional(native::kOtherImages);
  if (images) read_other_images(images->file, images->text, sequence);
}

Source observations_of(Folder& folder, const Sequence& sequence) {
  if (auto source = folder.optional(native::kObservations)) return std::move(*source);
  const std::string reason =
      sequence.images.empty() ? "no such file" : "no such file; the images must be tracked first";
  throw InputError(sequence.folder / native::kObservations, 0, reason);
}

void read_true_poses(Folder& folder, Sequence& sequence) {
  const auto source = folder.optional(native::kGroundTruth);
  if (!source) return;
  const std::vector<TimedPose> poses = read_poses(source->file, source->text);
  sequence.truth = true_cameras(poses, sequence.frames);
  sequence.hints = truth_hints(source->file, poses, sequence);
}

void read_truth(Folder& folder, Sequence& sequence) {
  read_true_poses(folder, sequence);
  const auto landmarks = folder.optional(native::kLandmarks);
  if (landmarks) {
    sequence.landmarks = read_landmarks(landmarks->file, landmarks->text, sequence.frames.size());
  }
  sequence.exact_truth =
      !sequence.truth.empty() && landmarks;  // only simulation knows every landmark
}

void read_first_camera(Folder& folder, Sequence& sequence) {
  if (const auto initial = folder.optional(native::kInitial)) {
    sequence.initial = read_initial(initial->file, initial->text);
  }
}

}  // namespace

Sequence read_native(const std::filesystem::path& path) {
  require_whole(path);
  Folder folder(path);
  Sequence sequence = settings_and_frames(folder, path);
  read_others(folder, sequence);
  const Source observations = observations_of(folder, sequence);
  read_observations(observations.file, observations.text, {sequence.camera, sequence.other_cameras},
                    sequence.frames);
  read_truth(folder, sequence);
  if (const auto known = folder.optional(native::kKnown)) {
    sequence.known = read_known(known->file, known->text);
  }
  if (const auto priors = folder.optional(native::kPriors)) {
    sequence.p_static = read_priors(priors->file, priors->text);
  }
  read_first_camera(folder, sequence);
  for (std::string& hint : frame_hints(sequence)) sequence.hints.push_back(std::move(hint));
  if (auto hint = prior_hint(sequence)) sequence.hints.push_back(std::move(*hint));
  if (auto hint = leave_out_rayless(sequence)) sequence.hints.push_back(std::move(*hint));
  sequence.sha256 = folder.sha256();
  return sequence;
}

Sequence read_native_images(const std::filesystem::path& path) {
  require_whole(path);
  Folder folder(path);
  Sequence sequence = settings_and_frames(folder, path);
  if (sequence.images.empty()) {
    throw InputError(path / native::kFrames, 1, "there is no column 'image'");
  }
  read_true_poses(folder, sequence);
  read_first_camera(folder, sequence);
  return sequence;
}

void add_native_others(Sequence& sequence) {
  Folder folder(sequence.folder);
  read_others(folder, sequence);
}

bool is_native(const std::filesystem::path& folder) {
  return is_there(folder / native::kSettings) || is_there(folder / native::kFrames);
}

}  // namespace slammot
