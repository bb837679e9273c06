// Starting a program without a shell, so that no character of a word means anything.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace slammot {

// The program is words[0]. `input` becomes its standard input; negative: this process's. Returns 0,
// or errno where it could not be started.
int spawn(std::vector<std::string> words, std::vector<std::string> environment, int input,
          pid_t& child);

}  // namespace slammot
