#include "eval/python/interpreter.h"

#include <unistd.h>

#include <cstdlib>

namespace slammot {
namespace {

using Path = std::filesystem::path;

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

std::string python_interpreter() {
  const std::string stated = variable("SLAMMOT_PYTHON");
  return stated.empty() ? "/usr/bin/python3" : stated;
}

std::filesystem::path python_package_folder() {
  std::error_code ignored;
  const Path program = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  // $SLAMMOT_SHARE is PREFIX/share/slammot.
  const Path prefix = Path(variable("SLAMMOT_SHARE")) / ".." / "..";
  for (const Path& folder : {program / "python", program / ".." / SLAMMOT_PYTHON_DIR,
                             prefix / SLAMMOT_PYTHON_DIR, Path(SLAMMOT_SOURCE_PYTHON)}) {
    if (std::filesystem::exists(folder / "slammot" / "worker.py", ignored)) return folder;
  }
  return {};
}

std::vector<std::string> python_environment() {
  const std::string path = variable("PYTHONPATH");
  const std::string own = "PYTHONPATH=" + python_package_folder().string();
  std::vector<std::string> environment = {path.empty() ? own : own + ":" + path,
                                          "OPENBLAS_NUM_THREADS=1", "PYTHONDONTWRITEBYTECODE=1"};
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (!text.starts_with("PYTHONPATH=") && !text.starts_with("OPENBLAS_NUM_THREADS=")) {
      environment.push_back(text);
    }
  }
  return environment;
}

}  // namespace slammot
