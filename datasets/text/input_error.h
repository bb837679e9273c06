// Bad input: `what()` is one line, "file:line: reason"; line 0 is the file as a whole.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "datasets/text/printable.h"

namespace slammot {

struct InputError : std::runtime_error {
  InputError(const std::filesystem::path& file, int line, const std::string& reason)
      : std::runtime_error(printable(file.string() + ":" + std::to_string(line) + ": " + reason)) {}
};

}  // namespace slammot
