// slammot: filter or smoother? Exit codes: 0 done, 1 the run failed, 2 bad usage or bad input.
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "apps/commands.h"
#include "apps/support/command_line.h"
#include "datasets/sequence/sequence.h"
#include "eval/run/process.h"

namespace {

constexpr int kFailed = 1;
constexpr int kBadUsage = 2;

int complain(const char* reason, int exit_code) {
  std::fprintf(stderr, "slammot: %s\n", slammot::printable(reason).c_str());
  return exit_code;
}

// Arguments are written into results, which are UTF-8.
void require_utf8(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (slammot::invalid_utf8(argv[i]) == std::string::npos) continue;
    throw std::invalid_argument(std::string(argv[i]) + ": is not UTF-8");
  }
}

int parse_and_run(CLI::App& app, int argc, char** argv, const int& exit_code) {
  try {
    require_utf8(argc, argv);
    app.parse(argc, argv);
    return exit_code;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadUsage;  // --help is an exception too
  } catch (const slammot::InputError& error) {
    return complain(error.what(), kBadUsage);
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), kBadUsage);
  } catch (const std::exception& error) {
    return complain(error.what(), kFailed);
  }
}

}  // namespace

int main(int argc, char** argv) {
  slammot::choose_blas_kernels(argv);
  slammot::prepare_process();
  slammot::remember_command_line(argc, argv);
  CLI::App app{
      "Monocular SLAM with moving objects: filters and smoothers side by side, and judged"};
  app.name("slammot");
  app.require_subcommand(1);
  app.set_version_flag("--version", SLAMMOT_VERSION);
  int exit_code = 0;
  slammot::add_compare(app, exit_code);
  slammot::add_run(app, exit_code);
  slammot::add_study(app, exit_code);
  slammot::add_report(app, exit_code);
  slammot::add_simulate(app, exit_code);
  slammot::add_track(app, exit_code);
  slammot::add_draw(app, exit_code);
  slammot::add_evaluate(app, exit_code);
  slammot::add_list(app, exit_code);
  return parse_and_run(app, argc, argv, exit_code);
}
