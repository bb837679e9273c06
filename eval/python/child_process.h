// A program that is spoken to line by line, over a socket that is its standard input: its standard
// output stays free for what it prints.
#pragma once

#include <sys/types.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace slammot {

// It ended, or could not be started. What it says is one line.
struct ChildEnded : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class ChildProcess {
 public:
  // Without a shell, so that no character of a word means anything. Throws ChildEnded.
  ChildProcess(std::vector<std::string> words, std::vector<std::string> environment);
  ~ChildProcess();  // it reads the end of its input, and is waited for
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Sends a line and returns the line that answers. Both throw ChildEnded, and say how it ended.
  std::string ask(const std::string& line);
  std::string read_line();

 private:
  [[noreturn]] void report_end();
  std::string end();  // waits for it
  void send(const std::string& text);

  pid_t child_ = -1;
  int socket_ = -1;
  std::string received_;  // beyond the last line
};

}  // namespace slammot
