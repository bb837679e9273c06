#include "apps/support/writable.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "datasets/output/output_folder.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const char* reason) {
  throw std::invalid_argument(path.string() + ": cannot be written: " + reason);
}

// In the folder, or in the nearest one of its path that is there. The name is nobody else's:
// another process that begins at the same time may be making the same folder.
int probe(const fs::path& folder) {
  fs::path there = fs::absolute(folder).lexically_normal();
  while (there.has_relative_path() && !fs::exists(there)) there = there.parent_path();
  std::string name = (there / (std::string(kHidden) + "XXXXXX")).string();
  return ::mkdtemp(name.data()) != nullptr && ::rmdir(name.c_str()) == 0 ? 0 : errno;
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
