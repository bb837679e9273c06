#include "datasets/readers/foreign_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "datasets/sequence/plausible.h"

namespace slammot {

Sequence foreign_sequence(const std::filesystem::path& folder) {
  Sequence sequence;
  sequence.folder = folder;
  // Of `a/b/` and `.` too.
  sequence.name =
      std::filesystem::absolute(folder / "x").lexically_normal().parent_path().filename().string();
  sequence.camera.width = sequence.camera.height = 0;
  return sequence;
}

void add_image(const TextTable& table, double timestamp, std::string image, Sequence& sequence) {
  table.refuse_if(sequence.frames.empty()
                      ? time_fault(timestamp)
                      : step_fault(sequence.frames.back().timestamp, timestamp));
  sequence.frames.push_back({static_cast<int>(sequence.frames.size()), timestamp, {}, {}});
  sequence.images.push_back(std::move(image));
}

void require_frames(const std::filesystem::path& file, const Sequence& sequence) {
  if (sequence.frames.empty()) throw InputError(file, 0, "names no image");
}

void add_camera(const std::filesystem::path& file, int line, const MountedCamera& camera,
                std::vector<std::string> images, Sequence& sequence) {
  constexpr double kLeastBaseline = 1e-4;  // [m], as of the native format
  if (!(camera.t.norm() >= kLeastBaseline)) {
    throw InputError(file, line, "the camera stands where the first does: they measure no depth");
  }
  sequence.other_cameras.push_back(camera);
  sequence.other_images.push_back(std::move(images));
}

std::vector<std::string> nearest_images(const std::filesystem::path& file, const Sequence& listed,
                                        const std::vector<Frame>& frames, double apart) {
  std::vector<std::string> images;
  size_t found = 0, i = 0;
  const auto gap = [&](size_t k, const Frame& frame) {
    return std::abs(listed.frames[k].timestamp - frame.timestamp);
  };
  for (const Frame& frame : frames) {
    while (i + 1 < listed.frames.size() && gap(i + 1, frame) <= gap(i, frame)) ++i;
    const bool is_near = gap(i, frame) <= apart;
    images.push_back(is_near ? listed.images[i] : "");
    if (is_near) ++found;
  }
  if (found > 0) return images;
  throw InputError(file, 0,
                   fmt::format("no image within {} ms of one of the first camera's; --one-camera "
                               "does without",
                               1e3 * apart));
}

std::string image_ending(const std::filesystem::path& folder, const std::string& stem) {
  constexpr const char* kEndings[] = {".png", ".jpg", ".jpeg", ".pgm", ".tif", ".bmp"};
  for (const char* ending : kEndings) {
    if (std::filesystem::exists(folder / (stem + ending))) return ending;
  }
  std::error_code none;  // no such folder has no such image
  std::set<std::string> there;
  for (const auto& file : std::filesystem::directory_iterator(folder, none)) {
    if (file.path().stem().string().size() == stem.size()) there.insert(file.path().extension());
  }
  for (const char* ending : kEndings) {
    if (there.contains(ending)) return ending;
  }
  return ".png";
}

}  // namespace slammot
