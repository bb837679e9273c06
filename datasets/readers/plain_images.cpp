#include "datasets/readers/plain_images.h"

#include <strings.h>

#include <algorithm>
#include <cstring>

#include "datasets/readers/foreign_images.h"

namespace slammot {
namespace {

// What starts with a dot is some file manager's.
bool is_image(const std::filesystem::path& file) {
  constexpr const char* kEndings[] = {".png", ".jpg",  ".jpeg", ".pgm", ".ppm",
                                      ".tif", ".tiff", ".bmp",  ".webp"};
  const std::string ending = file.extension().string();
  return !file.filename().string().starts_with('.') &&
         std::ranges::any_of(
             kEndings, [&](const char* known) { return strcasecmp(known, ending.c_str()) == 0; });
}

std::vector<std::string> images_of(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code fault;
  const std::filesystem::directory_iterator files(folder, fault);
  if (fault) throw InputError(folder, 0, "cannot be read: " + fault.message());
  for (const auto& entry : files) {
    if (is_image(entry.path())) names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names, [](const std::string& a, const std::string& b) {
    return strverscmp(a.c_str(), b.c_str()) < 0;
  });
  return names;
}

// Of `left_0012_rect.png` 12; nothing without a number, or with one that is none.
std::optional<long long> last_number(const std::string& name) {
  constexpr std::string_view kDigits = "0123456789";
  const std::string stem = std::filesystem::path(name).stem().string();
  const size_t last = stem.find_last_of(kDigits);
  if (last == std::string::npos) return std::nullopt;
  const size_t before = stem.find_last_not_of(kDigits, last);
  const size_t first = before == std::string::npos ? 0 : before + 1;
  return parse_number<long long>(std::string_view(stem).substr(first, last - first + 1));
}

}  // namespace

bool has_plain_images(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator files(folder);
  return std::ranges::any_of(begin(files), end(files),
                             [](const auto& entry) { return is_image(entry.path()); });
}

Sequence read_plain_images(const std::filesystem::path& folder, double rate) {
  Sequence sequence = foreign_sequence(folder);
  sequence.images = images_of(folder);
  for (size_t i = 0; i < sequence.images.size(); ++i) {
    sequence.frames.push_back({static_cast<int>(i), static_cast<double>(i) / rate, {}, {}});
  }
  require_frames(folder, sequence);
  return sequence;
}

std::optional<std::string> numbering_fault(const std::vector<std::string>& images) {
  std::optional<long long> step;
  for (size_t i = 1; i < images.size(); ++i) {
    const auto before = last_number(images[i - 1]), number = last_number(images[i]);
    if (!before || !number) return std::nullopt;
    if (step.value_or(*number - *before) != *number - *before) {
      return fmt::format(
          "{} follows {}, but the numbers before go up by {}: where images are "
          "missing the times are wrong",
          images[i], images[i - 1], *step);
    }
    step = *number - *before;
  }
  return std::nullopt;
}

}  // namespace slammot
