#include "apps/support/image_source.h"

#include <fmt/format.h>

#include <algorithm>

#include "datasets/camera/camera_file.h"
#include "datasets/native/native_tables.h"
#include "datasets/readers/image_reader.h"
#include "datasets/readers/plain_images.h"
#include "datasets/sequence/true_poses.h"
#include "datasets/text/text_table.h"
#include "frontend/video_file.h"

namespace slammot {
namespace {

void find_frames(const ImageOptions& options, ImagesToTrack& found) {
  const std::filesystem::path place = options.images;
  if (std::filesystem::is_regular_file(place)) {
    found.sequence = read_video(place, options.rate);
    found.film = [picture = video_images(place)](std::size_t frame) {
      return FrameImages{picture(frame), {}, {}};
    };
    return;
  }
  if (!options.rate || !std::filesystem::is_directory(place)) {
    found.sequence = read_images(place);
    return;
  }
  if (const ImageReaderRow* row = find_image_reader(place)) {
    throw InputError(place, 0,
                     fmt::format("{} states its times itself: --rate is for a plain folder of "
                                 "images or a film",
                                 row->description));
  }
  found.sequence = read_plain_images(place, *options.rate);
  if (const auto fault = numbering_fault(found.sequence.images)) found.warnings.push_back(*fault);
}

// A camera of one's own is that of camera 0: the folder's second one does not go with it. A native
// rig may name the images of camera 0 only.
void find_others(const ImageOptions& options, ImagesToTrack& found) {
  Sequence& sequence = found.sequence;
  const bool is_native_rig = !sequence.other_cameras.empty();
  if (!options.one_camera) add_other_images(sequence);
  if (!options.camera.empty()) sequence.other_images.clear();
  if (!sequence.other_images.empty()) return;
  sequence.other_cameras.clear();
  if (is_native_rig) found.unused.emplace_back("the other cameras of sequence.yaml");
}

bool is_used(const std::string& place, const Sequence& sequence) {
  const auto lies_there = [&](const std::string& image) { return image.starts_with(place + "/"); };
  return lies_there(sequence.images.front()) ||
         std::ranges::any_of(
             sequence.other_images,
             [&](const auto& images) { return std::ranges::any_of(images, lies_there); }) ||
         (place == "depth.txt" && !sequence.depth_images.empty());
}

// So that nobody thinks that two cameras, depth or an IMU were used where they were not.
void find_unused(ImagesToTrack& found) {
  const Sequence& sequence = found.sequence;
  for (const char* place :
       {"depth.txt", "mav0/cam1", "mav0/imu0", "image_0", "image_1", "image_2", "image_3",
        "image_00", "image_01", "image_02", "image_03", "velodyne_points"}) {
    if (!is_used(place, sequence) && std::filesystem::exists(sequence.folder / place)) {
      found.unused.push_back(place);
    }
  }
}

void find_camera(const ImageOptions& options, ImagesToTrack& found) {
  Sequence& sequence = found.sequence;
  found.camera = "as the folder has it";
  if (!options.camera.empty()) {
    CameraFile file = read_camera_file(options.camera, read_text_file(options.camera));
    sequence.camera = file.camera;
    sequence.camera_assumed = false;
    found.camera = fmt::format("{}, a file of {}", options.camera, file.form);
  } else if (found.film || options.rate) {
    throw InputError(options.images, 0, "nobody states the camera: --camera FILE.yaml");
  } else if (sequence.camera_assumed) {
    found.camera = "assumed";
    found.warnings.push_back(fmt::format(
        "nobody states the camera: {} px of {} x {} px is an assumption, which --camera "
        "FILE.yaml replaces",
        sequence.camera.fx, sequence.camera.width, sequence.camera.height));
  }
}

void find_truth(const std::filesystem::path& file, Sequence& sequence) {
  const std::vector<TimedPose> poses = read_poses(file, read_text_file(file));
  sequence.truth = true_cameras(poses, sequence.frames);
  for (const auto& truth : sequence.truth) {
    if (truth) return;
  }
  const auto& frames = sequence.frames;
  throw InputError(file, 0,
                   fmt::format("no frame, of {} to {} s, lies between two of its poses",
                               frames.front().timestamp, frames.back().timestamp));
}

}  // namespace

void add_image_options(CLI::App& command, ImageOptions& options) {
  command
      .add_option("IMAGES", options.images,
                  "folder with the images, see `list readers`; a plain folder of images or a film")
      ->required();
  command
      .add_option("--camera", options.camera,
                  "the camera, instead of the sequence's own: of slammot, kalibr, EuRoC, OpenCV, "
                  "ROS or ORB-SLAM")
      ->type_name("FILE.yaml");
  command
      .add_option("--rate", options.rate,
                  "images a second, of a plain folder; of a film instead of its own times")
      ->type_name("HZ")
      ->check(CLI::Range(1e-3, 1e6));
  command.add_flag("--one-camera", options.one_camera,
                   "take the first camera's images only, where the folder has a second one or "
                   "depth images");
  command
      .add_option("--truth", options.truth,
                  "true poses, as in groundtruth.tum, instead of the sequence's own")
      ->type_name("FILE");
}

ImagesToTrack find_images(const ImageOptions& options) {
  ImagesToTrack found;
  find_frames(options, found);
  if (!found.film) {
    find_others(options, found);
    find_unused(found);
  }
  find_camera(options, found);
  if (!options.truth.empty()) find_truth(options.truth, found.sequence);
  return found;
}

}  // namespace slammot
