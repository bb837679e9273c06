#include "frontend/tracking/track_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <set>

#include "datasets/sequence/plausible.h"
#include "frontend/tracking/depth_image.h"
#include "frontend/tracking/other_view.h"

namespace slammot {
namespace {

// A camera is read before its size is known.
void take_size(const Sequence& images, const cv::Size& size, Camera& camera) {
  if (images.camera_assumed && size != cv::Size(camera.width, camera.height)) {
    throw InputError(images.folder, 0,
                     fmt::format("the images are {} x {}; nobody states their camera, and the {} x "
                                 "{} px of the usual one are an assumption: --camera replaces it",
                                 size.width, size.height, camera.width, camera.height));
  }
  if (camera.width > 0 && size != cv::Size(camera.width, camera.height)) {
    throw InputError(images.folder, 0,
                     fmt::format("the images are {} x {}, their camera is of {} x {} px",
                                 size.width, size.height, camera.width, camera.height));
  }
  camera.width = size.width;
  camera.height = size.height;
  if (const Fault fault = camera_fault(camera)) throw InputError(images.folder, 0, *fault);
}

// Estimators take the landmarks of the first frame as static. Where that is no fair promise, only
// what is known of it is measured there, and the rest is new in the second frame.
void keep_known_only(size_t seeds, Frame& first) {
  for (auto* views : {&first.observations, &first.other_views}) {
    std::erase_if(*views,
                  [&](const Observation& z) { return static_cast<size_t>(z.track) >= seeds; });
  }
}

// The board's outer corners become tracks 0 to 3, and these become known.
BoardView seed_chessboard(const cv::Mat& image, const Chessboard& board, const Sequence& sequence,
                          Tracker& tracker) {
  const auto view = find_chessboard(image, sequence.camera, board);
  if (!view) {
    throw InputError(sequence.folder, 0,
                     fmt::format("no chessboard of {}x{} inner corners is found in the first image",
                                 board.columns, board.rows));
  }
  std::vector<Eigen::Vector2d> seeds;
  for (const size_t i : outer_corners(board)) seeds.push_back(view->pixels[i]);
  tracker.seed(std::move(seeds));
  return *view;
}

void state_chessboard(const BoardView& view, const Chessboard& board, Sequence& sequence) {
  constexpr double kPrintSigma = 0.005;  // of a corner's place, in parts of the pitch
  std::set<int> seen;
  for (const Observation& z : sequence.frames.front().observations) seen.insert(z.track);
  int track = 0;
  for (const size_t i : outer_corners(board)) {
    if (seen.count(track) > 0) {
      sequence.known.push_back({track, view.positions[i], kPrintSigma * board.pitch});
    }
    ++track;
  }
  sequence.initial = view.camera;
}

void keep_frame(const Sequence& images, size_t i, Frame frame, Sequence& sequence) {
  frame.index = static_cast<int>(sequence.frames.size());
  frame.timestamp = images.frames[i].timestamp;
  sequence.frames.push_back(std::move(frame));
  if (!images.images.empty()) sequence.images.push_back(images.images[i]);
  for (size_t c = 0; c < images.other_images.size(); ++c) {
    sequence.other_images[c].push_back(images.other_images[c][i]);
  }
  if (!images.truth.empty()) sequence.truth.push_back(images.truth[i]);
}

Sequence without_frames(const Sequence& images) {
  Sequence sequence = images;
  sequence.frames.clear();
  sequence.images.clear();
  sequence.truth.clear();
  for (auto& names : sequence.other_images) names.clear();
  sequence.depth_images.clear();
  // A rig of which no other camera's images are known.
  if (images.other_images.empty()) sequence.other_cameras.clear();
  return sequence;
}

// Cameras by the images of the first frame.
void begin_views(const Sequence& images, const cv::Size& size, Sequence& sequence,
                 std::vector<OtherView>& others) {
  take_size(images, size, sequence.camera);
  for (MountedCamera& other : sequence.other_cameras) {
    take_size(images, size, other.lens);
    others.emplace_back(sequence.camera, other, static_cast<int>(others.size()) + 1);
  }
}

Frame measure(const FrameImages& images, double depth_unit, Tracker& tracker,
              std::vector<OtherView>& others) {
  Frame frame;
  frame.observations = tracker.process(images.image);
  for (size_t c = 0; c < others.size(); ++c) {
    if (images.others[c].empty()) continue;
    for (const Observation& z : others[c].match(tracker, images.others[c], frame.observations)) {
      frame.other_views.push_back(z);
    }
  }
  std::ranges::stable_sort(frame.other_views, {}, &Observation::track);
  if (!images.depth.empty()) measure_depths(images.depth, depth_unit, frame.observations);
  return frame;
}

void track_all(const Sequence& images, const FrameFunction& read, const TrackOptions& options,
               TrackedImages& result) {
  Sequence& sequence = result.sequence;
  Tracker tracker(options.tracker);
  std::vector<OtherView> others;
  FrameStream stream(images.frames.size(), read, options.threads);
  std::optional<BoardView> board;
  for (size_t i = 0; i < images.frames.size(); ++i) {
    const Loaded loaded = stream.next();
    if (loaded.error) {
      if (!options.skip_bad_frames) throw *loaded.error;
      result.skipped.emplace_back(loaded.error->what());
      continue;
    }
    if (sequence.frames.empty()) {
      begin_views(images, loaded.images.image.size(), sequence, others);
      if (options.chessboard) {
        board = seed_chessboard(loaded.images.image, *options.chessboard, sequence, tracker);
      }
    }
    keep_frame(images, i, measure(loaded.images, images.depth_unit, tracker, others), sequence);
    if (options.progress) {
      options.progress(static_cast<int>(i) + 1, static_cast<int>(images.frames.size()));
    }
  }
  if (sequence.frames.empty()) throw InputError(images.folder, 0, "no image can be read");
  if (result.skipped.size() > sequence.frames.size()) {
    throw InputError(
        images.folder, 0,
        fmt::format("{} of {} images cannot be used; the first: {}", result.skipped.size(),
                    images.frames.size(), result.skipped.front()));
  }
  if (options.moving_start) {
    keep_known_only(board ? outer_corners(*options.chessboard).size() : 0, sequence.frames.front());
  }
  if (board) state_chessboard(*board, *options.chessboard, sequence);
}

}  // namespace

TrackedImages track_images(const Sequence& images, const FrameFunction& read,
                           const TrackOptions& options) try {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  // More than there are cores gain nothing, and a process may have only so many.
  cv::setNumThreads(options.threads == 0 ? -1 : std::min(options.threads, cv::getNumberOfCPUs()));
  TrackedImages result;
  result.sequence = without_frames(images);
  result.sequence.points = options.tracker.corners.count;
  track_all(images, read, options, result);
  std::set<int> tracks;
  for (const Frame& frame : result.sequence.frames) {
    for (const Observation& z : frame.observations) tracks.insert(z.track);
  }
  result.tracks = static_cast<int>(tracks.size());
  result.health = track_health(result.sequence.frames);
  result.noise = measure_noise(result.sequence, options.noise);
  state_noise(result.noise, options.noise, result.sequence);
  return result;
} catch (const cv::Exception& error) {
  throw std::runtime_error(fmt::format("OpenCV: {}", error.err));
}

TrackedImages track_images(const Sequence& images, const TrackOptions& options) {
  if (!options.skip_bad_frames) refuse_missing(images);
  FrameFiles files(images, options.mixed_colours);
  TrackedImages tracked = track_images(
      images, [&](size_t place) { return files.read(place); }, options);
  if (const auto fault = files.depth_fault()) tracked.warnings.push_back(*fault);
  return tracked;
}

}  // namespace slammot
