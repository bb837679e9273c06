#include "models/landmarks/landmark_models.h"

#include <algorithm>
#include <array>

#include "models/find_row.h"
#include "models/landmarks/all_models.h"
#include "models/points/all_points.h"

namespace slammot {
namespace {

// Static points only: a model whose landmarks never become free, so that any M serves.
template <PointParametrisation P>
constexpr LandmarkFunctions static_landmark() {
  LandmarkFunctions functions = landmark_row<DynamicInverseDepth<P>>();
  functions.name = "inverse_depth";
  functions.description = "static points only, Civera et al. 2008";
  functions.can_move = false;
  return functions;
}

template <PointParametrisation P, typename... M>
constexpr std::array<LandmarkFunctions, 1 + sizeof...(M)> rows(const std::tuple<M...>*) {
  static_assert((LandmarkModel<M> && ...));
  return {static_landmark<P>(), landmark_row<M>()...};
}

template <PointParametrisation P>
constexpr auto kRows = rows<P>(static_cast<const LandmarkModels<P>*>(nullptr));

template <typename... P>
constexpr auto landmark_rows(const std::tuple<P...>*) {
  constexpr std::size_t kModels = kRows<InverseDepth>.size();
  std::array<LandmarkFunctions, kModels * sizeof...(P)> table{};
  auto end = table.begin();
  ((end = std::copy(kRows<P>.begin(), kRows<P>.end(), end)), ...);
  return table;
}

constexpr auto kTable = landmark_rows(static_cast<const PointParametrisations*>(nullptr));

}  // namespace

std::span<const LandmarkFunctions> landmark_table() { return kTable; }

std::span<const LandmarkFunctions> landmark_table(const PointFunctions& point) {
  constexpr std::size_t kModels = kRows<InverseDepth>.size();
  const auto first =
      std::ranges::find(kTable, point.name, [](const auto& l) { return l.point.name; });
  return {first, kModels};
}

const LandmarkFunctions& find_landmark(const std::string& name, const std::string& point) {
  return find_row(landmark_table(find_point(point)), name, "landmark model");
}

}  // namespace slammot
