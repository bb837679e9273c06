#include "apps/pictures/draw_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/pictures/frame_json.h"
#include "apps/pictures/run_pictures.h"
#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
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
  for (int k = 0; k < pictures.size(); ++k) {
    const RunFrame frame = pictures[k];
    film.add(frame.frame->index, draw_page(decode_image(frame.image), frame.state, pictures.map(),
                                           caption_of(pictures, frame)));
    if (progress) progress(k + 1, pictures.size());
  }
  film.finish();
  return pictures.size();
} catch (const cv::Exception& error) {
  throw std::runtime_error(fmt::format("OpenCV: {}", error.err));
}

int draw_figures(const Path& run, const Sequence& sequence, const Path& output,
                 const std::vector<int>& frames) try {
  const RunPictures pictures = pictures_of(run, sequence);
  std::vector<RunFrame> drawn;
  for (const int frame : frames) {
    drawn.push_back(pictures[pictures.with_index(frame)]);
    decode_image(drawn.back().image);  // refuses what cannot be used
  }
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
