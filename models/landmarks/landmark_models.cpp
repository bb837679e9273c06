#include "models/landmarks/landmark_models.h"

#include <array>

#include "models/find_row.h"
#include "models/landmarks/all_models.h"

namespace slammot {
namespace {

// Static points only: a model whose landmarks never become free, so that any M serves.
constexpr LandmarkFunctions inverse_depth() {
  LandmarkFunctions functions = landmark_row<DynamicInverseDepth>();
  functions.name = "inverse_depth";
  functions.description = "static points only, Civera et al. 2008";
  functions.can_move = false;
  return functions;
}

template <typename... M>
constexpr std::array<LandmarkFunctions, 1 + sizeof...(M)> rows(const std::tuple<M...>*) {
  return {inverse_depth(), landmark_row<M>()...};
}

constexpr auto kTable = rows(static_cast<const LandmarkModels*>(nullptr));

}  // namespace

std::span<const LandmarkFunctions> landmark_table() { return kTable; }

const LandmarkFunctions& find_landmark(const std::string& name) {
  return find_row(landmark_table(), name, "landmark model");
}

}  // namespace slammot
