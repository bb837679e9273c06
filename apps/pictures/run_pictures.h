// A stored run whose landmarks.csv has every frame, beside the images of its sequence: what is
// drawn of each of its frames.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "datasets/sequence/sequence.h"
#include "eval/output/run_reader.h"
#include "frontend/rendering/map_view.h"
#include "frontend/rendering/picture_state.h"

namespace slammot {

struct RunFrame {
  const Frame* frame = nullptr;
  double time = 0.0;                          // since the sequence's first frame [s]
  std::vector<std::filesystem::path> images;  // of camera 0 and on; empty where a frame has none
  PictureState state;
};

class RunPictures {
 public:
  // Throws InputError if the sequence names no images, or if the run has no frames, or not the
  // landmarks of each. `sequence` must outlive it.
  RunPictures(const std::filesystem::path& run, const Sequence& sequence);

  int size() const { return static_cast<int>(run_.run.filtered.size()); }
  RunFrame operator[](int k) const;
  // Which has this number; throws InputError if there is none.
  int with_index(int frame) const;

  bool has_predictions() const { return !predictions_.empty(); }
  const std::string& estimator() const { return run_.estimator; }
  const Camera& camera() const { return sequence_.camera; }
  const MapFrame& map() const { return map_; }
  double rate() const;  // of a film [Hz]

 private:
  std::vector<std::filesystem::path> images_of(size_t place) const;
  std::vector<CameraView> views_of(const Frame& frame) const;

  std::filesystem::path folder_;
  const Sequence& sequence_;
  StoredRun run_;
  std::map<int, std::vector<LandmarkEstimate>> landmarks_;  // by frame
  std::map<int, std::vector<Prediction>> predictions_;      // likewise
  std::vector<size_t> places_;                              // in the sequence, of each frame
  std::vector<Eigen::Vector3d> path_, truth_;
  std::vector<size_t> truths_;  // how many of truth_ there are up to each frame
  MapFrame map_;
};

}  // namespace slammot
