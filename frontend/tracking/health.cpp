#include "frontend/tracking/health.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace slammot {
namespace {

constexpr double kFew = 10.0;  // tracks; with fewer a pose hangs on single measurements

double median(std::vector<int> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

int common_tracks(const Frame& a, const Frame& b) {
  int common = 0;
  auto other = b.observations.begin();
  for (const Observation& z : a.observations) {
    while (other != b.observations.end() && other->track < z.track) ++other;
    if (other != b.observations.end() && other->track == z.track) ++common;
  }
  return common;
}

}  // namespace

TrackHealth track_health(const std::vector<Frame>& frames) {
  TrackHealth health;
  std::vector<int> followed, lives;
  std::map<int, int> life;
  double before = 0.0, lost = 0.0;
  for (size_t k = 0; k < frames.size(); ++k) {
    for (const Observation& z : frames[k].observations) ++life[z.track];
    if (k + 1 == frames.size()) break;
    const auto count = static_cast<int>(frames[k].observations.size());
    followed.push_back(common_tracks(frames[k], frames[k + 1]));
    before += count;
    lost += count - followed.back();
    if (!health.ends && count > 0 && followed.back() == 0) health.ends = frames[k].index;
  }
  for (const auto& [track, images] : life) lives.push_back(images);
  if (!followed.empty()) health.most = *std::ranges::max_element(followed);
  health.followed = median(std::move(followed));
  health.life = median(std::move(lives));
  health.lost = before > 0.0 ? lost / before : 0.0;
  return health;
}

std::vector<std::string> health_faults(const TrackHealth& health) {
  std::vector<std::string> faults;
  if (health.followed < kFew) {
    faults.push_back(
        fmt::format("{} tracks (median) are followed from one image to the next: fewer than {}",
                    health.followed, kFew));
  }
  if (health.ends) {
    faults.push_back(
        fmt::format("no track is followed from frame {} to the next: nothing ties the poses before "
                    "it to those behind",
                    *health.ends));
  }
  return faults;
}

std::vector<std::string> beside_texts(const Sequence& images, const std::vector<Frame>& frames) {
  size_t all = 0, depths = 0;
  std::vector<size_t> matches(images.other_images.size());
  for (const Frame& frame : frames) {
    all += frame.observations.size();
    for (const Observation& z : frame.observations) depths += z.has_depth() ? 1 : 0;
    for (const Observation& z : frame.other_views) ++matches[static_cast<size_t>(z.camera) - 1];
  }
  const auto share = [all](size_t some) {
    const double percent = 100.0 * static_cast<double>(some) / static_cast<double>(all);
    return fmt::format("{} of {} measurements ({:.1f}%)", some, all, all > 0 ? percent : 0.0);
  };
  std::vector<std::string> texts;
  for (size_t c = 0; c < matches.size(); ++c) {
    texts.push_back(fmt::format("camera {}, {:.4g} m from camera 0, matches {}", c + 1,
                                images.other_cameras[c].t.norm(), share(matches[c])));
  }
  if (!images.depth_images.empty()) texts.push_back("depth images measure " + share(depths));
  return texts;
}

}  // namespace slammot
