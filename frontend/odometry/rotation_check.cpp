#include "frontend/odometry/rotation_check.h"

#include <algorithm>

#include "frontend/odometry/two_view.h"

namespace slammot {
namespace {

constexpr std::size_t kStep = 5;           // frames from span to span
constexpr std::size_t kLongest = 10;       // frames
constexpr std::size_t kFewestTracks = 20;  // of a span; with fewer it is made shorter

struct Span {
  std::size_t last = 0;
  RayMatches matches;
};

// The longest that enough tracks live through; the shortest, if none does.
Span span_from(const Sequence& sequence, std::size_t first, std::size_t end) {
  Span span;
  for (std::size_t length = std::min(kLongest, end - 1 - first); length > 0; --length) {
    span.last = first + length;
    span.matches = match_rays(rays_by_track(sequence.camera, sequence.frames[first]),
                              rays_by_track(sequence.camera, sequence.frames[span.last]))
                       .rays;
    if (span.matches.first.size() >= kFewestTracks) break;
  }
  return span;
}

}  // namespace

std::vector<RotationSpan> check_rotation(const Sequence& sequence,
                                         const std::vector<CameraEstimate>& cameras,
                                         double pixel_sigma) {
  const double sigma = ray_sigma(sequence.camera, pixel_sigma);
  const std::size_t end = std::min(cameras.size(), sequence.frames.size());
  std::vector<RotationSpan> spans;
  for (std::size_t first = 0; first + 1 < end; first += kStep) {
    const Span span = span_from(sequence, first, end);
    const auto five_point = relative_pose(span.matches, sigma, Search::kQuick);
    if (!five_point) continue;
    const Eigen::Matrix3d R =
        (cameras[span.last].state.orientation.conjugate() * cameras[first].state.orientation)
            .toRotationMatrix();
    spans.push_back({sequence.frames[first].index, sequence.frames[span.last].index,
                     explained(span.matches, sigma, *five_point),
                     explained(span.matches, sigma, with_rotation(span.matches, sigma, R)),
                     Eigen::AngleAxisd(R.transpose() * five_point->R).angle()});
  }
  return spans;
}

}  // namespace slammot
