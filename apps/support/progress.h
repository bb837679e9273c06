// Progress: what is done, frames (or runs) a second, and the time left. On a terminal one line that
// changes; where stderr goes elsewhere a line a minute, so that a log tells that it goes on.
#pragma once

#include <chrono>
#include <string>

namespace slammot {

class Progress {
 public:
  // For all of this process: nothing is shown.
  static void silence();

  explicit Progress(std::string unit = "frame", std::string units = "frames");
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  using Clock = std::chrono::steady_clock;

  // `done` may hold parts; `within` says what they are.
  void show(const std::string& label, double done, int total, const std::string& within = "",
            Clock::time_point now = Clock::now());
  void clear();

 private:
  std::string unit_, units_;
  bool on_terminal_;
  double before_ = 0.0;  // done when the clock was set
  std::string label_;
  Clock::time_point start_;
  Clock::time_point shown_;
};

}  // namespace slammot
