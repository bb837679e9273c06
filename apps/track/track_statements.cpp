#include "apps/track/track_statements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <set>

#include "datasets/native/native_tables.h"
#include "datasets/text/number.h"
#include "datasets/text/text_table.h"
#include "frontend/masks/mask_odds.h"

namespace slammot {
namespace {

constexpr double kVelocitySigma = 0.1;  // [m/s] where --velocity-sigma states none

// The first true camera. Nothing is made of a truth that is not there.
CameraState first_truth(const Sequence& sequence) {
  if (!sequence.truth.empty() && sequence.truth.front()) return *sequence.truth.front();
  throw InputError(sequence.folder, 0, "the first frame has no true pose to take a velocity from");
}

Eigen::Vector3d parse_velocity(const std::string& text) {
  Eigen::Vector3d v;
  int used = 0;
  const int read = std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &v.x(), &v.y(), &v.z(), &used);
  if (read != 3 || static_cast<size_t>(used) != text.size() || !(v.norm() < kLargest)) {
    throw std::invalid_argument(
        fmt::format("--initial-velocity '{}': expected VX,VY,VZ, as in 0,0,1.5 (m/s)", text));
  }
  return v;
}

}  // namespace

void require_velocity(const TrackStatements& stated) {
  if (!stated.initial_velocity.empty()) parse_velocity(stated.initial_velocity);
}

void state_velocity(const TrackStatements& stated, Sequence& sequence) {
  if (stated.initial_velocity.empty() && !stated.velocity_sigma) return;
  InitialCamera initial = sequence.initial.value_or(InitialCamera{});
  if (stated.initial_velocity.empty()) {
    initial.state = first_truth(sequence);
  } else {
    const bool has_truth = !sequence.truth.empty() && sequence.truth.front();
    if (!sequence.initial && has_truth) initial.state = *sequence.truth.front();
    initial.state.velocity = parse_velocity(stated.initial_velocity);
  }
  initial.velocity_sigma = stated.velocity_sigma.value_or(kVelocitySigma);
  initial.angular_velocity_sigma = 0.1;
  sequence.initial = initial;
}

void state_known(const std::filesystem::path& file, Sequence& sequence) {
  std::set<int> tracks;
  for (const Frame& frame : sequence.frames) {
    for (const Observation& z : frame.observations) tracks.insert(z.track);
  }
  for (const KnownLandmark& known : read_known(file, read_text_file(file))) {
    if (!tracks.contains(known.track)) {
      throw InputError(file, 0, fmt::format("track {} is measured in no image", known.track));
    }
    std::erase_if(sequence.known, [&](const auto& k) { return k.track == known.track; });
    sequence.known.push_back(known);
  }
}

std::string state_odds(const std::vector<std::filesystem::path>& masks, const Sequence& images,
                       TrackedImages& tracked) {
  MaskOdds odds = odds_by_masks(masks, images, tracked.sequence);
  for (std::string& warning : odds.warnings) tracked.warnings.push_back(std::move(warning));
  tracked.sequence.p_static = std::move(odds.p_static);
  const auto moving = std::ranges::count_if(tracked.sequence.p_static,
                                            [](const auto& said) { return said.second < 0.5; });
  return fmt::format("masks: {} of {} tracks move rather than rest", moving,
                     tracked.sequence.p_static.size());
}

}  // namespace slammot
