// All images of a frame: of camera 0, of the others of its rig, of depths. They come in order, the
// next frame's being read while the caller is at work.
#pragma once

#include <functional>
#include <future>

#include "datasets/sequence/sequence.h"
#include "frontend/image_file.h"

namespace slammot {

struct FrameImages {
  cv::Mat image;                // 8-bit grey
  std::vector<cv::Mat> others;  // as `other_cameras`, of the same size; empty where there is none
  cv::Mat depth;                // empty where there is none
};
using FrameFunction = std::function<FrameImages(std::size_t place)>;

// From the files that a sequence names, which must outlive it.
class FrameFiles {
 public:
  FrameFiles(const Sequence& images, bool mixed_colours);

  // Call it for the places in their order. Throws InputError for the first bad image of the frame.
  FrameImages read(std::size_t place);

  std::optional<std::string> depth_fault() const { return first_.depth_fault(); }

 private:
  const Sequence& images_;
  ImageSource first_;
  std::vector<ImageSource> others_;
};

// Missing files are cheaply found before the first image is decoded. Throws InputError.
void refuse_missing(const Sequence& images);

// A frame's images, or why there are none.
struct Loaded {
  FrameImages images;
  std::optional<InputError> error;
};

class FrameStream {
 public:
  // `images` must outlive it. With one thread nothing is read ahead.
  FrameStream(std::size_t count, const FrameFunction& images, int threads);
  Loaded next();

 private:
  void request();

  std::size_t count_;
  const FrameFunction& images_;
  std::launch policy_;
  std::size_t next_ = 0;
  std::future<Loaded> pending_;  // last: its task ends before what it uses
};

}  // namespace slammot
