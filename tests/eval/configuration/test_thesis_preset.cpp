// The studies of the thesis's settings say `preset: thesis` and what differs; each of their cells
// has the values that were typed in full before there were presets.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "eval/study/study.h"
#include "tests/paths.h"

namespace slammot {
namespace {

constexpr const char* kTyped =
    "labels=one_way labels.sightings=2 labels.memory=0 ekf.second_order=false policy.movers=joint "
    "gauge=none "
    "motion.adaptive=false classifier=thesis gate.given_others=1 collapse=drop prior.source=fixed "
    "prior.steady_time=0 ";

struct TypedCell {
  std::string study;
  std::string estimator;  // the cell's label
  std::string settings;   // beside kTyped
};

const TypedCell kCells[] = {
    {"table_4_1", "window",
     "labels.first_frame=static landmark=dynamic_inverse_depth window.frames=10 "
     "window.iterations=5 classifier.static_threshold=1.6"},
    {"table_4_1", "ideal_covariance",
     "labels.first_frame=static window.frames=10 window.iterations=5"},
    {"table_4_1_noise", "ekf dynamic_inverse_depth",
     "labels.first_frame=static landmark=dynamic_inverse_depth"},
    {"table_4_1_noise", "ekf scaled_velocity", "labels.first_frame=static"},
    {"table_4_1_thesis", "with a gate",
     "labels.first_frame=static landmark=dynamic_inverse_depth motion.discretisation=impulse "
     "gate.probability=0.95 policy.max_landmarks=100000 policy.max_visible=100000 "
     "policy.prune_after=100000"},
    {"fig_3_1", "ekf",
     "landmark=dynamic_inverse_depth window.frames=10 window.iterations=5 "
     "classifier.static_threshold=1e12 classifier.moving_threshold=1e12"},
    {"fig_3_2", "window",
     "landmark=dynamic_inverse_depth window.frames=10 window.iterations=5 "
     "classifier.static_threshold=1e12 classifier.moving_threshold=1e12"},
    {"fig_4_1", "ekf",
     "labels.first_frame=static landmark=dynamic_inverse_depth window.frames=10 "
     "window.iterations=5 classifier.static_threshold=0.5"},
    {"fig_4_2", "ekf",
     "labels.first_frame=static landmark=dynamic_inverse_depth window.frames=10 "
     "window.iterations=5"},
    {"undelayed", "delayed", "labels.first_frame=static"},
    {"circle_consistency", "ekf thesis", "labels.first_frame=static window.frames=10"},
    {"circle_consistency", "window thesis", "labels.first_frame=static window.frames=10"},
};

std::vector<std::pair<std::string, std::string>> typed(const TypedCell& cell) {
  Configuration c;
  c.preset = "thesis";
  std::istringstream words(kTyped + cell.settings);
  for (std::string word; words >> word;) assign(c, parse_assignment(word));
  return key_values(c);
}

TEST(ThesisPreset, AStudysCellHasTheValuesThatWereTyped) {
  for (const TypedCell& cell : kCells) {
    SCOPED_TRACE(cell.study + ", " + cell.estimator);
    const Study study =
        parse_study(std::string(test::kSourceDir) + "/eval/studies/" + cell.study + ".yaml");
    const auto found = std::ranges::find(study.cells, cell.estimator, &StudyCell::label);
    ASSERT_NE(found, study.cells.end());
    EXPECT_EQ(key_values(found->configuration), typed(cell));
  }
}

}  // namespace
}  // namespace slammot
