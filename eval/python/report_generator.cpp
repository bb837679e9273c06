#include "eval/python/report_generator.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <string>
#include <vector>

#include "eval/python/interpreter.h"
#include "eval/python/spawn.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

constexpr int kDone = 0, kFailed = 1, kBadInput = 2;

// Its exit code.
int run_program(std::vector<std::string> words) {
  // Modules are looked for in the package alone, not in the folder where the user stands.
  std::vector<std::string> environment = python_environment();
  environment.emplace_back("PYTHONSAFEPATH=1");
  pid_t child = 0;
  if (spawn(std::move(words), std::move(environment), -1, child) != 0) return kFailed;
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) return kFailed;
  return WEXITSTATUS(status);
}

// What `python3 -m slammot.report NAME` makes of a folder or a file: `product`.
int make(const std::string& name, const Path& source, const Path& product,
         const std::vector<std::string>& options = {}) {
  if (python_package_folder().empty()) {
    fmt::print(stderr, "slammot: its Python package is missing: install slammot whole\n");
    return kFailed;
  }
  std::vector<std::string> words = {python_interpreter(), "-m", "slammot.report", name,
                                    source.string()};
  words.insert(words.end(), options.begin(), options.end());
  const int code = run_program(words);
  if (code == kDone) return std::filesystem::exists(product) ? kDone : kFailed;
  return code == kBadInput ? kBadInput : kFailed;
}

}  // namespace

Path page_of(const Path& output) { return output / "report.html"; }

Path timeline_of(const Path& run) { return run / "timeline.html"; }

int make_compare_page(const Path& output, bool table) {
  const std::vector<std::string> options(table ? 1 : 0, "--table");
  return make("compare", output, page_of(output), options);
}

int make_study_page(const Path& output, const RecordOptions& options) {
  if (options.record.empty()) return make("study", output, page_of(output));
  return make("study", output, page_of(output),
              {"--record", (options.record / options.name).string(), "--command", options.command});
}

int make_timeline_page(const Path& run, const Path& sequence) {
  if (sequence.empty()) return make("timeline", run, timeline_of(run));
  return make("timeline", run, timeline_of(run), {"--sequence", sequence.string()});
}

int make_frame_figure(const Path& data) {
  return make("frame", data, Path(data).replace_extension(".pdf"));
}

}  // namespace slammot
