#include "apps/support/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace slammot {

Progress::Progress(std::string unit, std::string units)
    : unit_(std::move(unit)), units_(std::move(units)), on_terminal_(isatty(STDERR_FILENO) == 1) {}

void Progress::show(const std::string& label, int done, int total) {
  if (!on_terminal_) return;
  const Clock::time_point now = Clock::now();
  if (label != label_) {
    label_ = label;
    start_ = shown_ = now;
    before_ = done;
    return;
  }
  if (done < total && now - shown_ < std::chrono::milliseconds(200)) return;
  shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed > 0.0 ? (done - before_) / elapsed : 0.0;  // the first set the clock
  const double left = rate > 0.0 ? (total - done) / rate : 0.0;
  const std::string line = fmt::format("\r\033[K{}: {} {} of {}, {:.2g} {}/s, {:.0f} s left", label,
                                       unit_, done, total, rate, units_, left);
  std::fputs(line.c_str(), stderr);
}

void Progress::clear() {
  if (on_terminal_ && !label_.empty()) std::fputs("\r\033[K", stderr);
  label_.clear();
}

}  // namespace slammot
