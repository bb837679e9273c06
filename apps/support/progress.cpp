#include "apps/support/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace slammot {
namespace {

bool silent = false;

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""min;

}  // namespace

void Progress::silence() { silent = true; }

Progress::Progress(std::string unit, std::string units)
    : unit_(std::move(unit)), units_(std::move(units)), on_terminal_(isatty(STDERR_FILENO) == 1) {}

void Progress::show(const std::string& label, double done, int total, const std::string& within,
                    Clock::time_point now) {
  if (silent) return;
  if (label != label_) {
    if (label_.empty() || on_terminal_) shown_ = now;  // many short ones are a line a minute too
    label_ = label;
    start_ = now;
    before_ = done;
    return;
  }
  const Clock::duration pause = on_terminal_ ? Clock::duration(200ms) : Clock::duration(1min);
  const bool last = on_terminal_ && done >= total;
  if (!last && now - shown_ < pause) return;
  shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed > 0.0 ? (done - before_) / elapsed : 0.0;  // the first set the clock
  const double left = rate > 0.0 ? (total - done) / rate : 0.0;
  const std::string line = fmt::format("{}: {} {:.0f} of {}{}, {:.2g} {}/s, {:.0f} s left", label,
                                       unit_, std::floor(done), total, within, rate, units_, left);
  fmt::print(stderr, fmt::runtime(on_terminal_ ? "\r\033[K{}" : "{}\n"), line);
}

void Progress::clear() {
  if (on_terminal_ && !label_.empty()) std::fputs("\r\033[K", stderr);
  label_.clear();
}

}  // namespace slammot
