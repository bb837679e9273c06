// Progress on a terminal: what is done, frames (or runs) a second, and the time left. Silent when
// stderr is not a terminal.
#pragma once

#include <chrono>
#include <string>

namespace slammot {

class Progress {
 public:
  explicit Progress(std::string unit = "frame", std::string units = "frames");
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(const std::string& label, int done, int total);
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  std::string unit_, units_;
  bool on_terminal_;
  int before_ = 0;  // done when the clock was set
  std::string label_;
  Clock::time_point start_;
  Clock::time_point shown_;
};

}  // namespace slammot
