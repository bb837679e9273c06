// slammot track IMAGES: from images to a native sequence with measurements.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "apps/commands.h"
#include "apps/support/command_line.h"
#include "apps/support/image_source.h"
#include "apps/support/progress.h"
#include "apps/support/usage.h"
#include "apps/support/writable.h"
#include "apps/track/track_statements.h"
#include "datasets/native/native_settings.h"
#include "datasets/native/native_writer.h"
#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
#include "eval/provenance/provenance.h"
#include "frontend/masks/mask_odds.h"
#include "frontend/rendering/render.h"
#include "frontend/tracking/track_images.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

constexpr char kCommon[] = "common", kAlignment[] = "alignment";

struct TrackArguments {
  ImageOptions source;
  std::string output;
  std::string chessboard;
  TrackStatements stated;
  std::string noise = kCommon;
  bool force = false;
  TrackOptions options;
};

// As seen from the folder that is written.
void relocate_images(const Path& output, Sequence& sequence) {
  // Absolute first: what does not exist yet would stay relative.
  const auto whole = [](const Path& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path));
  };
  const Path from = whole(sequence.folder), to = whole(output);
  const Path step = from.lexically_relative(to);
  const auto relocate = [&](std::vector<std::string>& images) {
    for (std::string& image : images) {
      if (!image.empty()) image = (step / image).lexically_normal().string();
    }
  };
  relocate(sequence.images);
  std::ranges::for_each(sequence.other_images, relocate);
}

std::string noise_text(const TrackedImages& tracked, NoiseModel model) {
  if (!tracked.noise) {
    return fmt::format("{} px as stated, for all measurements; too few tracks to measure it",
                       tracked.sequence.pixel_sigma);
  }
  if (model == NoiseModel::kAlignment) {
    return fmt::format(
        "{:.4g} px, the median of all measurements, by alignment; common to all is {:.4g} px, "
        "what the median Sampson distance to a fundamental matrix has beside that, median over {} "
        "pairs of frames {} apart",
        tracked.sequence.pixel_sigma, tracked.noise->sigma, tracked.noise->pairs,
        tracked.noise->lag);
  }
  return fmt::format(
      "{:.4g} px as stated; measured {:.4g} px, q75 of the Sampson distance to a fundamental "
      "matrix / 1.150, median over {} pairs of frames {} apart (quartiles {:.3g} and {:.3g} px)",
      tracked.sequence.pixel_sigma, tracked.noise->sigma, tracked.noise->pairs, tracked.noise->lag,
      tracked.noise->lower, tracked.noise->upper);
}

std::string health_text(const TrackHealth& health) {
  return fmt::format(
      "{} tracks from an image to the next (median), {:.1f}% lost there; a track lives {} images "
      "(median)",
      health.followed, 100.0 * health.lost, health.life);
}

std::string camera_text(const Camera& camera, const std::string& source) {
  return fmt::format("{} {} x {}, fx {}, fy {}, cx {}, cy {}, distortion [{}] ({})",
                     lens_name(camera.lens), camera.width, camera.height, camera.fx, camera.fy,
                     camera.cx, camera.cy, fmt::join(lens_distortion(camera.lens), ", "), source);
}

// How the measurements were made: track.yaml, for people.
void add_description(const TrackArguments& arguments, const TrackedImages& tracked,
                     const std::vector<std::string>& beside, OutputFiles& files) {
  std::string warnings;
  for (const std::string& warning : tracked.warnings) {
    warnings += fmt::format("{}\"{}\"", warnings.empty() ? "" : ", ", printable(warning));
  }
  const std::string beside_text =
      beside.empty() ? "" : fmt::format("beside: \"{}\"\n", fmt::join(beside, "; "));
  files.write(Path(arguments.output) / kTrackingOutput.mark,
              fmt::format("version: \"{}\"\ncommand: \"{}\"\nframes: {}\nframes_skipped: {}\n"
                          "tracks: {}\nfollowed: \"{}\"\n{}pixel_sigma: \"{}\"\nwarnings: [{}]\n",
                          version_text(), command_line(), tracked.sequence.frames.size(),
                          tracked.skipped.size(), tracked.tracks, health_text(tracked.health),
                          beside_text, noise_text(tracked, arguments.options.noise), warnings));
}

TrackedImages track(const ImagesToTrack& images, const TrackOptions& options) {
  TrackedImages tracked = images.film ? track_images(images.sequence, images.film, options)
                                      : track_images(images.sequence, options);
  auto& warnings = tracked.warnings;
  warnings.insert(warnings.begin(), images.warnings.begin(), images.warnings.end());
  const size_t frames = tracked.sequence.frames.size();
  // Of two frames the first may be without measurements, by --moving-start.
  if (tracked.tracks == 0 || (tracked.health.most == 0 && frames > 2)) {
    throw InputError(images.sequence.folder, 0,
                     fmt::format("nothing was tracked: {} corners were found in {} images, none of "
                                 "them in two{}{}",
                                 tracked.tracks, frames, warnings.empty() ? "" : "; ",
                                 fmt::join(warnings, "; ")));
  }
  for (std::string& fault : health_faults(tracked.health)) warnings.push_back(std::move(fault));
  return tracked;
}

