// Points at random in every parametrisation, and tests over types.
#pragma once

#include "models/points/all_points.h"
#include "tests/models/fixture.h"

namespace slammot::test {

// All types of a tuple, for a typed test suite.
template <typename>
struct TypesOf;
template <typename... M>
struct TypesOf<std::tuple<M...>> {
  using Type = testing::Types<M...>;
};

// As Random::y(), with rho near 0 and below only where there are such points.
template <PointParametrisation P>
Eigen::Vector3d random_point(Random& random) {
  const Eigen::Vector3d angles_and_rho = random.y();
  const Eigen::Vector3d G = InverseDepth::direction(angles_and_rho);
  double rho = angles_and_rho.z();
  if (!P::exists(G, 0.0)) rho = std::max(std::abs(rho), 0.01);
  return P::of(G, rho, angles_and_rho);
}

}  // namespace slammot::test
