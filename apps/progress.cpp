#include "slammot/apps/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace slammot {

Progress::Progress() : on_terminal_(isatty(STDERR_FILENO) == 1) {}

void Progress::show(const std::string& label, int done, int total) {
  if (!on_terminal_) return;
  const Clock::time_point now = Clock::now();
  if (label != label_) {
    label_ = label;
    start_ = shown_ = now;
    return;
  }
  if (done < total && now - shown_ < std::chrono::milliseconds(200)) return;
  shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed > 0.0 ? (done - 1) / elapsed : 0.0;  // the first frame set the clock
  const double left = rate > 0.0 ? (total - done) / rate : 0.0;
  const std::string line = fmt::format("\r\033[K{}: frame {} of {}, {:.1f} frames/s, {:.0f} s left",
                                       label, done, total, rate, left);
  std::fputs(line.c_str(), stderr);
}

void Progress::clear() {
  if (on_terminal_ && !label_.empty()) std::fputs("\r\033[K", stderr);
  label_.clear();
}

}  // namespace slammot
