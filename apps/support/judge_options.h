// The options of commands that judge stored runs, and the judging.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "eval/run/evaluate.h"

namespace slammot {

struct JudgeArguments {
  std::vector<std::string> runs;
  std::vector<std::string> against;
  std::string convention = "position-first,right,global";
  std::string extrinsics;  // file
  std::string align = "none";
  double time_offset = 0.0;
  double max_difference = 0.0;
  bool force_sequence = false;
  bool force = false;
};

void add_judge_options(CLI::App& command, JudgeArguments& arguments);

std::vector<JudgedRun> judged(const JudgeArguments& arguments);

}  // namespace slammot
