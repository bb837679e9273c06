#include "datasets/output/output_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "datasets/output/output_files.h"
#include "datasets/text/printable.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& folder, const std::string& reason) {
  throw std::invalid_argument(fmt::format("{}: {}", folder.string(), reason));
}

}  // namespace

bool is_own(const fs::path& folder, const OutputKind& kind) {
  const fs::path mark = folder / kind.mark;
  if (!fs::is_regular_file(mark)) return false;
  std::string beginning(kind.begins.size(), '\0');
  std::ifstream(mark, std::ios::binary).read(beginning.data(), std::ssize(beginning));
  return beginning == kind.begins;
}

void require_own_mark(const fs::path& folder, const OutputKind& kind) {
  if (!fs::exists(folder / kind.mark) || is_own(folder, kind)) return;
  refuse(folder / kind.mark, "was not written by this program, and is not replaced");
}

bool is_vacant(const fs::path& folder) {
  if (!fs::exists(folder)) return true;
  const fs::directory_iterator entries(folder);
  return std::all_of(begin(entries), end(entries), [](const auto& entry) {
    return is_unfinished(entry.path()) || entry.path().filename().string().starts_with(kHidden);
  });
}

void require_output(const fs::path& folder, const OutputKind& kind, bool replace,
                    const fs::path& input) try {
  if (invalid_utf8(fs::absolute(folder).string()) != std::string::npos) {
    refuse(folder, "its path is not UTF-8");
  }
  if (!fs::exists(folder)) return;
  if (!fs::is_directory(folder)) refuse(folder, "is not a folder");
  if (!input.empty() && fs::exists(input) && fs::equivalent(folder, input)) {
    refuse(folder, "is what is read, which the output would replace");
  }
  if (is_vacant(folder)) return;
  if (!is_own(folder, kind)) {
    refuse(folder, fmt::format("holds files that are not {} of this program: they are not replaced",
                               kind.name));
  }
  if (!replace) refuse(folder, fmt::format("holds {} already: --force replaces it", kind.name));
} catch (const fs::filesystem_error& error) {
  refuse(folder, error.code().message());
}

}  // namespace slammot
