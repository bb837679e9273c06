#include "datasets/simulation/scene/manoeuvre.h"

#include <cmath>
#include <numbers>

namespace slammot {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

Sway draw_sway(const Eigen::Vector3d& acceleration, double period, RandomStream& random) {
  const double factor = random.uniform(1.0 - kPeriodSpread, 1.0 + kPeriodSpread);
  return {acceleration, kTurn / (period * factor), random.uniform(0.0, kTurn)};
}

}  // namespace

Eigen::Vector3d Manoeuvre::offset(double time) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Sway& s : sways) {
    sum -= s.acceleration * (std::sin(s.rate * time + s.phase) / (s.rate * s.rate));
  }
  return sum;
}

Eigen::Vector3d Manoeuvre::velocity(double time) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Sway& s : sways) sum -= s.acceleration * (std::cos(s.rate * time + s.phase) / s.rate);
  return sum;
}

Eigen::Vector3d Manoeuvre::acceleration(double time) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Sway& s : sways) sum += s.acceleration * std::sin(s.rate * time + s.phase);
  return sum;
}

double Manoeuvre::reach() const {
  double sum = 0.0;
  for (const Sway& s : sways) sum += s.acceleration.norm() / (s.rate * s.rate);
  return sum;
}

Parameters parameters(ManoeuvreOptions& o) {
  return {
      {"manoeuvring", "share of the moving points that never stop which turn and brake", &o.share,
       0},
      {"lateral_acceleration", "largest across a mover's mean course [m/s^2]", &o.lateral, 0},
      {"braking", "largest acceleration along a mover's mean course [m/s^2]", &o.braking, 0},
      {"manoeuvre_period", "mean period of turning and of braking [s]", &o.period, kAbove0},
  };
}

double largest_slowing(const ManoeuvreOptions& options) {
  return options.braking * options.period * (1.0 + kPeriodSpread) / kTurn;
}

std::optional<Manoeuvre> draw_manoeuvre(const ManoeuvreOptions& options,
                                        const Eigen::Vector3d& velocity, RandomStream& random) {
  const bool manoeuvres = random.uniform(0.0, 1.0) < options.share;
  const Eigen::Vector3d along = velocity.normalized();
  const Eigen::Vector3d across = Eigen::Vector3d(along.z(), 0.0, -along.x()).normalized();
  Manoeuvre manoeuvre;
  for (size_t k = 0; k < manoeuvre.sways.size(); ++k) {
    const bool brakes = k < 2;  // two sinusoids share what is largest
    const Eigen::Vector3d acceleration = brakes ? Eigen::Vector3d(0.5 * options.braking * along)
                                                : Eigen::Vector3d(0.5 * options.lateral * across);
    manoeuvre.sways[k] = draw_sway(acceleration, options.period, random);
  }
  return manoeuvres ? std::optional(manoeuvre) : std::nullopt;
}

}  // namespace slammot
