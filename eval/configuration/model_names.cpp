#include "eval/configuration/model_names.h"

#include "estimation/classification.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {
namespace {

template <typename Table>
std::vector<NamedEntry> listed(const Table& table) {
  std::vector<NamedEntry> list;
  for (const auto& row : table) {
    list.push_back({std::string(row.name), std::string(row.description)});
  }
  return list;
}

}  // namespace

std::vector<NamedEntry> landmark_list() { return listed(landmark_table(point_table().front())); }

std::vector<NamedEntry> point_list() { return listed(point_table()); }

std::vector<NamedEntry> classifier_list() { return listed(classifier_table()); }

std::span<const MotionRow> motion_table() {
  static constexpr MotionRow kTable[] = {
      {"white_noise", "the velocity is a Wiener process within a step: full rank",
       NoiseDiscretisation::kWhiteNoise},
      {"impulse", "one acceleration at the start of a step: rank 6 (the thesis, Montiel)",
       NoiseDiscretisation::kImpulse},
  };
  return kTable;
}

std::vector<std::string> names_of(const std::vector<NamedEntry>& list) {
  std::vector<std::string> names;
  for (const NamedEntry& entry : list) names.push_back(entry.name);
  return names;
}

}  // namespace slammot
