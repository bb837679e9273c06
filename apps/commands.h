// The subcommands of `slammot`, one file each. Each declares its arguments on `app` and sets
// `exit_code` when it has run: 0 done, 1 the run failed. Bad input leaves as an exception, see
// main.cpp.
#pragma once

#include <CLI/CLI.hpp>

namespace slammot {

inline constexpr char kForceHelp[] = "replace an earlier output of this command";
inline constexpr char kVerboseHelp[] =
    "also what of the method was in force, and how often it acted";

void add_compare(CLI::App& app, int& exit_code);
void add_study(CLI::App& app, int& exit_code);
void add_report(CLI::App& app, int& exit_code);
void add_run(CLI::App& app, int& exit_code);
void add_simulate(CLI::App& app, int& exit_code);
void add_track(CLI::App& app, int& exit_code);
void add_draw(CLI::App& app, int& exit_code);
void add_evaluate(CLI::App& app, int& exit_code);
void add_list(CLI::App& app, int& exit_code);

}  // namespace slammot
