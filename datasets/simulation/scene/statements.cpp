#include "datasets/simulation/scene/statements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "datasets/simulation/random/random_stream.h"

namespace slammot {

Parameters parameters(StatementOptions& o) {
  return {
      {"initial_velocity_sigma", "of the velocity stated [m/s]", &o.initial_velocity_sigma,
       kAbove0},
      {"initial_angular_velocity_sigma", "of the angular velocity stated [rad/s]",
       &o.initial_angular_velocity_sigma, kAbove0},
      {"stated_max_speed", "of moving points [m/s]", &o.max_speed, kAbove0},
      {"stated_object_acceleration", "sigma of moving points [m/s^2]; covers the truth",
       &o.object_acceleration, 0},
      {"stated_acceleration", "sigma [m/s^2]; covers the truth", &o.acceleration, kAbove0},
      {"stated_angular_acceleration", "sigma [rad/s^2]; covers the truth", &o.angular_acceleration,
       kAbove0},
      {"stated_inverse_depth", "mean at first sight [1/m]; of the scene", &o.inverse_depth, 0},
      {"stated_inverse_depth_sigma", "at first sight [1/m]; of the scene", &o.inverse_depth_sigma,
       kAbove0},
      {"odds_right", "share of either class that odds from outside have right; 0: none",
       &o.odds_right, 0},
  };
}

namespace {

// The largest over all axes and horizons of n steps of RMS(x(t + n) - x(t)) / (dt sqrt(n)).
template <typename Part>
double white_noise_sigma(const Sequence& sequence, Part part) {
  const size_t frames = sequence.truth.size();
  double largest = 0.0;
  for (size_t n = 1; n <= std::max<size_t>(frames / 4, 1) && n < frames; ++n) {
    Eigen::Array3d squares = Eigen::Array3d::Zero();
    for (size_t i = n; i < frames; ++i) {
      const Eigen::Vector3d change = part(*sequence.truth[i]) - part(*sequence.truth[i - n]);
      squares += change.array().square();
    }
    const double dt =
        (sequence.frames[n].timestamp - sequence.frames[0].timestamp) / static_cast<double>(n);
    const double terms = static_cast<double>(frames - n) * static_cast<double>(n) * dt * dt;
    largest = std::max(largest, std::sqrt(squares.maxCoeff() / terms));
  }
  return largest;
}

}  // namespace

StatedMotion motion_of(const Sequence& sequence) {
  // A smoother inverts the noise, so what is stated is never zero.
  constexpr double kLeastStated = 0.01;
  const auto velocity = [](const CameraState& x) { return x.velocity; };
  const auto turn = [](const CameraState& x) { return x.angular_velocity; };
  return {std::max(white_noise_sigma(sequence, velocity), kLeastStated),
          std::max(white_noise_sigma(sequence, turn), kLeastStated)};
}

namespace {

// Sums of squares of how far the velocities of moving points stray within n frames.
struct Strays {
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  double count = 0.0;
};

// The sum over all moving points stands for one: what is stated is of the population.
double object_acceleration(const Sequence& sequence) {
  const auto horizons = std::max<size_t>(sequence.frames.size() / 4, 1);
  std::vector<Strays> strays(horizons + 1);
  for (const auto& [track, landmark] : sequence.landmarks) {
    if (landmark.label != Label::kMoving) continue;
    for (auto from = landmark.by_frame.begin(); from != landmark.by_frame.end(); ++from) {
      for (auto to = std::next(from); to != landmark.by_frame.end(); ++to) {
        const auto n = static_cast<size_t>(to->first - from->first);
        if (n > horizons) break;
        strays[n].squares += (to->second.velocity - from->second.velocity).array().square();
        strays[n].count += 1.0;
      }
    }
  }
  double largest = kLeastObjectAcceleration;
  const double dt = sequence.frames.back().timestamp /
                    static_cast<double>(std::max<size_t>(sequence.frames.size() - 1, 1));
  for (size_t n = 1; n <= horizons; ++n) {
    const double terms = strays[n].count * static_cast<double>(n) * dt * dt;
    if (terms > 0.0) largest = std::max(largest, std::sqrt(strays[n].squares.maxCoeff() / terms));
  }
  return largest;
}

}  // namespace

// Two-sided 99% of a normal distribution.
constexpr double kNormal99 = 2.5758293035489004;

LandmarkPrior prior_of(const Sequence& sequence) {
  std::set<int> seen;
  for (const KnownLandmark& known : sequence.known) seen.insert(known.track);
  std::vector<double> inverse_depths;
  for (size_t i = 0; i < sequence.frames.size(); ++i) {
    const Frame& frame = sequence.frames[i];
    for (const Observation& z : frame.observations) {
      if (!seen.insert(z.track).second || i == 0) continue;
      const TruePoint& point = *sequence.landmarks.at(z.track).at(frame.index);
      inverse_depths.push_back(1.0 / (point.position - sequence.truth[i]->position).norm());
    }
  }
  LandmarkPrior prior;
  prior.acceleration = object_acceleration(sequence);
  if (inverse_depths.size() < 2) return prior;
  const Eigen::Map<const Eigen::ArrayXd> rho(inverse_depths.data(),
                                             static_cast<Eigen::Index>(inverse_depths.size()));
  prior.inverse_depth = rho.mean();
  const double variance = (rho - rho.mean()).square().sum() / static_cast<double>(rho.size() - 1);
  std::vector<double> distances(inverse_depths.size());
  for (size_t i = 0; i < distances.size(); ++i)
    distances[i] = std::abs(rho(static_cast<Eigen::Index>(i)) - rho.mean());
  std::sort(distances.begin(), distances.end());
  const double covering = distances[distances.size() * 99 / 100] / kNormal99;
  prior.inverse_depth_sigma = std::max(std::sqrt(variance), covering);
  return prior;
}

namespace {

// As a network of known quality would say: its answer is right for the share q = `right` of the
// points of either class, and with pi, the share of points at rest, what it says is the posterior
//
//   p = q pi / (q pi + (1 - q) (1 - pi)) where it answers "rests",
//
// with 1 - q for q where it answers "moves". Each point has a draw of its own, the same for every
// q: what a worse one has right, a better one has too.
void state_odds(double right, std::uint64_t seed, Sequence& sequence) {
  if (right > 1.0) {
    throw std::invalid_argument(fmt::format("odds_right: must be at most 1, not {}", right));
  }
  if (right == 0.0) return;
  RandomStream random(seed, "odds");
  const auto at_rest = std::ranges::count_if(
      sequence.landmarks, [](const auto& l) { return l.second.label == Label::kStatic; });
  const double pi = static_cast<double>(at_rest) / static_cast<double>(sequence.landmarks.size());
  const auto posterior = [pi](double q) { return q * pi / (q * pi + (1.0 - q) * (1.0 - pi)); };
  for (const auto& [track, landmark] : sequence.landmarks) {
    const bool is_right = random.uniform(0.0, 1.0) < right;
    const bool says_static = (landmark.label == Label::kStatic) == is_right;
    sequence.p_static[track] = posterior(says_static ? right : 1.0 - right);
  }
}

}  // namespace

void state(const StatementOptions& options, const LandmarkPrior& scene, std::uint64_t seed,
           Sequence& sequence) {
  RandomStream random(seed, "initial");
  InitialCamera initial;
  initial.state = *sequence.truth.front();
  initial.velocity_sigma = options.initial_velocity_sigma;
  initial.angular_velocity_sigma = options.initial_angular_velocity_sigma;
  initial.state.velocity += initial.velocity_sigma * random.normals<3>();
  initial.state.angular_velocity += initial.angular_velocity_sigma * random.normals<3>();
  sequence.initial = initial;

  StatedMotion motion = motion_of(sequence);
  motion.acceleration = options.acceleration.value_or(motion.acceleration);
  motion.angular_acceleration = options.angular_acceleration.value_or(motion.angular_acceleration);
  sequence.motion = motion;

  LandmarkPrior prior = scene;
  prior.inverse_depth = options.inverse_depth.value_or(prior.inverse_depth);
  prior.inverse_depth_sigma = options.inverse_depth_sigma.value_or(prior.inverse_depth_sigma);
  prior.max_speed = options.max_speed;
  prior.acceleration = options.object_acceleration.value_or(prior.acceleration);
  sequence.prior = prior;
  state_odds(options.odds_right, seed, sequence);
}

}  // namespace slammot
