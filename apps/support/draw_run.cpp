#include "apps/support/draw_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "eval/metrics/pose_pairs.h"
#include "eval/output/run_files.h"
#include "eval/output/run_reader.h"
#include "frontend/image_file.h"
#include "frontend/rendering/film.h"
#include "frontend/rendering/picture.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;
using Positions = std::vector<Eigen::Vector3d>;

std::map<int, std::vector<LandmarkEstimate>> landmarks_by_frame(const Path& file) {
  std::map<int, std::vector<LandmarkEstimate>> by_frame;
  std::map<int, int> rows;
  bool several = false;
  for (const LandmarkRecord& record : read_landmark_rows(file)) {
    by_frame[record.frame].push_back(record.estimate);
    several |= ++rows[record.estimate.track] > 1;
  }
  if (!several) throw InputError(file, 0, "only final landmarks; run with --landmarks every-frame");
  return by_frame;
}

double frame_rate(const Sequence& sequence) {
  const auto count = static_cast<double>(sequence.frames.size());
  const double time = sequence.frames.back().timestamp - sequence.frames.front().timestamp;
  return time > 0.0 ? std::clamp((count - 1.0) / time, 1.0, 60.0) : 10.0;
}

// The frame of the sequence at the time of an estimate.
size_t frame_at(const Sequence& sequence, double timestamp) {
  const auto later = [&](const Frame& frame) { return frame.timestamp < timestamp - 1e-6; };
  const auto found = std::partition_point(sequence.frames.begin(), sequence.frames.end(), later);
  if (found == sequence.frames.end()) {
    throw InputError(sequence.folder, 0, fmt::format("no frame at time {}", timestamp));
  }
  return static_cast<size_t>(found - sequence.frames.begin());
}

class Painter {
 public:
  Painter(const Sequence& sequence, const StoredRun& run, const Path& landmarks)
      : sequence_(sequence),
        pixel_sigma_(run.pixel_sigma.value_or(sequence.pixel_sigma)),
        landmarks_(landmarks_by_frame(landmarks)) {
    Positions path, points;
    for (const CameraEstimate& camera : run.run.filtered) path.push_back(camera.state.position);
    for (const LandmarkRecord& last : run.run.landmarks) {
      const bool decided = last.estimate.label != Label::kUnknown;
      if (decided && last.estimate.position.allFinite()) points.push_back(last.estimate.position);
    }
    plane_ = map_plane(run.run.filtered.front().state, path, points);
  }

  cv::Mat paint(const CameraEstimate& estimate, size_t i, const std::string& estimator) {
    const Frame& frame = sequence_.frames[i];
    const cv::Mat image = decode_image(sequence_.folder / sequence_.images[i]);
    const PictureState state{sequence_.camera, pixel_sigma_, estimate, landmarks_[frame.index],
                             frame.observations};
    path_.push_back(estimate.state.position);
    if (i < sequence_.truth.size() && sequence_.truth[i]) {
      truth_.push_back(sequence_.truth[i]->position);
    }
    const int enlarge = image.cols < 500 ? 2 : 1;
    const cv::Mat seen = draw_predictions(image, enlarge, state);
    const cv::Mat map = draw_map(plane_, map_size(seen.size()), state, path_, truth_);
    return picture_page(
        seen, map,
        fmt::format(
            "{}, frame {}, {:.2f} s: {} landmarks. blue discs static, purple squares unknown, "
            "red diamonds moving, light blue not found; truth grey",
            estimator, frame.index, frame.timestamp - sequence_.frames.front().timestamp,
            state.landmarks.size()));
  }

 private:
  const Sequence& sequence_;
  double pixel_sigma_;  // as given to the run
  std::map<int, std::vector<LandmarkEstimate>> landmarks_;
  MapPlane plane_;
  Positions path_, truth_;
};

}  // namespace

int draw_run(const Path& folder, const Sequence& sequence, const Path& output,
             const std::function<void(int done, int total)>& progress) try {
  if (sequence.images.empty()) throw InputError(sequence.folder, 0, "frames.csv names no images");
  const StoredRun run = read_run(folder);
  if (run.run.filtered.empty()) throw InputError(folder, 0, "the run has no frame");
  Painter painter(sequence, run, folder / run_files::kLandmarks);
  const int total = static_cast<int>(run.run.filtered.size());
  Film film(output, total, frame_rate(sequence));
  for (int k = 0; k < total; ++k) {
    const CameraEstimate& estimate = run.run.filtered[static_cast<size_t>(k)];
    const size_t i = frame_at(sequence, estimate.timestamp);
    film.add(sequence.frames[i].index, painter.paint(estimate, i, run.estimator));
    if (progress) progress(k + 1, total);
  }
  film.finish();
  return total;
} catch (const cv::Exception& error) {
  throw std::runtime_error(fmt::format("OpenCV: {}", error.err));
}

}  // namespace slammot
