#include "datasets/readers/foreign_images.h"

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
