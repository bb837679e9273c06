#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "datasets/sequence/sequence_hints.h"

namespace slammot {
namespace {

constexpr double kTurnInDegrees = 180.0 / std::numbers::pi;

// Rows that jump away from the rows beside them, which are near each other.
struct Jump {
  const TimedPose* pose;  // the first
  std::size_t rows;
  double size;   // in metres or degrees
  double speed;  // per second
};

using Distance = double (*)(const TimedPose&, const TimedPose&);

double metres(const TimedPose& a, const TimedPose& b) { return (a.position - b.position).norm(); }
double degrees(const TimedPose& a, const TimedPose& b) {
  return a.orientation.angularDistance(b.orientation) * kTurnInDegrees;
}

// From `i` on so many rows: the steps to them and from them are long beside those between them,
// before and after, and lead back.
std::optional<Jump> jump_at(const std::vector<TimedPose>& poses, std::size_t i, std::size_t rows,
                            Distance distance, double least) {
  constexpr double kTimes = 10.0, kBack = 0.2;
  constexpr std::size_t kBeside = 2;  // steps on either side
  const std::size_t n = poses.size(), next = i + rows;
  const bool inside = i > 0 && next < n;
  if (!inside && rows > 1) return std::nullopt;
  const auto step = [&](std::size_t k) { return distance(poses[k], poses[k + 1]); };
  const double in = i > 0 ? step(i - 1) : step(0), out = next < n ? step(next - 1) : step(n - 2);
  double beside = 0.0;
  for (std::size_t k = i > kBeside ? i - kBeside - 1 : 0; k < std::min(n - 1, next + kBeside);
       ++k) {
    if (k + 1 != i && k + 1 != next) beside = std::max(beside, step(k));
  }
  const double size = std::min(in, out);
  if (!(size > least && size > kTimes * beside)) return std::nullopt;
  if (inside && distance(poses[i - 1], poses[next]) > kBack * size) return std::nullopt;
  const TimedPose& other = poses[i > 0 ? i - 1 : 1];
  return Jump{&poses[i], rows, size, size / std::abs(poses[i].timestamp - other.timestamp)};
}

std::optional<Jump> shortest_jump_at(const std::vector<TimedPose>& poses, std::size_t i,
                                     Distance distance, double least) {
  constexpr std::size_t kMostRows = 5;
  for (std::size_t rows = 1; rows <= kMostRows && i + rows <= poses.size(); ++rows) {
    if (auto jump = jump_at(poses, i, rows, distance, least)) return jump;
  }
  return std::nullopt;
}

Hints jumps(const std::filesystem::path& file, const std::vector<TimedPose>& poses,
            Distance distance, double least, const char* unit) {
  constexpr double kFastest = 1e4;  // [m/s], faster than a satellite
  constexpr std::size_t kMost = 3;  // that are named
  Hints hints;
  std::size_t count = 0;
  for (std::size_t i = 0; poses.size() >= 4 && i < poses.size(); ++i) {
    const auto jump = shortest_jump_at(poses, i, distance, least);
    if (!jump) continue;
    const std::string reason = fmt::format(
        "{} {:.4g} {} off the rows beside it",
        jump->rows == 1 ? "the true pose is" : fmt::format("{} true poses are", jump->rows),
        jump->size, unit);
    if (distance == metres && jump->speed > kFastest) {
      throw InputError(file, jump->pose->line, reason + ", faster than anything moves");
    }
    if (++count > kMost) continue;
    hints.push_back(fmt::format("{}:{}: {}", file.filename().string(), jump->pose->line, reason));
  }
  if (count > kMost) hints.back() += fmt::format(", and {} more rows", count - kMost);
  return hints;
}

std::optional<std::string> few_truths(const std::vector<TimedPose>& poses,
                                      const Sequence& sequence) {
  constexpr double kEnough = 0.9;
  const std::vector<Frame>& frames = sequence.frames;
  const auto known = static_cast<std::size_t>(
      std::ranges::count_if(sequence.truth, [](const auto& truth) { return truth.has_value(); }));
  if (poses.empty() || static_cast<double>(known) >= kEnough * static_cast<double>(frames.size())) {
    return std::nullopt;
  }
  const double first = poses.front().timestamp, last = poses.back().timestamp;
  return fmt::format(
      "truth for {} of {} frames: only these are judged; true poses are from {:.13g} to {:.13g} s, "
      "frames from {:.13g} to "
      "{:.13g} s, and nothing is interpolated over more than {} frames{}",
      known, frames.size(), first, last, frames.front().timestamp, frames.back().timestamp,
      kLongestGap, unit_clue(first, last, frames));
}

}  // namespace

Hints truth_hints(const std::filesystem::path& file, const std::vector<TimedPose>& poses,
                  const Sequence& sequence) {
  constexpr double kLeastMetres = 0.05, kLeastDegrees = 5.0;
  Hints hints = jumps(file, poses, metres, kLeastMetres, "m");
  for (std::string& hint : jumps(file, poses, degrees, kLeastDegrees, "deg")) {
    hints.push_back(std::move(hint));
  }
  if (auto hint = few_truths(poses, sequence)) hints.push_back(std::move(*hint));
  return hints;
}

}  // namespace slammot
