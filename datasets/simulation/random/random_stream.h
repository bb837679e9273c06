// Random numbers that do not depend on the standard library's distributions: mt19937_64, whose
// output the standard fixes, with our own transformations.
//
// Each purpose (camera, points, pixels...) draws from its own stream of the seed, so that drawing
// more for one does not shift another.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string_view>

namespace slammot {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view purpose);

  double uniform(double low, double high);  // [low, high)
  double normal();                          // N(0, 1), Box-Muller
  int below(int count);                     // 0 .. count - 1

  // A vector of independent N(0, 1).
  template <int N>
  Eigen::Matrix<double, N, 1> normals() {
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v(i) = normal();
    return v;
  }

 private:
  double unit();  // [0, 1), 53 bits

  std::mt19937_64 engine_;
};

}  // namespace slammot