void print_summary(const ImagesToTrack& images, const TrackedImages& tracked,
                   const std::vector<std::string>& beside, double seconds,
                   const TrackArguments& arguments) {
  const Sequence& sequence = tracked.sequence;
  for (const std::string& reason : tracked.skipped) fmt::print("skipped: {}\n", reason);
  const auto frames = static_cast<double>(sequence.frames.size());
  fmt::print("{}: {} frames, {} skipped, {} tracks, {:.1f} frames/s\ncamera {}\n", sequence.name,
             frames, tracked.skipped.size(), tracked.tracks, frames / seconds,
             camera_text(sequence.camera, images.camera));
  for (const std::string& text : beside) fmt::print("{}\n", text);
  if (!images.unused.empty()) {
    fmt::print("not used {}: {} images are{}\n", fmt::join(images.unused, ", "),
               sequence.other_cameras.empty() ? "one camera's" : "two cameras'",
               images.sequence.depth_images.empty() ? "" : ", and depths");
  }
  fmt::print("followed {}\npixel_sigma {}\n{}\n", health_text(tracked.health),
             noise_text(tracked, arguments.options.noise), arguments.output);
  for (const std::string& warning : tracked.warnings) {
    fmt::print(stderr, "slammot: warning: {}\n", printable(warning));
  }
}

int execute(TrackArguments arguments) {
  require_velocity(arguments.stated);
  if (!arguments.chessboard.empty()) {
    arguments.options.chessboard = parse_chessboard(arguments.chessboard);
  }
  if (arguments.noise == kAlignment) arguments.options.noise = NoiseModel::kAlignment;
  const ImagesToTrack images = find_images(arguments.source);
  std::vector<Path> masks;  // before hours of tracking
  if (!arguments.stated.masks.empty()) masks = find_masks(arguments.stated.masks, images.sequence);
  require_output(arguments.output, kSequenceOutput, arguments.force, arguments.source.images);
  require_own_files(arguments.output);
  require_own_mark(arguments.output, kTrackingOutput);
  require_writable_folder(arguments.output);
  Progress progress;
  arguments.options.progress = [&](int done, int total) { progress.show("track", done, total); };
  const auto start = std::chrono::steady_clock::now();
  TrackedImages tracked = track(images, arguments.options);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  progress.clear();
  state_velocity(arguments.stated, tracked.sequence);
  if (!arguments.stated.known.empty()) state_known(arguments.stated.known, tracked.sequence);
  add_room_truth(arguments.source.images, tracked.sequence);
  auto beside = beside_texts(images.sequence, tracked.sequence.frames);
  if (!masks.empty()) beside.push_back(state_odds(masks, images.sequence, tracked));
  relocate_images(arguments.output, tracked.sequence);
  OutputFiles files;
  add_native(tracked.sequence, arguments.output, NativeParts::kAll, files);
  add_description(arguments, tracked, beside, files);
  files.put_in_place();
  print_summary(images, tracked, beside, seconds, arguments);
  return 0;
}

}  // namespace

void add_track(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<TrackArguments>();
  TrackOptions& options = arguments->options;
  CLI::App* command =
      app.add_subcommand("track", "images to measurements: corners found and followed");
  add_image_options(*command, arguments->source);
  command->add_option("--output", arguments->output, "folder to write")
      ->type_name("SEQUENCE")
      ->required();
  command
      ->add_option("--chessboard", arguments->chessboard,
                   "board in the first image: inner corners and pitch [m]; fixes the scale")
      ->type_name("COLSxROWS,PITCH");
  command
      ->add_option("--velocity-sigma", arguments->stated.velocity_sigma,
                   "state the first velocity as the truth has it, with this sigma [m/s]; fixes the "
                   "scale as an odometer does")
      ->check(CLI::PositiveNumber)
      ->excludes("--chessboard");
  command
      ->add_option("--initial-velocity", arguments->stated.initial_velocity,
                   fmt::format("state this first velocity in W [m/s], with --velocity-sigma or {}",
                               kVelocitySigma))
      ->type_name("VX,VY,VZ");
  command
      ->add_option("--known", arguments->stated.known,
                   "landmarks known beforehand, as in known.csv: track,x,y,z,sigma; tracks repeat")
      ->type_name("FILE");
  command
      ->add_option(
          "--masks", arguments->stated.masks,
          "an image for each frame, of its name or in order: grey 0 rests, 255 moves; into "
          "priors.csv")
      ->type_name("FOLDER")
      ->check([](const std::string& folder) { return folder.empty() ? "names no folder" : ""; });
  command->add_flag("--force", arguments->force, kForceHelp);
  command->add_option("--points", options.tracker.corners.count, "corners looked for in an image")
      ->check(CLI::Range(8, 10000))
      ->capture_default_str();
  command
      ->add_option(
          "--noise", arguments->noise,
          "common: one sigma for all measurements; alignment: each its own, by how well its "
          "patch fits")
      ->check(CLI::IsMember({kCommon, kAlignment}))
      ->capture_default_str();
  command->add_flag("--skip-bad-frames", options.skip_bad_frames,
                    "leave out images that cannot be used, and count them");
  command->add_flag("--moving-start", options.moving_start,
                    "the first image may show what moves: no measurements of it but of the board");
  command->add_flag("--mixed-colours", options.mixed_colours,
                    "take grey images among colour ones, as writers make of those without colour");
  command->add_option("--threads", options.threads, "0: as many as there are cores")
      ->check(whole_number_from(0))
      ->capture_default_str();
  command->callback([arguments, &exit_code] { exit_code = execute(*arguments); });
}

}  // namespace slammot
