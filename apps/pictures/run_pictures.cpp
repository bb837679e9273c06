#include "apps/pictures/run_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "eval/output/run_files.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

std::map<int, std::vector<LandmarkEstimate>> landmarks_by_frame(const Path& file) {
  std::map<int, std::vector<LandmarkEstimate>> by_frame;
  std::map<int, int> rows;
  bool several = false;
  for (const LandmarkRecord& record : read_landmark_rows(file)) {
    by_frame[record.frame].push_back(record.estimate);
    several |= ++rows[record.estimate.track] > 1;
  }
  if (!several) throw InputError(file, 0, "only final landmarks; run with --landmarks every-frame");
  for (auto& [frame, landmarks] : by_frame) {
    std::ranges::sort(landmarks, {}, &LandmarkEstimate::track);
  }
  return by_frame;
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

template <typename Row>
std::vector<Row> of_frame(const std::map<int, std::vector<Row>>& rows, int frame) {
  const auto found = rows.find(frame);
  return found == rows.end() ? std::vector<Row>{} : found->second;
}

template <typename Row>
void take_camera(int camera, const std::vector<Row>& from, std::vector<Row>& to) {
  std::ranges::copy_if(from, std::back_inserter(to),
                       [&](const Row& row) { return row.camera == camera; });
}

MapFrame map_of(const RunResult& run, const std::vector<Eigen::Vector3d>& path) {
  std::vector<Eigen::Vector3d> points;
  for (const LandmarkRecord& last : run.landmarks) {
    const bool decided = last.estimate.label != Label::kUnknown;
    if (decided && last.estimate.position.allFinite()) points.push_back(last.estimate.position);
  }
  return map_frame(run.filtered.front().state, path, points);
}

}  // namespace

RunPictures::RunPictures(const Path& run, const Sequence& sequence)
    : folder_(run), sequence_(sequence) {
  if (sequence.images.empty()) throw InputError(sequence.folder, 0, "frames.csv names no images");
  run_ = read_run(run);
  if (run_.run.filtered.empty()) throw InputError(run, 0, "the run has no frame");
  landmarks_ = landmarks_by_frame(run / run_files::kLandmarks);
  for (const auto& [frame, prediction] : read_prediction_rows(run / run_files::kPredictions)) {
    predictions_[frame].push_back(prediction);
  }
  for (const CameraEstimate& camera : run_.run.filtered) {
    const size_t place = frame_at(sequence, camera.timestamp);
    places_.push_back(place);
    path_.push_back(camera.state.position);
    if (place < sequence.truth.size() && sequence.truth[place]) {
      truth_.push_back(sequence.truth[place]->position);
    }
    truths_.push_back(truth_.size());
  }
  map_ = map_of(run_.run, path_);
}

RunFrame RunPictures::operator[](int k) const {
  const auto at = static_cast<size_t>(k);
  const Frame& frame = sequence_.frames[places_[at]];
  return {&frame, frame.timestamp - sequence_.frames.front().timestamp, images_of(places_[at]),
          PictureState{run_.run.filtered[at], of_frame(landmarks_, frame.index), views_of(frame),
                       std::span(path_).first(at + 1), std::span(truth_).first(truths_[at])}};
}

std::vector<Path> RunPictures::images_of(size_t place) const {
  std::vector<Path> images{sequence_.folder / sequence_.images[place]};
  for (const auto& names : sequence_.other_images) {
    images.push_back(names[place].empty() ? Path() : sequence_.folder / names[place]);
  }
  return images;
}

std::vector<CameraView> RunPictures::views_of(const Frame& frame) const {
  const std::vector<Prediction> predictions = of_frame(predictions_, frame.index);
  std::vector<CameraView> views(1 + sequence_.other_cameras.size());
  views[0].observations = frame.observations;
  for (int camera = 0; CameraView & view : views) {
    take_camera(camera, predictions, view.predictions);
    if (camera > 0) take_camera(camera, frame.other_views, view.observations);
    ++camera;
  }
  return views;
}

int RunPictures::with_index(int frame) const {
  for (int k = 0; k < size(); ++k) {
    if (sequence_.frames[places_[static_cast<size_t>(k)]].index == frame) return k;
  }
  throw InputError(folder_, 0, fmt::format("the run has no frame {}", frame));
}

double RunPictures::rate() const {
  const auto count = static_cast<double>(sequence_.frames.size());
  const double time = sequence_.frames.back().timestamp - sequence_.frames.front().timestamp;
  return time > 0.0 ? std::clamp((count - 1.0) / time, 1.0, 60.0) : 10.0;
}

}  // namespace slammot
