#include "datasets/simulation/random/random_stream.h"

#include <cmath>
#include <numbers>

namespace slammot {
namespace {

// Steele, Lea & Flood 2014.
std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

// FNV-1a.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view purpose)
    : engine_(splitmix64(splitmix64(seed) ^ hash_of(purpose))) {}

double RandomStream::unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

double RandomStream::uniform(double low, double high) { return low + (high - low) * unit(); }

double RandomStream::normal() {
  const double radius = std::sqrt(-2.0 * std::log1p(-unit()));
  return radius * std::cos(2.0 * std::numbers::pi * unit());
}

int RandomStream::below(int count) { return static_cast<int>(uniform(0.0, count)); }

}  // namespace slammot
