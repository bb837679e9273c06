#include "models/landmarks/landmark_models.h"

#include <algorithm>
#include <array>
#include <vector>

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

std::vector<LandmarkFunctions>& table() {
  constexpr auto kTable = landmark_rows(static_cast<const PointParametrisations*>(nullptr));
  static std::vector<LandmarkFunctions> rows(kTable.begin(), kTable.end());
  return rows;
}

// The rows of one parametrisation stand together.
auto has_point(std::string_view name) {
  return [name](const LandmarkFunctions& row) { return row.point.name == name; };
}

}  // namespace

std::span<const LandmarkFunctions> landmark_table() { return table(); }

std::span<const LandmarkFunctions> landmark_table(const PointFunctions& point) {
  const auto first = std::ranges::find_if(table(), has_point(point.name));
  return {first, std::find_if_not(first, table().end(), has_point(point.name))};
}

void add_landmarks(std::span<const LandmarkFunctions> rows) {
  for (const LandmarkFunctions& added : rows) {
    const auto of_point = landmark_table(find_point(std::string(added.point.name)));
    if (std::ranges::find(of_point, added.name, &LandmarkFunctions::name) != of_point.end()) {
      throw std::invalid_argument("there is a landmark model '" + std::string(added.name) +
                                  "' already");
    }
    const auto last = of_point.data() + of_point.size() - table().data();
    table().insert(table().begin() + last, added);
  }
}

const LandmarkFunctions& find_landmark(const std::string& name, const std::string& point) {
  return find_row(landmark_table(find_point(point)), name, "landmark model");
}

}  // namespace slammot
