// Bad input: `what()` is one line, "file:line: reason"; of the file as a whole, line 0, "file:
// reason".
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "datasets/text/printable.h"

namespace slammot {

struct InputError : std::runtime_error {
  InputError(const std::filesystem::path& file, int line, const std::string& reason)
      : std::runtime_error(
            printable(line == 0 ? fmt::format("{}: {}", file.string(), reason)
                                : fmt::format("{}:{}: {}", file.string(), line, reason))) {}
};

}  // namespace slammot
