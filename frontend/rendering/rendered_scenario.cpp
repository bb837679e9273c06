#include "frontend/rendering/rendered_scenario.h"

#include <algorithm>
#include <deque>
#include <future>
#include <mutex>
#include <string>
#include <utility>

#include "frontend/rendering/render.h"
#include "frontend/tracking/track_images.h"

namespace slammot {
namespace {

struct Options {
  RoomOptions room;
  int noise_by_alignment = 0;
  int scale_only = 0;
};

Parameters parameters(Options& o) {
  return joined(
      parameters(o.room),
      {{"noise_by_alignment",
        "1: each measurement has its own sigma, as in track --noise alignment",
        &o.noise_by_alignment, 0},
       {"scale_only", "1: nothing is stated of motion and depths, as of a recording with a board",
        &o.scale_only, 0}});
}

// Left are the first pose and four points. What the maker states knows the true motion and depths.
void state_scale_only(Sequence& sequence) {
  InitialCamera initial;
  initial.state.position = sequence.initial->state.position;
  initial.state.orientation = sequence.initial->state.orientation;
  sequence.initial = initial;
  sequence.motion.reset();
  sequence.prior.reset();
}

Sequence rendered(const Options& options, std::uint64_t seed) {
  const Room room(options.room, seed);
  const Sequence images = room_sequence(options.room, seed);
  TrackOptions one_thread;  // a study runs a job on each core
  one_thread.threads = 1;
  if (options.noise_by_alignment != 0) one_thread.noise = NoiseModel::kAlignment;
  const auto frame_images = [&](std::size_t place) {
    const auto of = [&](std::size_t camera) {
      return render(room, options.room, seed, static_cast<int>(place), static_cast<int>(camera));
    };
    FrameImages frame{of(0), {}, {}};
    for (std::size_t c = 1; c <= images.other_cameras.size(); ++c) frame.others.push_back(of(c));
    return frame;
  };
  Sequence sequence = track_images(images, frame_images, one_thread).sequence;
  sequence.images.clear();
  sequence.other_images.clear();
  add_room_truth(room, seed, sequence);
  return sequence;
}

// Those that are being made are waited for, not made again.
class LatestSequences {
 public:
  Sequence get(const Options& options, std::uint64_t seed) {
    std::promise<Sequence> made;
    std::shared_future<Sequence> sequence;
    bool is_new = false;
    {
      const std::lock_guard lock(mutex_);
      const std::string key = key_of(options, seed);
      const auto found = std::ranges::find(kept_, key, &Kept::key);
      is_new = found == kept_.end();
      sequence = is_new ? made.get_future().share() : found->sequence;
      if (is_new) kept_.push_back({key, sequence});
      if (kept_.size() > kMost) kept_.pop_front();
    }
    if (is_new) make(options, seed, made);
    return sequence.get();
  }

 private:
  // A study takes all cells of a seed in turn: about as many seeds as jobs are in hand.
  static constexpr std::size_t kMost = 8;
  struct Kept {
    std::string key;
    std::shared_future<Sequence> sequence;
  };

  static std::string key_of(Options options, std::uint64_t seed) {
    std::string key = std::to_string(seed);
    for (const ScenarioParameter& p : describe(parameters(options))) key += ' ' + p.value;
    return key;
  }
  static void make(const Options& options, std::uint64_t seed, std::promise<Sequence>& made) {
    try {
      made.set_value(rendered(options, seed));
    } catch (...) {
      made.set_exception(std::current_exception());
    }
  }

  std::mutex mutex_;
  std::deque<Kept> kept_;
};

RoomOptions room_options() { return {}; }

template <RoomOptions defaults()>
Options scene_options(std::string_view name, const ScenarioOverrides& overrides) {
  Options options{defaults()};
  apply(overrides, name, parameters(options));
  return options;
}

// All but the images.
template <RoomOptions defaults()>
void check_scene(std::string_view name, const ScenarioOverrides& overrides, std::uint64_t seed) {
  room_sequence(scene_options<defaults>(name, overrides).room, seed);
}

// Each scene keeps its own latest: key_of() does not say which it is.
template <RoomOptions defaults()>
Sequence simulate_scene(std::string_view name, const ScenarioOverrides& overrides,
                        std::uint64_t seed) {
  static LatestSequences latest;
  Options options = scene_options<defaults>(name, overrides);
  const bool scale_only = std::exchange(options.scale_only, 0) != 0;  // of the same images
  Sequence sequence = latest.get(options, seed);
  if (scale_only) state_scale_only(sequence);
  return sequence;
}

template <RoomOptions defaults()>
std::vector<ScenarioParameter> scene_parameters() {
  Options options{defaults()};
  return describe(parameters(options));
}

constexpr ScenarioRow kRows[] = {
    {"basement", "from pixels: a robot's loop in a rendered room, a person passes three times",
     simulate_scene<basement_options>, scene_parameters<basement_options>,
     check_scene<basement_options>},
    {"room", "from pixels: a small rendered room, seen from one end, some boxes in it move",
     simulate_scene<room_options>, scene_parameters<room_options>, check_scene<room_options>}};

}  // namespace

std::span<const ScenarioRow> rendered_scenarios() { return kRows; }

}  // namespace slammot
