#include "eval/report/report_generator.h"

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

// Without a shell, so that no character of a path means anything.
bool run_program(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ) != 0) {
    return false;
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
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

std::optional<Path> write_report(const char* generator, const Path& output) {
  const std::optional<Path> share = share_folder();
  if (!share) return std::nullopt;
  const Path report = output / "report.html";
  if (!run_program({python_interpreter(), (*share / generator).string(), output.string()})) {
    return std::nullopt;
  }
  return std::filesystem::exists(report) ? std::optional(report) : std::nullopt;
}

}  // namespace

std::optional<Path> write_compare_report(const Path& output) {
  return write_report(kCompare, output);
}

std::optional<Path> write_study_report(const Path& output) { return write_report(kStudy, output); }

}  // namespace slammot
