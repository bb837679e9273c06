#include "frontend/codecs/codecs.h"

#include <dlfcn.h>

#include <stdexcept>

#include "datasets/output/output_files.h"

namespace slammot {
namespace {

[[noreturn]] void refuse() {
  throw std::runtime_error(std::string("images cannot be read or written: ") + dlerror());
}

// By its bare name: the program's run path leads to it, in the build tree as where it is installed.
// It stays loaded to the end, since what it made may live that long.
const Codecs* load() {
  void* const module = dlopen(SLAMMOT_CODECS_MODULE, RTLD_NOW | RTLD_LOCAL);
  if (!module) refuse();
  void* const entry = dlsym(module, kCodecsEntry);
  if (!entry) refuse();
  return reinterpret_cast<CodecsEntry*>(entry)();
}

}  // namespace

const Codecs& codecs() {
  static const Codecs* const loaded = load();
  return *loaded;
}

void write_image(const std::filesystem::path& file, const cv::Mat& image, int jpeg_quality) {
  const std::string bytes = codecs().encode(file.extension().string(), image, jpeg_quality);
  if (bytes.empty()) throw std::runtime_error(file.string() + ": cannot be encoded");
  write_file(file, bytes);
}

}  // namespace slammot
