// What all estimators share beyond the sequence's own statements: which models, which thresholds,
// which policy. A difference between two estimators run with equal ModelOptions is a difference
// between estimators.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace slammot {

// A closed choice with its name in configurations.
template <typename Enum>
struct Choice {
  std::string_view name;
  Enum value;
};

// Labels stay for ever (thesis), or are reverted when rejected.
enum class LabelRule { kOneWay, kReversible };
inline constexpr Choice<LabelRule> kLabelRules[] = {{"one_way", LabelRule::kOneWay},
                                                    {"reversible", LabelRule::kReversible}};

// Landmarks whose label is open; see modules/births.h.
enum class Births { kHeld, kStaticFirst, kFree };
inline constexpr Choice<Births> kBirths[] = {
    {"held", Births::kHeld}, {"static_first", Births::kStaticFirst}, {"free", Births::kFree}};

// On static: marginalise w (thesis), or use w = 0.
enum class Collapse { kDrop, kCondition };
inline constexpr Choice<Collapse> kCollapses[] = {{"drop", Collapse::kDrop},
                                                  {"condition", Collapse::kCondition}};

// What moving landmarks may correct; see modules/consider.h.
enum class Movers { kJoint, kConsidered };
inline constexpr Choice<Movers> kMovers[] = {{"joint", Movers::kJoint},
                                             {"considered", Movers::kConsidered}};

// See depth_prior.h.
enum class DepthPriorSource { kAuto, kEmpirical, kFixed };
inline constexpr Choice<DepthPriorSource> kDepthPriorSources[] = {
    {"auto", DepthPriorSource::kAuto},
    {"fixed", DepthPriorSource::kFixed},
    {"empirical", DepthPriorSource::kEmpirical}};

// Landmarks measured at once where nothing says how many a sequence has in view.
inline constexpr int kUsuallyVisible = 60;

// A static landmark may be hidden for a while: it is given so many times the patience of a free
// one.
inline constexpr double kMissedByStatic = 6.0;

// Admission, removal, the size of the map, and who corrects the camera; see track_policy.h.
struct TrackPolicy {
  int max_landmarks = 300;  // landmarks in the state at once; the one unseen longest leaves
  // Births wait while this many landmarks are being measured; unset: kUsuallyVisible.
  std::optional<int> max_visible;
  // Frames without an accepted measurement until it is pruned; kMissedByStatic times as many that
  // should have shown it, if it is static.
  int prune_after = 5;
  Movers movers = Movers::kJoint;
  bool delayed = false;  // unknown landmarks are considered too (estimator `delayed`)
};

// Numbers of rows from a user's own program, by configuration key, with their defaults: stated
// once, before there are options.
inline std::map<std::string, double>& own_numbers() {
  static std::map<std::string, double> numbers;
  return numbers;
}

struct ClassifierOptions {
  std::string name = "odds";      // a row of classifier_table()
  double static_threshold = 1.6;  // t_s [(m/s)^-3], thesis (3.1)
  double moving_threshold =
      3.583;                    // t_m, thesis (3.2): sqrt of the 0.995 quantile of chi-square(3)
  double prior_odds = 2.0;      // odds: of static to moving, before any measurement
  double decisive_odds = 20.0;  // odds: posterior ones that decide, either way
  std::map<std::string, double> own = own_numbers();
};

// Whether labels may be undone, modules/label_revision.h, and what is believed before there is one,
// modules/births.h.
struct LabelOptions {
  LabelRule rule = LabelRule::kReversible;
  int sightings = 3;  // measurements of a landmark, its first included, until it is labelled
  int memory = 60;    // reversible: frames for which a static landmark's motion is remembered
  Births births = Births::kHeld;
};

// Of a correct measurement passing, on its own and given all others that passed (gate.h); 1: not
// asked.
struct GateOptions {
  double probability = 0.95;
  double given_others = 0.999;
};

// What is kept of a direction that no measurement tells, while the estimate moves: of the EKF
// filters/gauge.h, of a window smoothers/graph/scale_chart.h. kNone: thesis.
enum class Gauge { kNone, kHeading, kScale };

struct ModelOptions {
  std::string landmark = "scaled_velocity";  // a row of landmark_table()
  std::string point = "inverse_depth";       // of its position: a row of point_table()
  Collapse collapse = Collapse::kCondition;
  GateOptions gate;
  ClassifierOptions classifier;
  LabelOptions labels;
  TrackPolicy policy;
  DepthPriorSource depth_prior = DepthPriorSource::kAuto;  // of new landmarks
  bool adaptive_motion = true;  // the camera's noise, see modules/camera_noise.h
  Gauge gauge = Gauge::kScale;
};

}  // namespace slammot
