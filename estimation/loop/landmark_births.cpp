// How landmarks enter: those known beforehand before a frame's update, others after it.
#include <algorithm>
#include <cmath>

#include "estimation/loop/landmark_manager.h"
#include "estimation/modules/births.h"

namespace slammot {

// Before the update, so that their first pixel counts as well. What was stated counts once: a known
// landmark that was pruned starts anew as an unknown one.
void LandmarkManager::add_known(const Frame& frame, Belief& belief, FrameReport& report) {
  if (!first_frame_) first_frame_ = frame.index;
  for (const Observation& z : frame.observations) {
    const auto known = known_.find(z.track);
    if (known == known_.end() || holds(z.track)) continue;
    belief.add_known(known->second);
    TrackRecord& record = records_[z.track] =
        initialised(z.track, frame.index, Label::kStatic, setup_.prior);
    record.known = record.by_rule = true;
    record.observations = 0;
    known_.erase(known);
    ++report.admitted;
  }
}

// What this frame says of a landmark that enters with it, and of its motion with `prior`.
FirstSight LandmarkManager::first_sight_of(const Frame& frame, const Observation& z,
                                           LandmarkPrior& prior) const {
  FirstSight seen = first_pixel(z, prior);
  const auto depth = z.has_depth() ? prior_of_depth(setup_.camera, z) : std::nullopt;
  const auto others = std::ranges::equal_range(frame.other_views, z.track, {}, &Observation::track);
  if (!depth && others.empty()) return seen;
  seen = first_sight(rig_, setup_.pixel_sigma, z, {others.begin(), others.end()},
                     depth.value_or(seen.prior), pixel_threshold(models_.gate.given_others));
  if (!seen.has_own_depth) return seen;
  const bool is_pair = !seen.others.empty();
  prior.inverse_depth = is_pair ? seen.inverse_depth : seen.prior.inverse_depth;
  prior.inverse_depth_sigma = is_pair ? std::sqrt(seen.covariance(2, 2)) : seen.prior.sigma;
  prior.mean_sigma = 0.0;
  return seen;
}

// Thesis 2.1.3: undelayed, at the first pixel.
void LandmarkManager::initialise_new(const Frame& frame, int visible, Belief& belief,
                                     FrameReport& report) {
  unmatched_.clear();
  for (const Observation& z : frame.observations) {
    if (!holds(z.track)) unmatched_.push_back(z);
  }
  const std::size_t wanted = births_wanted(visible, models_.policy);
  if (unmatched_.size() > wanted) unmatched_.resize(wanted);
  make_room(records_, unmatched_.size(), models_.policy, tracks_);
  remove(belief, report);
  const auto most = static_cast<std::size_t>(models_.policy.max_landmarks);
  tracks_.clear();
  for (const Observation& z : unmatched_) {
    if (records_.size() >= most) break;
    LandmarkPrior prior = depth_prior_.of_new();
    const FirstSight seen = first_sight_of(frame, z, prior);
    TrackRecord record =
        record_at_birth(z.track, frame.index, frame.index == first_frame_,
                        classifier_->at_birth(z.track), outside_.births(z.track, births_), prior);
    if (!belief.add(seen, prior, !rests(record) || record.is_held)) continue;
    if (record.is_held) tracks_.push_back(z.track);
    with_odds_ += outside_.speaks_of(z.track) ? 1 : 0;
    records_[z.track] = std::move(record);
    ++report.admitted;
  }
  held_ += std::ssize(tracks_);
  collapse(tracks_, belief);
}

}  // namespace slammot
