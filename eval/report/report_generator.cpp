#include "eval/report/report_generator.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "eval/python/interpreter.h"

extern char** environ;

namespace slammot {
namespace {

using Path = std::filesystem::path;

constexpr char kCompare[] = "report/compare_report.py";
constexpr char kStudy[] = "report/study_report.py";
constexpr char kFrame[] = "report/frame_figure.py";

constexpr int kDone = 0, kFailed = 1, kBadInput = 2;

// Its exit code. Without a shell, so that no character of a path means anything.
int run_program(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ) != 0) {
    return kFailed;
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) return kFailed;
  return WEXITSTATUS(status);
}

}  // namespace

std::optional<Path> share_folder() {
  std::vector<Path> candidates;
  if (const char* stated = std::getenv("SLAMMOT_SHARE")) candidates.emplace_back(stated);
  std::error_code ignored;
  const Path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  if (!program.empty()) candidates.push_back(program.parent_path() / ".." / "share" / "slammot");
  candidates.emplace_back(SLAMMOT_SOURCE_SHARE);
  for (const Path& candidate : candidates) {
    if (std::filesystem::exists(candidate / kCompare, ignored)) return candidate;
  }
  return std::nullopt;
}

namespace {

// Of a folder or a file it makes `product`.
int make(const char* generator, const Path& source, const Path& product) {
  const std::optional<Path> share = share_folder();
  if (!share) {
    fmt::print(stderr,
               "slammot: the report generator is missing: SLAMMOT_SHARE names its folder\n");
    return kFailed;
  }
  const int code =
      run_program({python_interpreter(), (*share / generator).string(), source.string()});
  if (code == kDone) return std::filesystem::exists(product) ? kDone : kFailed;
  return code == kBadInput ? kBadInput : kFailed;
}

}  // namespace

Path page_of(const Path& output) { return output / "report.html"; }

int make_compare_page(const Path& output) { return make(kCompare, output, page_of(output)); }

int make_study_page(const Path& output) { return make(kStudy, output, page_of(output)); }

int make_frame_figure(const Path& data) {
  return make(kFrame, data, Path(data).replace_extension(".pdf"));
}

}  // namespace slammot
