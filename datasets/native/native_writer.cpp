#include "datasets/native/native_writer.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>

#include "datasets/native/native_format.h"

namespace slammot {
namespace {

using Text = fmt::memory_buffer;

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

Text settings_text(const Sequence& s) {
  Text text;
  put(text, "format: {}\nname: {}\n", native::kFormat, quoted(s.name));
  const Camera& c = s.camera;
  put(text, "camera: {{model: {}, width: {}, height: {}, fx: {}, fy: {}, cx: {}, cy: {}",
      lens_name(c.lens), c.width, c.height, c.fx, c.fy, c.cx, c.cy);
  put(text, ", distortion: [{}]}}\n", joined(lens_distortion(c.lens), ", "));
  put(text, "pixel_sigma: {}\n", s.pixel_sigma);
  if (s.motion) {
    put(text, "motion: {{acceleration: {}, angular_acceleration: {}}}\n", s.motion->acceleration,
        s.motion->angular_acceleration);
  }
  if (s.prior) {
    put(text, "prior: {{inverse_depth: {}, inverse_depth_sigma: {}, max_speed: {}",
        s.prior->inverse_depth, s.prior->inverse_depth_sigma, s.prior->max_speed);
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

Text observations_text(const Sequence& s) {
  Text text;
  put(text, "{}\n", native::kObservationsHeader);
  for (const Frame& frame : s.frames) {
    for (const Observation& z : frame.observations) {
      put(text, "{},{},{},{}\n", frame.index, z.track, z.pixel.x(), z.pixel.y());
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

void write_file(const std::filesystem::path& file, const Text& text) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace

void write_native(const Sequence& sequence, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const auto write = [&](std::string_view name, const Text& text) {
    write_file(folder / name, text);
  };
  write(native::kSettings, settings_text(sequence));
  write(native::kFrames, frames_text(sequence));
  write(native::kObservations, observations_text(sequence));
  for (const auto name :
       {native::kGroundTruth, native::kLandmarks, native::kKnown, native::kInitial}) {
    std::filesystem::remove(folder / name);
  }
  if (!sequence.truth.empty()) write(native::kGroundTruth, poses_text(sequence));
  if (!sequence.landmarks.empty()) write(native::kLandmarks, landmarks_text(sequence));
  if (!sequence.known.empty()) write(native::kKnown, known_text(sequence));
  if (sequence.initial) write(native::kInitial, initial_text(*sequence.initial));
}

}  // namespace slammot
