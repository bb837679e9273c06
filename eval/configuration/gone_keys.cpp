// Keys and values of the configuration that are gone, and what to write instead.
#include <fmt/format.h>

#include <stdexcept>

#include "eval/configuration/configuration.h"

namespace slammot {
namespace {

struct Gone {
  std::string_view was;  // KEY, or KEY=VALUE
  std::string_view use;  // what to write, or after "nothing: " why there is nothing

  bool is_replaced() const { return !use.starts_with("nothing"); }
};

constexpr Gone kGone[] = {
    {"classifier.hidden_speed", "classifier.decisive_odds"},
    {"classifier.moving_factor", "classifier.decisive_odds"},
    {"classifier.static_factor", "classifier.decisive_odds"},
    {"classifier=bayes_factor", "classifier=odds"},
    {"ekf.deferred", "nothing: every update is of the whole map"},
    {"ekf.equivariant_scale", "gauge (scale; false: none)"},
    {"ekf.gauge", "gauge, of both families"},
    {"ekf.linearisation=invariant", "gauge=heading"},
    {"ekf.static_enough", "policy.movers (considered: as with 12; joint: as with 0)"},
    {"frames.step", "nothing: a sequence has the frames that it is to be judged by"},
    {"initial.angular_velocity_sigma", "the sequence's initial.yaml"},
    {"initial.velocity_sigma", "the sequence's initial.yaml"},
    {"labels.first_frame", "labels.births (odds: held; static: static_first; unknown: free)"},
    {"labels.pooled", "nothing: each point is labelled by itself"},
    {"labels.probability", "labels (reversible, one_way)"},
    {"labels.start", "labels.births (held, static_first)"},
    {"labels.start_over", "labels.births (held: what a label did is undone in the frame in hand)"},
    {"labels.window", "labels (reversible, one_way)"},
    {"policy.lost_after", "policy.prune_after"},
    {"policy.missed_after", "policy.prune_after, of which a static landmark has six times"},
    {"policy.probation", "nothing: a track is a landmark from its first measurement on"},
    {"policy.prune_missed_after", "policy.prune_after, of which a static landmark has six times"},
    {"policy.retain",
     "nothing: the landmark unseen longest leaves when policy.max_landmarks is reached"},
    {"prior.source=map", "empirical"},
    {"prior.source=stated", "fixed"},
    {"window.linearisation=ideal", "ekf.linearisation=ideal"},
    {"window.loss", "gate.probability and gate.given_others"},
    {"window.prior", "nothing: what is known of a landmark is kept"},
    {"window.retest", "gate.given_others"},
};

}  // namespace

void refuse_gone(const Assignment& assignment) {
  const std::string setting = assignment.key + "=" + assignment.value;
  for (const Gone& gone : kGone) {
    if (assignment.key != gone.was && setting != gone.was) continue;
    throw std::invalid_argument(
        fmt::format("'{}' is gone: {}{}", gone.was, gone.is_replaced() ? "use " : "", gone.use));
  }
}

}  // namespace slammot
