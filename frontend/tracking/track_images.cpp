#include "frontend/tracking/track_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <future>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <set>

#include "datasets/readers/image_reader.h"
#include "datasets/sequence/plausible.h"
#include "frontend/image_file.h"

namespace slammot {
namespace {

// An image, or why there is none.
struct Loaded {
  cv::Mat image;
  std::optional<InputError> error;
};

Loaded load(const ImageFunction& image, size_t place) {
  try {
    return {image(place), std::nullopt};
  } catch (const InputError& error) {
    return {{}, error};
  }
}

// The images in order, the next one being made while the caller is at work.
class ImageStream {
 public:
  ImageStream(size_t count, const ImageFunction& image, const TrackOptions& options)
      : count_(count),
        image_(image),
        policy_(options.threads == 1 ? std::launch::deferred : std::launch::async) {
    request();
  }
  Loaded next() {
    Loaded loaded = pending_.get();
    request();
    return loaded;
  }

 private:
  void request() {
    if (next_ == count_) return;
    const size_t place = next_++;
    pending_ = std::async(policy_, [this, place] { return load(image_, place); });
  }

  size_t count_;
  const ImageFunction& image_;
  std::launch policy_;
  size_t next_ = 0;
  std::future<Loaded> pending_;  // last: its task ends before what it uses
};

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

// Missing files are cheaply found before the first image is decoded.
void refuse_missing(const Sequence& images) {
  const std::vector<bool> present = images_present(images);
  const auto missing = std::find(present.begin(), present.end(), false);
  if (missing == present.end()) return;
  const auto frame = static_cast<size_t>(missing - present.begin());
  throw InputError(images.folder / images.images[frame], 0,
                   fmt::format("frame {} of {} is missing", frame, present.size()));
}

// Estimators take the landmarks of the first frame as static. Where that is no fair promise, only
// what is known of it is measured there, and the rest is new in the second frame.
void keep_known_only(size_t seeds, Frame& first) {
  std::erase_if(first.observations,
                [&](const Observation& z) { return static_cast<size_t>(z.track) >= seeds; });
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

void keep_frame(const Sequence& images, size_t i, std::vector<Observation> observations,
                Sequence& sequence) {
  const int index = static_cast<int>(sequence.frames.size());
  sequence.frames.push_back({index, images.frames[i].timestamp, std::move(observations), {}});
  if (!images.images.empty()) sequence.images.push_back(images.images[i]);
  if (!images.truth.empty()) sequence.truth.push_back(images.truth[i]);
}

Sequence without_frames(const Sequence& images) {
  Sequence sequence = images;
  sequence.frames.clear();
  sequence.images.clear();
  sequence.truth.clear();
  return sequence;
}

void track_all(const Sequence& images, const ImageFunction& image, const TrackOptions& options,
               TrackedImages& result) {
  Sequence& sequence = result.sequence;
  Tracker tracker(options.tracker);
  ImageStream stream(images.frames.size(), image, options);
  std::optional<BoardView> board;
  for (size_t i = 0; i < images.frames.size(); ++i) {
    const Loaded loaded = stream.next();
    if (loaded.error) {
      if (!options.skip_bad_frames) throw *loaded.error;
      result.skipped.emplace_back(loaded.error->what());
      continue;
    }
    if (sequence.frames.empty()) {
      take_size(images, loaded.image.size(), sequence.camera);
      if (options.chessboard) {
        board = seed_chessboard(loaded.image, *options.chessboard, sequence, tracker);
      }
    }
    keep_frame(images, i, tracker.process(loaded.image), sequence);
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

TrackedImages track_images(const Sequence& images, const TrackOptions& options) {
  if (!options.skip_bad_frames) refuse_missing(images);
  const cv::Size size(images.camera.width, images.camera.height);
  ImageSource source(images.camera_assumed ? cv::Size() : size, options.mixed_colours);
  const auto read = [&](size_t place) { return source.read(images.folder / images.images[place]); };
  TrackedImages tracked = track_images(images, read, options);
  if (const auto fault = source.depth_fault()) tracked.warnings.push_back(*fault);
  return tracked;
}

TrackedImages track_images(const Sequence& images, const ImageFunction& image,
                           const TrackOptions& options) try {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  // More than there are cores gain nothing, and a process may have only so many.
  cv::setNumThreads(options.threads == 0 ? -1 : std::min(options.threads, cv::getNumberOfCPUs()));
  TrackedImages result;
  result.sequence = without_frames(images);
  result.sequence.points = options.tracker.corners.count;
  track_all(images, image, options, result);
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

}  // namespace slammot
