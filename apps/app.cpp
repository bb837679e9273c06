#include "apps/app.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>

#include "apps/commands.h"
#include "apps/support/command_line.h"
#include "apps/support/commit.h"
#include "apps/support/five_point_row.h"
#include "apps/support/progress.h"
#include "apps/support/usage.h"
#include "datasets/sequence/sequence.h"
#include "datasets/text/printable.h"
#include "eval/provenance/provenance.h"
#include "eval/run/process.h"
#include "frontend/rendering/rendered_scenario.h"

namespace slammot::app {
namespace {

constexpr int kFailed = 1;
constexpr int kBadUsage = 2;

int complain(const std::string& reason, int exit_code) {
  std::fprintf(stderr, "slammot: %s\n", printable(reason).c_str());
  return exit_code;
}

// Arguments are written into results, which are UTF-8.
void require_utf8(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (invalid_utf8(argv[i]) == std::string::npos) continue;
    throw std::invalid_argument(std::string(argv[i]) + ": is not UTF-8");
  }
}

// What was said may still stand in a buffer, and be lost.
int said(int exit_code) {
  const bool lost = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
  return lost ? complain("standard output: cannot be written", kFailed) : exit_code;
}

int parse_and_run(CLI::App& app, int argc, char** argv, const int& exit_code) {
  try {
    require_utf8(argc, argv);
    app.parse(argc, argv);
    return said(exit_code);
  } catch (const CLI::Success& help) {  // --help and --version are exceptions too
    return said(app.exit(help));
  } catch (const CLI::ParseError& error) {
    return complain(usage_error(app, error), kBadUsage);
  } catch (const InputError& error) {
    return complain(error.what(), kBadUsage);
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), kBadUsage);
  } catch (const std::filesystem::filesystem_error& error) {
    return complain(error.path1().string() + ": " + error.code().message(), kFailed);
  } catch (const std::exception& error) {
    return complain(error.what(), kFailed);
  }
}

// What a command says goes nowhere; errors and the exit code stay.
void be_quiet() {
  Progress::silence();
  if (std::freopen("/dev/null", "w", stdout) == nullptr) throw std::runtime_error("no /dev/null");
}

void add_commands(CLI::App& app, int& exit_code) {
  add_compare(app, exit_code);
  add_run(app, exit_code);
  add_study(app, exit_code);
  add_report(app, exit_code);
  add_simulate(app, exit_code);
  add_track(app, exit_code);
  add_draw(app, exit_code);
  add_evaluate(app, exit_code);
  add_list(app, exit_code);
  for (CLI::App* command : app.get_subcommands({})) command->fallthrough();
}

void add(const Extras& extras) {
  own_numbers().insert(extras.numbers.begin(), extras.numbers.end());
  add_landmarks(extras.landmarks);
  add_classifiers(extras.classifiers);
  const EstimatorRow five_point = five_point_row();
  add_estimators({&five_point, 1});
  add_estimators(extras.estimators);
  add_readers(extras.readers);
  add_scenarios(rendered_scenarios());
  add_scenarios(extras.scenarios);
  add_metrics(extras.metrics);
}

}  // namespace

int run(int argc, char** argv, const Extras& extras, const char* share) {
  choose_blas_kernels(argv);
  prepare_process();
  if (*share != '\0') setenv("SLAMMOT_SHARE", share, 0);
  state_own_commit();
  remember_command_line(extras.program, argc, argv);
  try {
    add(extras);
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), kBadUsage);
  }
  CLI::App app{
      "Monocular SLAM with moving objects: filters and smoothers side by side, and judged"};
  app.name(extras.program);
  app.require_subcommand(1);
  app.set_version_flag("--version", "slammot " + version_text());
  app.add_flag_callback("--quiet", be_quiet, "print errors only; also after the command");
  int exit_code = 0;
  add_commands(app, exit_code);
  return parse_and_run(app, argc, argv, exit_code);
}

}  // namespace slammot::app
