#include "datasets/native/native_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "datasets/native/native_format.h"
#include "datasets/native/native_settings.h"
#include "datasets/native/native_tables.h"
#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"

namespace slammot {
namespace {

using Text = fmt::memory_buffer;
using Texts = std::map<std::string_view, std::string>;  // by file name

// "{}" of a double is the shortest text that reads back to the same bits.
template <typename... Args>
void put(Text& text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

std::string joined(std::span<const double> numbers, std::string_view separator) {
  return fmt::format("{}", fmt::join(numbers.begin(), numbers.end(), separator));
}

std::string joined(const Eigen::Vector3d& v, std::string_view separator) {
  return joined(std::span<const double>(v.data(), 3), separator);
}

std::string joined(const Eigen::Quaterniond& q, std::string_view separator) {
  return joined(std::span<const double>(q.coeffs().data(), 4), separator);  // x y z w
}

// A YAML string in double quotes.
std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

void put_camera(Text& text, const Camera& c) {
  put(text, "{{model: {}, width: {}, height: {}, fx: {}, fy: {}, cx: {}, cy: {}", lens_name(c.lens),
      c.width, c.height, c.fx, c.fy, c.cx, c.cy);
  put(text, ", distortion: [{}]", joined(lens_distortion(c.lens), ", "));
}

void put_cameras(Text& text, const Sequence& s) {
  put(text, "{}", s.other_cameras.empty() ? "camera: " : "cameras:\n  - ");
  put_camera(text, s.camera);
  put(text, "}}\n");
  for (const MountedCamera& other : s.other_cameras) {
    put(text, "  - ");
    put_camera(text, other.lens);
    put(text, ", T_C0_C: {{position: [{}], quaternion: [{}]}}}}\n", joined(other.t, ", "),
        joined(other.R, ", "));
  }
}

Text settings_text(const Sequence& s) {
  Text text;
  put(text, "format: {}\nname: {}\n", native::kFormat, quoted(s.name));
  put_cameras(text, s);
  put(text, "pixel_sigma: {}\n", s.pixel_sigma);
  if (s.points) put(text, "points: {}\n", *s.points);
  if (s.motion) {
    put(text, "motion: {{acceleration: {}, angular_acceleration: {}}}\n", s.motion->acceleration,
        s.motion->angular_acceleration);
  }
  if (s.prior) {
    put(text, "prior: {{inverse_depth: {}, inverse_depth_sigma: {}", s.prior->inverse_depth,
        s.prior->inverse_depth_sigma);
    if (s.prior->mean_sigma > 0.0) put(text, ", mean_sigma: {}", s.prior->mean_sigma);
    put(text, ", max_speed: {}", s.prior->max_speed);
    put(text, ", acceleration: {}", s.prior->acceleration);
    if (s.prior->jerk != LandmarkPrior{}.jerk) put(text, ", jerk: {}", s.prior->jerk);
    put(text, "}}\n");
  }
  return text;
}

Text frames_text(const Sequence& s) {
  Text text;
  const bool images = !s.images.empty();
  put(text, "{}\n", images ? native::kFramesWithImagesHeader : native::kFramesHeader);
  for (size_t i = 0; i < s.frames.size(); ++i) {
    if (static_cast<size_t>(s.frames[i].index) != i) {
      throw std::invalid_argument("only a sequence of frames 0, 1, 2... can be written");
    }
    put(text, "{},{}", i, s.frames[i].timestamp);
    put(text, "{}{}\n", images ? "," : "", images ? s.images[i] : std::string());
  }
  return text;
}

Text other_images_text(const Sequence& s) {
  Text text;
  put(text, "{}\n", native::kOtherImagesHeader);
  for (size_t i = 0; i < s.frames.size(); ++i) {
    for (size_t c = 0; c < s.other_images.size(); ++c) {
      const std::string& image = s.other_images[c][i];
      if (!image.empty()) put(text, "{},{},{}\n", i, c + 1, image);
    }
  }
  return text;
}

// Whether any measurement has something that needs a column of its own.
bool any_of(const Sequence& s, bool (*has)(const Observation&)) {
  return std::ranges::any_of(s.frames, [has](const Frame& frame) {
    return std::ranges::any_of(frame.observations, has) ||
           std::ranges::any_of(frame.other_views, has);
  });
}

Text observations_text(const Sequence& s) {
  const bool differ = any_of(s, [](const Observation& z) { return z.relative_sigma != 1.0; });
  const bool are_many = !s.other_cameras.empty();
  const bool have_depths = any_of(s, [](const Observation& z) { return z.has_depth(); });
  Text text;
  put(text, "{}", native::kObservationsHeader);
  if (differ) put(text, ",{}", native::kSigmaColumn);
  if (are_many) put(text, ",{}", native::kCameraColumn);
  if (have_depths) put(text, ",{}", native::kDepthColumns);
  put(text, "\n");
  for (const Frame& frame : s.frames) {
    for (const auto* of : {&frame.observations, &frame.other_views}) {
      for (const Observation& z : *of) {
        put(text, "{},{},{},{}", frame.index, z.track, z.pixel.x(), z.pixel.y());
        if (differ) put(text, ",{}", z.relative_sigma);
        if (are_many) put(text, ",{}", z.camera);
        if (have_depths && z.has_depth()) put(text, ",{},{}", z.depth, z.depth_sigma);
        if (have_depths && !z.has_depth()) put(text, ",,");
        put(text, "\n");
      }
    }
  }
  return text;
}

Text poses_text(const Sequence& s) {
  Text text;
  for (size_t i = 0; i < s.truth.size(); ++i) {
    if (!s.truth[i]) continue;
    put(text, "{} {} {}\n", s.frames[i].timestamp, joined(s.truth[i]->position, " "),
        joined(s.truth[i]->orientation, " "));
  }
  return text;
}

Text landmarks_text(const Sequence& s) {
  Text text;
  put(text, "{}\n", native::kLandmarksHeader);
  for (const auto& [track, landmark] : s.landmarks) {
    for (const auto& [frame, point] : landmark.by_frame) {
      put(text, "{},{},{},{},{}\n", track, frame, to_string(landmark.label),
          joined(point.position, ","), joined(point.velocity, ","));
    }
  }
  return text;
}

Text known_text(const Sequence& s) {
  Text text;
  put(text, "{}\n", native::kKnownHeader);
  for (const KnownLandmark& known : s.known) {
    put(text, "{},{},{}\n", known.track, joined(known.position, ","), known.sigma);
  }
  return text;
}

Text priors_text(const Sequence& s) {
  Text text;
  put(text, "{}\n", native::kPriorsHeader);
  for (const auto& [track, p] : s.p_static) put(text, "{},{}\n", track, p);
  return text;
}

Text initial_text(const InitialCamera& initial) {
  Text text;
  const CameraState& x = initial.state;
  put(text, "position: [{}]\nquaternion: [{}]\n", joined(x.position, ", "),
      joined(x.orientation, ", "));
  put(text, "velocity: [{}]\nangular_velocity: [{}]\n", joined(x.velocity, ", "),
      joined(x.angular_velocity, ", "));
  put(text, "sigma: {{position: {}, rotation: {}, velocity: {}, angular_velocity: {}}}\n",
      initial.position_sigma, initial.rotation_sigma, initial.velocity_sigma,
      initial.angular_velocity_sigma);
  return text;
}

Texts texts_of(const Sequence& s, NativeParts parts) {
  Texts texts;
  const auto add = [&](std::string_view name, const Text& text) {
    texts[name] = fmt::to_string(text);
  };
  add(native::kFrames, frames_text(s));
  if (!s.other_images.empty()) add(native::kOtherImages, other_images_text(s));
  if (parts == NativeParts::kAll) add(native::kObservations, observations_text(s));
  if (!s.truth.empty()) add(native::kGroundTruth, poses_text(s));
  if (!s.landmarks.empty()) add(native::kLandmarks, landmarks_text(s));
  if (!s.known.empty()) add(native::kKnown, known_text(s));
  if (!s.p_static.empty()) add(native::kPriors, priors_text(s));
  if (s.initial) add(native::kInitial, initial_text(*s.initial));
  Text head;
  put(head, "{}: sequence.yaml", kSequenceOutput.begins);
  for (const auto& [name, text] : texts) put(head, " {}", name);
  texts[native::kSettings] = fmt::to_string(head) + '\n' + fmt::to_string(settings_text(s));
  return texts;
}

// Nothing is written that the reader would refuse, and no name that a line cannot hold.
void require_readable(const std::filesystem::path& folder, const Texts& texts,
                      const Sequence& sequence) try {
  Sequence read;
  read_settings(folder / native::kSettings, texts.at(native::kSettings), read);
  read_frames(folder / native::kFrames, texts.at(native::kFrames), read);
  const auto visit = [&](std::string_view name, const auto& reader) {
    if (texts.contains(name)) reader(folder / name, texts.at(name));
  };
  using File = const std::filesystem::path&;
  using Content = const std::string&;
  visit(native::kOtherImages,
        [&](File file, Content text) { read_other_images(file, text, read); });
  visit(native::kObservations, [&](File file, Content text) {
    read_observations(file, text, {read.camera, read.other_cameras}, read.frames);
  });
  visit(native::kGroundTruth, [](File file, Content text) { read_poses(file, text); });
  visit(native::kLandmarks,
        [&](File file, Content text) { read_landmarks(file, text, read.frames.size()); });
  visit(native::kKnown, [](File file, Content text) { read_known(file, text); });
  visit(native::kPriors, [](File file, Content text) { read_priors(file, text); });
  visit(native::kInitial, [](File file, Content text) { read_initial(file, text); });
  if (read.name != sequence.name || read.images != sequence.images ||
      read.other_images != sequence.other_images) {
    throw InputError(folder, 0, "a name contains a control character");
  }
} catch (const InputError& error) {
  throw std::invalid_argument(std::string("cannot be written: ") + error.what());
}

}  // namespace

void require_own_files(const std::filesystem::path& folder) {
  std::string head;
  std::getline(std::ifstream(folder / native::kSettings), head);
  if (head == kSequenceOutput.begins) return;  // of an earlier build, which did not name them
  const auto replaced = being_replaced(folder);
  for (const auto name : native::kFileNames) {
    if (!std::filesystem::exists(folder / name) || replaced.contains(folder / name)) continue;
    if ((head + ' ').find(fmt::format(" {} ", name)) != std::string::npos) continue;
    throw std::invalid_argument(
        (folder / name).string() +
        ": was not written by this program, and is not replaced or removed");
  }
}

void add_native(const Sequence& sequence, const std::filesystem::path& folder, NativeParts parts,
                OutputFiles& files) {
  const Texts texts = texts_of(sequence, parts);
  require_readable(folder, texts, sequence);
  require_own_files(folder);
  std::filesystem::create_directories(folder);
  for (const auto name : native::kFileNames) {
    if (texts.contains(name)) {
      files.write(folder / name, texts.at(name));
    } else {
      files.leave_out(folder / name);
    }
  }
  // They describe the sequence that was here.
  for (const OutputKind& kind : {kTrackingOutput, kRoomOutput}) {
    if (is_own(folder, kind)) files.leave_out(folder / kind.mark);
  }
}

void write_native(const Sequence& sequence, const std::filesystem::path& folder,
                  NativeParts parts) {
  OutputFiles files;
  add_native(sequence, folder, parts, files);
  files.put_in_place();
}

}  // namespace slammot
