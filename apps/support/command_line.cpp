#include "apps/support/command_line.h"

#include <algorithm>
#include <cctype>

namespace slammot {
namespace {

std::string remembered;

bool is_plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
         std::string("-_=./,:+@%").find(c) != std::string::npos;
}

std::string quoted(const std::string& word) {
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string text(1, '\'');
  for (const char c : word) {
    if (c == '\'') text += "'\\'";  // closes, adds a quoted quote, and the quote below reopens
    text += c;
  }
  text += '\'';
  return text;
}

}  // namespace

void remember_command_line(const std::string& program, int argc, const char* const* argv) {
  remembered = program;
  for (int i = 1; i < argc; ++i) {
    remembered += ' ';
    remembered += quoted(argv[i]);
  }
}

const std::string& command_line() { return remembered; }

}  // namespace slammot
