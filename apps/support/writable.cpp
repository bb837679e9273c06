#include "apps/support/writable.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace slammot {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const char* reason) {
  throw std::invalid_argument(path.string() + ": cannot be written: " + reason);
}

// The probe is a file in the folder, or the first missing folder of its path.
int probe(const fs::path& folder) {
  fs::path missing = fs::absolute(folder).lexically_normal();
  if (fs::is_directory(missing)) {
    std::string file = (missing / ".slammot-XXXXXX").string();
    const int descriptor = ::mkstemp(file.data());
    if (descriptor < 0) return errno;
    ::close(descriptor);
    return ::unlink(file.c_str()) == 0 ? 0 : errno;
  }
  while (missing.has_relative_path() && !fs::exists(missing.parent_path())) {
    missing = missing.parent_path();
  }
  if (!missing.has_filename()) missing = missing.parent_path();  // a slash at the end
  return ::mkdir(missing.c_str(), 0777) == 0 && ::rmdir(missing.c_str()) == 0 ? 0 : errno;
}

}  // namespace

void require_writable_folder(const fs::path& folder) {
  if (const int error = probe(folder)) refuse(folder, std::strerror(error));
}

void require_writable_file(const fs::path& file) {
  if (fs::is_directory(file)) refuse(file, "a folder");
  if (fs::exists(file) && !fs::is_regular_file(file)) return;  // a device or a pipe
  const fs::path folder = fs::absolute(file).parent_path();
  if (const int error = probe(folder)) refuse(file, std::strerror(error));
}

}  // namespace slammot
