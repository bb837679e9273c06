// The sequence that a room makes: folder, statements and truth.
#include <fmt/format.h>

#include "datasets/native/native_writer.h"
#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
#include "datasets/simulation/scene/known_landmarks.h"
#include "datasets/simulation/scene/statements.h"
#include "datasets/text/text_table.h"
#include "datasets/text/yaml_map.h"
#include "frontend/codecs/codecs.h"
#include "frontend/rendering/render.h"

namespace slammot {
namespace {

// Of camera 0 and of the one beside it.
constexpr const char* kImages[] = {"images", "images_1"};

std::string image_name(int camera, int frame) {
  return fmt::format("{}/{:06}.png", kImages[camera], frame);
}

// Of what the camera sees, on a coarse grid over image and time.
LandmarkPrior seen_depths(const Room& room, const RoomOptions& options) {
  const Camera camera = room.camera();
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (int frame = 0; frame < options.frames; frame += 5) {
    const double time = frame / options.rate;
    const CameraState at = room.camera_at(time);
    for (int k = 0; k < 64; ++k) {
      const int column = k % 8, row = k / 8;
      const Eigen::Vector2d pixel((column + 0.5) * camera.width / 8.0,
                                  (row + 0.5) * camera.height / 8.0);
      const Eigen::Vector3d ray = at.orientation * camera.unproject(pixel)->ray.normalized();
      const double inverse_depth = 1.0 / room.cast(at.position, ray, time).distance;
      sum += inverse_depth;
      squares += inverse_depth * inverse_depth;
      ++count;
    }
  }
  LandmarkPrior prior;
  prior.inverse_depth = sum / count;
  prior.inverse_depth_sigma =
      std::sqrt(squares / count - prior.inverse_depth * prior.inverse_depth);
  return prior;
}

std::string room_text(RoomOptions options, std::uint64_t seed) {
  std::string text =
      fmt::format("{}\nseed: {}\nscene: {}\n", kRoomOutput.begins, seed, name_of(options.scene));
  for (const ScenarioParameter& parameter : describe(parameters(options))) {
    // A room of one camera reads as it did before there could be two.
    if (parameter.name == kStereo && options.stereo == 0.0) continue;
    text += fmt::format("{}: {}\n", parameter.name, parameter.value);
  }
  return text;
}

struct StoredRoom {
  RoomOptions options;
  std::uint64_t seed;
};

StoredRoom read_room_file(const std::filesystem::path& file) {
  YamlMap map = load_yaml(file, read_text_file(file));
  if ("format: " + map.text("format") != kRoomOutput.begins) {
    map.refuse(map.take("format"), fmt::format("must be '{}'", kRoomOutput.begins));
  }
  StoredRoom stored;
  const auto seed = parse_number<std::uint64_t>(map.text("seed"));
  if (!seed) map.refuse(map.take("seed"), "'seed' must be a whole number, not negative");
  stored.seed = *seed;
  const std::string scene = map.has("scene") ? map.text("scene") : std::string(name_of({}));
  if (scene == name_of(RoomScene::kBasement)) {
    stored.options = basement_options();
  } else if (scene != name_of(RoomScene::kRoom)) {
    map.refuse(map.take("scene"), "'scene' must be room or basement");
  }
  const Parameters table = parameters(stored.options);
  ScenarioOverrides values;
  for (const ScenarioParameter& parameter : describe(table)) {
    if (map.has(parameter.name)) values[parameter.name] = map.text(parameter.name);
  }
  map.finish();
  try {
    apply(values, name_of(stored.options.scene), table);
  } catch (const std::invalid_argument& error) {
    throw InputError(file, 0, error.what());
  }
  return stored;
}

void add_second_camera(const Room& room, const RoomOptions& options, Sequence& sequence) {
  sequence.other_cameras = room.other_cameras();
  if (sequence.other_cameras.empty()) return;
  sequence.other_images.resize(1);
  for (int i = 0; i < options.frames; ++i) {
    const CameraState& first = *sequence.truth[static_cast<size_t>(i)];
    if (!room.holds(first.position + first.orientation * sequence.other_cameras[0].t)) {
      throw std::invalid_argument(
          fmt::format("{}: {} m from the first the second camera is outside the room in frame {}",
                      kStereo, options.stereo, i));
    }
    sequence.other_images[0].push_back(image_name(1, i));
  }
}

}  // namespace

Sequence room_sequence(const RoomOptions& options, std::uint64_t seed) {
  const Room room(options, seed);
  Sequence sequence;
  sequence.name = fmt::format("{}-{}", name_of(options.scene), seed);
  sequence.camera = room.camera();
  sequence.exact_truth = true;
  for (int i = 0; i < options.frames; ++i) {
    const double time = i / options.rate;
    sequence.frames.push_back({i, time, {}, {}});
    sequence.images.push_back(image_name(0, i));
    sequence.truth.emplace_back(room.camera_at(time));
  }
  add_second_camera(room, options, sequence);
  state(StatementOptions{}, seen_depths(room, options), seed, sequence);
  return sequence;
}

void require_own_room(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  require_own_mark(folder, kRoomOutput);
  for (const char* part : kImages) {
    const fs::path images = folder / part;
    const bool is_link = fs::is_symlink(fs::symlink_status(images));
    if (!is_link && (is_vacant(images) || is_own(folder, kRoomOutput))) continue;
    throw std::invalid_argument(images.string() +
                                ": holds images that are not known to be of this program, and are "
                                "not replaced");
  }
}

Sequence write_room(RoomOptions options, const ScenarioOverrides& overrides, std::uint64_t seed,
                    const std::filesystem::path& folder) {
  apply(overrides, name_of(options.scene), parameters(options));
  Sequence sequence = room_sequence(options, seed);
  require_own_room(folder);
  OutputFiles files;
  add_native(sequence, folder, NativeParts::kWithoutObservations, files);
  files.write(folder / kRoomOutput.mark, room_text(options, seed));
  const Room room(options, seed);
  const auto cameras = 1 + static_cast<int>(sequence.other_cameras.size());
  for (int camera = 0; camera < cameras; ++camera) {
    std::filesystem::create_directories(folder / kImages[camera]);
    for (int i = 0; i < options.frames; ++i) {
      write_image(files.aside(folder / image_name(camera, i)),
                  render(room, options, seed, i, camera));
    }
  }
  files.put_in_place();
  return sequence;
}

void add_room_truth(const std::filesystem::path& images, Sequence& sequence) {
  if (!std::filesystem::exists(images / kRoomOutput.mark)) return;
  const StoredRoom stored = read_room_file(images / kRoomOutput.mark);
  add_room_truth(Room(stored.options, stored.seed), stored.seed, sequence);
}

void add_room_truth(const Room& room, std::uint64_t seed, Sequence& sequence) {
  std::map<int, RoomHit> hits;
  for (const Frame& frame : sequence.frames) {
    const CameraState camera = room.camera_at(frame.timestamp);
    for (const Observation& z : frame.observations) {
      if (!hits.contains(z.track)) {
        const Eigen::Vector3d ray = camera.orientation * sequence.camera.unproject(z.pixel)->ray;
        hits.emplace(z.track, room.cast(camera.position, ray, frame.timestamp));
      }
      const RoomHit& hit = hits.at(z.track);
      TrueLandmark& landmark = sequence.landmarks[z.track];
      landmark.label = hit.box->moves() ? Label::kMoving : Label::kStatic;
      if (landmark.label == Label::kStatic && !landmark.by_frame.empty()) continue;
      landmark.by_frame[frame.index] = {hit.at_start + hit.box->velocity * frame.timestamp,
                                        hit.box->velocity};
    }
  }
  sequence.exact_truth = true;
  sequence.known = choose_known(KnownOptions{}, sequence, seed);
}

}  // namespace slammot
