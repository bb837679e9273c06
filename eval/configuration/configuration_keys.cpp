// The table of configuration keys: name and help.
#include <nlohmann/json.hpp>

#include "eval/configuration/key_forms.h"
#include "eval/configuration/preset.h"

namespace slammot {
namespace {

#define SLAMMOT_FIELD(path) \
  [](auto& c) -> auto& { return c.path; }

void append(std::vector<ConfigurationKey>& keys, std::vector<ConfigurationKey> more) {
  keys.insert(keys.end(), more.begin(), more.end());
}

std::vector<ConfigurationKey> model_keys() {
  return {
      choice("landmark", "landmark model", names_of(landmark_list()),
             SLAMMOT_FIELD(model.landmark)),
      choice("point", "parametrisation of its position", names_of(point_list()),
             SLAMMOT_FIELD(model.point)),
      option<Collapse>("collapse", "on static, marginalise the velocity or use v = 0",
                       listed(kCollapses), SLAMMOT_FIELD(model.collapse)),
      number("gate.probability", "of a correct measurement passing on its own; 1: not asked",
             kUpToOne, SLAMMOT_FIELD(model.gate.probability)),
      number("gate.given_others", "of one passing given all others that passed; 1: not asked",
             kUpToOne, SLAMMOT_FIELD(model.gate.given_others)),
      choice("classifier", "who labels the landmarks", names_of(classifier_list()),
             SLAMMOT_FIELD(model.classifier.name)),
      number("classifier.static_threshold", "thesis: t_s [(m/s)^-3]", kPositive,
             SLAMMOT_FIELD(model.classifier.static_threshold)),
      number("classifier.moving_threshold", "thesis: t_m", kPositive,
             SLAMMOT_FIELD(model.classifier.moving_threshold)),
      number("classifier.prior_odds", "odds: of static to moving, before any measurement",
             kPositive, SLAMMOT_FIELD(model.classifier.prior_odds)),
      number("classifier.decisive_odds", "odds: posterior ones that decide, either way", kAboveOne,
             SLAMMOT_FIELD(model.classifier.decisive_odds)),
      option<LabelRule>(
          "labels",
          "kept for ever (thesis), or reverted when innovations, a remembered motion or an "
          "inverse depth below zero reject them",
          listed(kLabelRules), SLAMMOT_FIELD(model.labels.rule)),
      number("labels.sightings",
             "measurements of a landmark, its first included, until it is labelled", kPositive,
             SLAMMOT_FIELD(model.labels.sightings)),
      number("labels.memory",
             "reversible: frames for which what a static landmark's motion would be is remembered",
             kNotNegative, SLAMMOT_FIELD(model.labels.memory)),
      option<Births>("labels.births",
                     "landmarks whose label is open: held at rest until evidence says that they "
                     "move (held), free to move (free), or free but for those of the first frame, "
                     "static by rule (static_first: thesis, figure 4.5a)",
                     listed(kBirths), SLAMMOT_FIELD(model.labels.births)),
      number("policy.max_landmarks", "landmarks in the state at once", kPositive,
             SLAMMOT_FIELD(model.policy.max_landmarks)),
      number(
          "policy.max_visible",
          "no births while so many are being measured; sequence: as many points as its front end "
          "looked for, 60 at least",
          kPositive, SLAMMOT_FIELD(model.policy.max_visible)),
      number("policy.prune_after",
             "frames without a measurement until a landmark is pruned; of a static one, six times "
             "as many that should have shown it",
             kPositive, SLAMMOT_FIELD(model.policy.prune_after)),
      option<Movers>("policy.movers",
                     "moving landmarks correct the camera too (thesis), or only themselves where "
                     "enough static ones are measured",
                     listed(kMovers), SLAMMOT_FIELD(model.policy.movers)),
  };
}

std::vector<Choice<NoiseDiscretisation>> motion_choices() {
  std::vector<Choice<NoiseDiscretisation>> choices;
  for (const MotionRow& row : motion_table()) {
    choices.push_back({row.name, row.discretisation});
  }
  return choices;
}

std::vector<ConfigurationKey> statement_keys() {
  return {
      number("pixel_sigma", "measurement noise, where relative_sigma is 1 [px]", kPositive,
             SLAMMOT_FIELD(pixel_sigma)),
      number("motion.acceleration", "camera noise [m/s^2]", kNotNegative,
             SLAMMOT_FIELD(motion.acceleration)),
      number("motion.angular_acceleration", "camera noise [rad/s^2]", kNotNegative,
             SLAMMOT_FIELD(motion.angular_acceleration)),
      flag(
          "motion.adaptive",
          "the camera's noise is wider than stated in a curve, and where the static landmarks of a "
          "frame say that it is larger",
          SLAMMOT_FIELD(model.adaptive_motion)),
      option<Gauge>(
          "gauge",
          "what is kept of a direction that no measurement tells while the estimate moves; none: "
          "thesis; heading: the EKF only; of a window scale, where no landmark is known",
          {{"none", Gauge::kNone}, {"heading", Gauge::kHeading}, {"scale", Gauge::kScale}},
          SLAMMOT_FIELD(model.gauge)),
      option<NoiseDiscretisation>("motion.discretisation", "of the camera's noise",
                                  motion_choices(), SLAMMOT_FIELD(motion.discretisation)),
      option<DepthPriorSource>(
          "prior.source",
          "rho0 and its sigma as given, or learnt from the landmarks in view (empirical); auto: "
          "empirical where a landmark is known beforehand, or the first velocity to half of itself",
          listed(kDepthPriorSources), SLAMMOT_FIELD(model.depth_prior)),
      number("prior.inverse_depth", "rho0 of new landmarks [1/m]", kNotNegative,
             SLAMMOT_FIELD(prior.inverse_depth)),
      number("prior.inverse_depth_sigma", "its standard deviation [1/m]", kPositive,
             SLAMMOT_FIELD(prior.inverse_depth_sigma)),
      number("prior.mean_sigma",
             "of rho0 itself, then estimated [1/m]; 0: rho0 is known; if empirical, half of rho0, "
             "rho0 of known landmarks, and 1 where nothing is stated",
             kNotNegative, SLAMMOT_FIELD(prior.mean_sigma)),
      option<PriorSpread>(
          "prior.spread",
          "sigma_rho of a landmark as its estimated mean is corrected: fixed or relative to it; "
          "auto: relative where no landmark is known, or no depths are stated, or a mean_sigma; "
          "relative also "
          "takes a smoother's noise in units of its world where no landmark is known",
          listed(kPriorSpreads), SLAMMOT_FIELD(prior.spread)),
      number(
          "prior.max_speed",
          "|v|max of landmarks; sigma_v is half of it; where nothing states it, 2 or the camera's "
          "first speed, if that is more and known to half of itself [m/s]",
          kPositive, SLAMMOT_FIELD(prior.max_speed)),
      number("prior.acceleration", "noise of unknown and moving landmarks [m/s^2]", kNotNegative,
             SLAMMOT_FIELD(prior.acceleration)),
      number("prior.jerk", "the same of models with an acceleration [m/s^3]", kNotNegative,
             SLAMMOT_FIELD(prior.jerk)),
      number("prior.steady_time",
             "in which the velocity of one that is not known to move changes by its sigma at most "
             "[s]; 0: no bound",
             kNotNegative, SLAMMOT_FIELD(prior.steady_time)),
      number("frames.first", "number of the first frame used", kNotNegative,
             SLAMMOT_FIELD(frames.first)),
      number("frames.last", "number of the last frame used, -1: the sequence's last", kFromMinusOne,
             SLAMMOT_FIELD(frames.last)),
  };
}

std::vector<ConfigurationKey> estimator_keys() {
  return {
      option<FilterLinearisation>("ekf.linearisation",
                                  "Jacobians at the estimate, the first estimate, or the truth",
                                  {{"standard", FilterLinearisation::kStandard},
                                   {"fej", FilterLinearisation::kFej},
                                   {"ideal", FilterLinearisation::kIdeal}},
                                  SLAMMOT_FIELD(ekf.linearisation)),
      number("ekf.iterations", "1: EKF, more: iterated EKF", kUpToThousand,
             SLAMMOT_FIELD(ekf.iterations)),
      number("ekf.lag", "past poses that stay in the state, to be corrected by later frames",
             kPastPoses, SLAMMOT_FIELD(ekf.lag)),
      flag("ekf.second_order",
           "noise for the product of a static landmark's depth and the camera's translation",
           SLAMMOT_FIELD(ekf.second_order)),
      number("window.frames", "camera states kept", kPositive, SLAMMOT_FIELD(window.frames)),
      number("window.iterations", "Gauss-Newton steps a frame at most", kUpToThousand,
             SLAMMOT_FIELD(window.iterations)),
      number("window.linearisation_error",
             "a step after which residuals are as predicted to so many sigma is the last",
             kPositive, SLAMMOT_FIELD(window.linearisation_error)),
      option<WindowLinearisation>(
          "window.linearisation", "Jacobians at the estimate, or the first estimate",
          {{"standard", WindowLinearisation::kStandard}, {"fej", WindowLinearisation::kFej}},
          SLAMMOT_FIELD(window.linearisation)),
      option<WindowSolver>("window.solver",
                           "who minimises; ceres: until it converges (1000 iterations at most), "
                           "and slowly",
                           {{"own", WindowSolver::kOwn}, {"ceres", WindowSolver::kCeres}},
                           SLAMMOT_FIELD(window.solver)),
  };
}

ConfigurationKey preset_key() {
  const std::string help = fmt::format(
      "settings that every key of its own overrides; thesis: as in the thesis, with what it leaves "
      "open as everywhere: {}",
      fmt::join(preset_names(), ", "));
  return {"preset", help, take_preset, [](const Configuration& c) { return c.preset; }};
}

ConfigurationKey python_key() {
  auto set = [](Configuration& c, const std::string& text) {
    const auto json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object()) {
      throw std::invalid_argument(fmt::format("'{}' is not a JSON object", text));
    }
    c.python_options = text;
  };
  return {"python.options", "arguments of a Python estimator's class, a JSON object", set,
          [](const Configuration& c) { return c.python_options; }};
}

// Those of rows from a user's own program.
std::vector<ConfigurationKey> own_keys() {
  std::vector<ConfigurationKey> keys;
  for (const auto& [name, value] : own_numbers()) {
    const auto field = [key = name](auto& c) -> auto& { return c.model.classifier.own.at(key); };
    keys.push_back(number(name, "a number of this program's own", kFinite, field));
  }
  return keys;
}

#undef SLAMMOT_FIELD

}  // namespace

const std::vector<ConfigurationKey>& configuration_keys() {
  static const std::vector<ConfigurationKey> keys = [] {
    std::vector<ConfigurationKey> all = {preset_key()};
    append(all, model_keys());
    append(all, statement_keys());
    append(all, estimator_keys());
    all.push_back(python_key());
    append(all, own_keys());
    return all;
  }();
  return keys;
}

}  // namespace slammot
