#include <fmt/format.h>

#include "datasets/sequence/sequence_hints.h"

namespace slammot {
namespace {

// The distance from the centre [px] beyond which a lens has no ray: its first maximum.
double reach(const Camera& camera) {
  constexpr double kNearest = 1e-3, kFarthest = 1e4, kStep = 1.01;  // of the ray, x/z
  const auto slope = [&](double r) {
    return std::visit([&](const auto& lens) { return lens.jacobian({r, 0.0})(0, 0); }, camera.lens);
  };
  double r = kNearest;
  while (r < kFarthest && slope(r) > 0.0) r *= kStep;
  double below = r / kStep;
  for (int i = 0; i < 50 && r < kFarthest; ++i) {
    const double middle = 0.5 * (below + r);
    (slope(middle) > 0.0 ? below : r) = middle;
  }
  return camera.project({below, 0.0, 1.0})->pixel.x() - camera.cx;
}

}  // namespace

std::optional<std::string> leave_out_rayless(Sequence& sequence) {
  if (std::holds_alternative<PinholeLens>(sequence.camera.lens)) return std::nullopt;
  const Rig rig(sequence.camera, sequence.other_cameras);
  std::size_t left_out = 0, in_frames = 0;
  for (Frame& frame : sequence.frames) {
    const std::size_t gone = std::erase_if(frame.observations, [&](const Observation& z) {
      return !sequence.camera.unproject(z.pixel);
    });
    std::erase_if(frame.other_views,
                  [&](const Observation& z) { return !rig[z.camera].lens.unproject(z.pixel); });
    left_out += gone;
    in_frames += gone > 0 ? 1 : 0;
  }
  if (left_out == 0) return std::nullopt;
  return fmt::format(
      "{} measurements in {} frames are left out: the lens has no ray beyond {:.1f} px from its "
      "centre",
      left_out, in_frames, reach(sequence.camera));
}

}  // namespace slammot
