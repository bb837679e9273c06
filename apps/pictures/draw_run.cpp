#include "apps/pictures/draw_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/pictures/frame_json.h"
#include "apps/pictures/run_pictures.h"
#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
#include "datasets/text/printable.h"
#include "eval/output/run_files.h"
#include "eval/python/report_generator.h"
#include "frontend/image_file.h"
#include "frontend/rendering/film.h"
#include "frontend/rendering/picture.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

RunPictures pictures_of(const Path& run, const Sequence& sequence) {
  RunPictures pictures(run, sequence);
  if (!pictures.has_predictions()) {
    fmt::print(stderr,
               "slammot: warning: {}: no predictions (of an estimator that states none, or of an "
               "earlier build): no ellipses in the images\n",
               (run / run_files::kPredictions).string());
  }
  return pictures;
}

// What is wrong with an image of another camera is said once, and the picture made without it.
class OtherImages {
 public:
  cv::Mat decode(const Path& file, const cv::Size& size) {
    try {
      return decode_image(file, size);
    } catch (const InputError& error) {
      if (unusable_++ == 0) first_ = error.what();
      return {};
    }
  }
  void warn() const {
    if (unusable_ == 0) return;
    fmt::print(stderr,
               "slammot: warning: {} images of other cameras cannot be used; the first: {}\n",
               unusable_, printable(first_));
  }

 private:
  int unusable_ = 0;
  std::string first_;
};

// Of all cameras; forgets the files of those that are not there.
std::vector<cv::Mat> decode_images(RunFrame& frame, OtherImages& others) {
  std::vector<cv::Mat> images{decode_image(frame.images.front())};
  for (size_t camera = 1; camera < frame.images.size(); ++camera) {
    Path& file = frame.images[camera];
    images.push_back(file.empty() ? cv::Mat() : others.decode(file, images.front().size()));
    if (images.back().empty()) file.clear();
  }
  return images;
}

std::string caption_of(const RunPictures& pictures, const RunFrame& frame) {
  const auto measured = std::ranges::count_if(
      frame.state.landmarks,
      [&](const LandmarkEstimate& landmark) { return frame.state.is_measured(landmark.track); });
  return fmt::format("{}, frame {}, {:.2f} s: {} landmarks, {} of them measured",
                     pictures.estimator(), frame.frame->index, frame.time,
                     frame.state.landmarks.size(), measured);
}

}  // namespace

int draw_run(const Path& run, const Sequence& sequence, const Path& output,
             const std::function<void(int done, int total)>& progress) try {
  const RunPictures pictures = pictures_of(run, sequence);
  Film film(output, pictures.size(), pictures.rate());
  OtherImages others;
  for (int k = 0; k < pictures.size(); ++k) {
    RunFrame frame = pictures[k];
    film.add(frame.frame->index, draw_page(decode_images(frame, others), frame.state,
                                           pictures.map(), caption_of(pictures, frame)));
    if (progress) progress(k + 1, pictures.size());
  }
  film.finish();
  others.warn();
  return pictures.size();
} catch (const cv::Exception& error) {
  throw std::runtime_error(fmt::format("OpenCV: {}", error.err));
}

int draw_figures(const Path& run, const Sequence& sequence, const Path& output,
                 const std::vector<int>& frames) try {
  const RunPictures pictures = pictures_of(run, sequence);
  OtherImages others;
  std::vector<RunFrame> drawn;
  for (const int frame : frames) {
    drawn.push_back(pictures[pictures.with_index(frame)]);
    decode_images(drawn.back(), others);  // refuses what cannot be used
  }
  others.warn();
  std::filesystem::create_directories(output);
  write_file(output / kPicturesOutput.mark, std::string(kPicturesOutput.begins) + "\n");
  for (const RunFrame& frame : drawn) {
    const Path data = output / fmt::format("frame_{:06}.json", frame.frame->index);
    write_file(data, frame_json(pictures, frame).dump(1) + "\n");
    if (const int code = make_frame_figure(data); code != 0) return code;
    fmt::print("{}\n", Path(data).replace_extension(".pdf").string());
  }
  return 0;
} catch (const cv::Exception& error) {
  throw std::runtime_error(fmt::format("OpenCV: {}", error.err));
}

}  // namespace slammot
