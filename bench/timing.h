// Medians of times and ratios.
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace slammot::bench {

// Wall time of one call [ms].
template <typename F>
double milliseconds(F&& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - begin;
  return elapsed.count();
}

inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace slammot::bench
