// Rows that a program adds to the tables: found by name, refused where the name is taken.
#include <gtest/gtest.h>

#include "apps/app.h"
#include "models/landmarks/dynamic_inverse_depth.h"

namespace slammot {
namespace {

template <PointParametrisation P>
struct Renamed : DynamicInverseDepth<P> {
  static constexpr std::string_view kName = "renamed";
};

TEST(Extras, ALandmarkModelStandsWithEveryParametrisation) {
  const std::size_t before = landmark_table().size();
  const std::size_t points = point_table().size();
  add_landmarks(landmark_rows<Renamed>());
  EXPECT_EQ(landmark_table().size(), before + points);
  for (const PointFunctions& point : point_table()) {
    const auto rows = landmark_table(point);
    EXPECT_EQ(rows.size(), before / points + 1);
    for (const LandmarkFunctions& row : rows) EXPECT_EQ(row.point.name, point.name);
    EXPECT_EQ(find_landmark("renamed", std::string(point.name)).point.name, point.name);
  }
  EXPECT_THROW(add_landmarks(landmark_rows<Renamed>()), std::invalid_argument);
  EXPECT_EQ(landmark_table().size(), before + points);
}

TEST(Extras, ANameThatIsTakenIsRefused) {
  const ClassifierRow classifier = classifier_table().front();
  EXPECT_THROW(add_classifiers({&classifier, 1}), std::invalid_argument);
  const EstimatorRow estimator = estimator_table().front();
  EXPECT_THROW(add_estimators({&estimator, 1}), std::invalid_argument);
  const ReaderRow reader = reader_table().front();
  EXPECT_THROW(add_readers({&reader, 1}), std::invalid_argument);
  const ScenarioRow scenario = scenario_table().front();
  EXPECT_THROW(add_scenarios({&scenario, 1}), std::invalid_argument);
  EXPECT_THROW(add_metrics({metric_table().front()}), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
