// The command as it was typed, quoted for a shell, for run.yaml.
#pragma once

#include <string>

namespace slammot {

void remember_command_line(const std::string& program, int argc, const char* const* argv);
const std::string& command_line();

}  // namespace slammot
