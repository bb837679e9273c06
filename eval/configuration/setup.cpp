#include "eval/configuration/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estimation/classification.h"
#include "estimation/modules/depth_prior.h"

namespace slammot {
namespace {

InitialCamera initial_camera(const Sequence& sequence) {
  InitialCamera initial;
  if (sequence.initial) {
    initial = *sequence.initial;
  } else if (!sequence.truth.empty() && sequence.truth.front()) {
    initial.state.position = sequence.truth.front()->position;
    initial.state.orientation = sequence.truth.front()->orientation;
  }
  return initial;
}

MotionNoise motion_noise(const Sequence& sequence, const MotionConfiguration& overrides) {
  MotionNoise noise;
  if (sequence.motion) {
    noise.acceleration = sequence.motion->acceleration;
    noise.angular_acceleration = sequence.motion->angular_acceleration;
  }
  noise.acceleration = overrides.acceleration.value_or(noise.acceleration);
  noise.angular_acceleration = overrides.angular_acceleration.value_or(noise.angular_acceleration);
  noise.discretisation = overrides.discretisation;
  return noise;
}

constexpr double kUnknownMean = 1.0;  // [1/m], of a scene of which nothing is stated

// A scene of which nothing is stated but landmarks known beforehand is about as far away as those
// that the first frame measures. With a guess that is too far the first flow is taken for a
// rotation, with one that is too near the EKF believes what it should not.
std::optional<double> inverse_depth_of_known(const Sequence& sequence, const CameraState& camera) {
  if (sequence.frames.empty()) return std::nullopt;
  double sum = 0.0;
  int count = 0;
  for (const KnownLandmark& known : sequence.known) {
    const bool is_measured =
        std::ranges::any_of(sequence.frames.front().observations,
                            [&](const Observation& z) { return z.track == known.track; });
    const double distance = (known.position - camera.position).norm();
    if (!is_measured || !(distance > 0.0)) continue;
    sum += 1.0 / distance;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

// How well rho0 is known: exactly, where it is all that holds the scale. A mean that is learnt is
// known to half of itself where it is stated, to itself where known landmarks tell it, and hardly
// at all where nothing does.
double mean_sigma(const LandmarkPrior& stated, bool learns, bool is_given, bool is_of_known) {
  if (!learns) return 0.0;
  if (is_of_known) return stated.inverse_depth;
  if (!is_given) return kUnknownMean;
  return stated.mean_sigma > 0.0 ? stated.mean_sigma : 0.5 * stated.inverse_depth;
}

// What moves in a scene of which nothing is stated moves as fast as its camera, where that is
// known.
double max_speed(const LandmarkPrior& model, const InitialCamera& camera) {
  const double speed = camera.state.velocity.norm();
  return holds_scale(camera) ? std::max(model.max_speed, speed) : model.max_speed;
}

// Where the scale is measured each depth is a guess of its own, and no mean is learnt with them.
void part_with_mean(LandmarkPrior& prior) {
  prior.inverse_depth_sigma = std::hypot(prior.inverse_depth_sigma, prior.mean_sigma);
  prior.mean_sigma = 0.0;
  prior.spread_follows_mean = false;
}

LandmarkPrior landmark_prior(const Sequence& sequence, const InitialCamera& camera,
                             const Configuration& configuration) {
  const PriorConfiguration& overrides = configuration.prior;
  LandmarkPrior prior = sequence.prior.value_or(LandmarkPrior{});
  if (!sequence.prior) prior.max_speed = max_speed(prior, camera);
  const bool is_given = sequence.prior || overrides.inverse_depth;
  const auto of_known = is_given ? std::nullopt : inverse_depth_of_known(sequence, camera.state);
  if (of_known) {
    prior.inverse_depth = prior.inverse_depth_sigma = *of_known;
  }
  prior.inverse_depth = overrides.inverse_depth.value_or(prior.inverse_depth);
  prior.inverse_depth_sigma = overrides.inverse_depth_sigma.value_or(prior.inverse_depth_sigma);
  const bool is_measured = measures_scale(sequence);
  const bool learns = learns_depths(configuration.model.depth_prior, camera,
                                    is_measured || !sequence.known.empty());
  // Where no landmark is known, a spread in 1/m would tell a smoother the scale, and a filter not.
  const bool depths_are_known = is_given && prior.mean_sigma == 0.0 && !sequence.known.empty();
  prior.mean_sigma =
      overrides.mean_sigma.value_or(mean_sigma(prior, learns, is_given, of_known.has_value()));
  prior.spread_follows_mean = overrides.spread == PriorSpread::kAuto
                                  ? prior.mean_sigma > 0.0 && !depths_are_known
                                  : overrides.spread == PriorSpread::kRelative;
  if (is_measured) part_with_mean(prior);
  prior.max_speed = overrides.max_speed.value_or(prior.max_speed);
  prior.acceleration = overrides.acceleration.value_or(prior.acceleration);
  prior.jerk = overrides.jerk.value_or(prior.jerk);
  prior.steady_time = overrides.steady_time.value_or(prior.steady_time);
  return prior;
}

// Only a simulated truth is exact enough to linearise at.
std::shared_ptr<const Truth> truth_of(const Sequence& sequence) {
  if (!sequence.exact_truth) return nullptr;
  auto truth = std::make_shared<Truth>();
  for (std::size_t i = 0; i < sequence.truth.size(); ++i) {
    if (sequence.truth[i]) truth->cameras[sequence.frames[i].index] = *sequence.truth[i];
  }
  truth->landmarks = sequence.landmarks;
  return truth;
}

}  // namespace

Sequence selected(Sequence sequence, const FrameSelection& frames) {
  const std::string name = sequence.name;
  Sequence result = select_frames(std::move(sequence), frames.first, frames.last, 1);
  if (result.frames.empty()) {
    throw std::invalid_argument("frames.first and frames.last leave no frame of " + name);
  }
  return result;
}

Setup make_setup(const Sequence& sequence, const Configuration& configuration) {
  Setup setup;
  setup.camera = sequence.camera;
  setup.other_cameras = sequence.other_cameras;
  setup.measures_scale = measures_scale(sequence);
  setup.pixel_sigma = configuration.pixel_sigma.value_or(sequence.pixel_sigma);
  setup.camera_noise = motion_noise(sequence, configuration.motion);
  setup.initial = initial_camera(sequence);
  setup.prior = landmark_prior(sequence, setup.initial, configuration);
  setup.known = sequence.known;
  setup.p_static = sequence.p_static;
  for (const auto& [track, landmark] : sequence.landmarks) {
    setup.true_labels[track] = landmark.label;
  }
  if (configuration.ekf.linearisation == FilterLinearisation::kIdeal) {
    setup.truth = truth_of(sequence);
  }
  return setup;
}

// (3.1) would call every landmark static as soon as it is asked, whatever was measured.
std::optional<std::string> warning_about(const Setup& setup, const Configuration& configuration) {
  const LandmarkFunctions& landmark =
      find_landmark(configuration.model.landmark, configuration.model.point);
  const ClassifierOptions classifier = classifier_for(landmark, configuration.model.classifier);
  if (classifier.name != "thesis") return std::nullopt;
  const double score = static_score_at_birth(landmark, setup.prior);
  if (!(score > classifier.static_threshold)) return std::nullopt;
  return fmt::format(
      "C_s is {:.3g} (m/s)^-3 before any measurement, above classifier.static_threshold = {:.3g}: "
      "every landmark becomes static at once; raise it or prior.max_speed = {:.3g} m/s, or set "
      "classifier=odds",
      score, classifier.static_threshold, setup.prior.max_speed);
}

Configuration resolve(const Sequence& sequence, const Configuration& configuration) {
  return resolved(sequence, make_setup(sequence, configuration), configuration);
}

Configuration resolved(const Sequence& sequence, const Setup& setup, Configuration configuration) {
  std::optional<int>& visible = configuration.model.policy.max_visible;
  if (!visible) visible = std::max(kUsuallyVisible, sequence.points.value_or(0));
  configuration.model.depth_prior =
      learns_depths(configuration.model.depth_prior, setup.initial, setup.knows_scale())
          ? DepthPriorSource::kEmpirical
          : DepthPriorSource::kFixed;
  configuration.pixel_sigma = setup.pixel_sigma;
  configuration.motion.acceleration = setup.camera_noise.acceleration;
  configuration.motion.angular_acceleration = setup.camera_noise.angular_acceleration;
  configuration.prior = {
      setup.prior.inverse_depth,
      setup.prior.inverse_depth_sigma,
      setup.prior.mean_sigma,
      setup.prior.max_speed,
      setup.prior.acceleration,
      setup.prior.jerk,
      setup.prior.steady_time,
      setup.prior.spread_follows_mean ? PriorSpread::kRelative : PriorSpread::kFixed};
  return configuration;
}

}  // namespace slammot
