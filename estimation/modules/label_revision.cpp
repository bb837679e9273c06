#include "estimation/modules/label_revision.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "models/chi_square.h"

namespace slammot {

namespace {

constexpr int kInnovations = 10;       // the latest, in the test of a label
constexpr double kProbability = 1e-4;  // of a right label being rejected in a frame
constexpr int kMostUnseen = 5;         // frames, and a motion is forgotten
// Found to move in a frame. The others are asked again when its measurements and the next ones'
// have been seen without them: more at once are lost where a whole scene looks moving because the
// camera is wrong. Of those that are only in doubt half of what rests may go: the first go with
// little evidence, and without them less is known of the others.
constexpr int kMostReleases = 3;
// Posterior over prior odds of rest.
constexpr double kBeyondDoubt = 1e4;
constexpr double kInDoubt = 3.0;

// How far a motion is from rest, in sigmas; and where it says nothing, how clearly innovations
// reject the label. Motions of landmarks that were never measured are at rest but for rounding.
using Evidence = std::pair<double, double>;
Evidence evidence_of(const MotionBelief& motion, const TrackRecord& record) {
  constexpr double kRounding = 1e-6;
  const double distance = mahalanobis_from_zero(motion.w, motion.covariance);
  return {distance > kRounding ? distance : 0.0, -log_tail(record)};
}

// Held at its birth, and its measurements do not speak for rest. A mover that is held until the
// classifier is sure bends the map, and where little else holds the camera that makes what rests
// look moving: no later release mends what was linearised there.
bool is_in_doubt(const TrackRecord& record, const MotionBelief& motion) {
  if (!record.is_held || record.observations < 2) return false;
  const auto log_ratio = log_odds_ratio_of_rest(motion);
  return log_ratio && *log_ratio + motion.outside < std::log(kInDoubt);
}

bool is_rejected(const TrackRecord& record, const MotionAnswer& answer) {
  return answer.label == Label::kMoving || is_rejected(record);
}

// Of the remembered motions that reject their label or are in doubt, as far as these are asked for,
// the one whose evidence is the clearest.
struct Release {
  std::size_t index = 0;
  bool is_rejected = false;
};
std::optional<Release> most_significant(const TrackRecords& records,
                                        const RememberedMotions& motions, const AskMotion& ask,
                                        bool with_rejected, bool with_doubted) {
  std::optional<Release> result;
  Evidence most;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const auto answer = ask(i);
    if (!answer) continue;
    const TrackRecord& record = records.at(motions.track(i));
    const bool rejected = is_rejected(record, *answer);
    const bool doubted = with_doubted && is_in_doubt(record, answer->motion);
    if (rejected ? !with_rejected : !doubted) continue;
    const Evidence evidence = evidence_of(answer->motion, record);
    if (result && evidence <= most) continue;
    most = evidence;
    result = {i, rejected};
  }
  return result;
}

bool reversible(const LabelOptions& options) { return options.rule == LabelRule::kReversible; }

}  // namespace

std::string why_no_memory(const ModelOptions& models, const LandmarkFunctions& landmark) {
  if (!reversible(models.labels)) return "labels=one_way";
  if (models.collapse != Collapse::kCondition) return "collapse=drop";
  if (!landmark.can_move || landmark.motion != 3) {
    return "landmark=" + std::string(landmark.name);
  }
  return models.policy.delayed ? "estimator delayed" : "";
}

int motion_memory(const ModelOptions& models, const LandmarkFunctions& landmark) {
  return why_no_memory(models, landmark).empty() ? models.labels.memory : 0;
}

bool is_forgotten(const TrackRecord& record, int memory) {
  const bool is_old = record.remembered_frames >= memory && !record.is_held;
  return record.rests_beyond_doubt || is_old || record.unused_frames >= kMostUnseen;
}

void note_motion(TrackRecord& record, const MotionBelief& motion) {
  const auto log_ratio = log_odds_ratio_of_rest(motion);
  if (log_ratio && *log_ratio > std::log(kBeyondDoubt)) record.rests_beyond_doubt = true;
}

bool watches_innovations(const LabelOptions& options) { return reversible(options); }

bool is_asked(const TrackRecord& record, const LabelOptions& options) {
  if (record.observations < options.sightings || record.is_held) return false;
  return record.label == Label::kUnknown || (reversible(options) && record.label == Label::kMoving);
}

void note_answer(TrackRecord& record, Label answer, int frame) {
  if (record.label == Label::kMoving && answer != Label::kStatic) return;
  note_decision(record, answer, frame);
}

void note_innovation(TrackRecord& record, double nis, const LabelOptions& options, int pixels) {
  if (!reversible(options) || !rests(record) || record.known) return;
  std::vector<double>& kept = record.static_nis;
  kept.reserve(kInnovations);
  if (std::ssize(kept) == kInnovations) kept.erase(kept.begin());
  kept.push_back(as_of_one_pixel(nis, pixels));
}

double moved_px(const TrackRecord& record, const Camera& camera, double dt) {
  constexpr double kNear = 2.0;  // sigmas of the inverse depth
  const LandmarkPrior& prior = record.prior;
  const double near = prior.inverse_depth + kNear * prior.inverse_depth_sigma;
  const double metres = prior.velocity_sigma() * dt * (record.unused_frames + 1);
  return std::max(camera.fx, camera.fy) * near * metres;
}

double log_tail(const TrackRecord& record) {
  const std::vector<double>& nis = record.static_nis;
  return log_chi_square_tail(std::accumulate(nis.begin(), nis.end(), 0.0),
                             static_cast<int>(nis.size()));
}

void note_depth(TrackRecord& record, const SeenDepth& depth, const LabelOptions& options) {
  constexpr double kBehind = 5.0;  // [sigma]
  if (!reversible(options) || record.known) return;
  record.is_behind = depth.inverse_depth < -kBehind * depth.sigma;
}

bool is_rejected(const TrackRecord& record) {
  if (record.is_behind) return true;
  if (record.static_nis.size() < 2) return false;  // a single outlier is the gate's business
  return log_tail(record) < std::log(kProbability);
}

void find_undoing(const TrackRecords& records, std::span<const int> tracks,
                  RememberedMotions& motions, const AskMotion& ask, Undoing& result) {
  result.free.clear();
  result.release.clear();
  int rejected = 0, doubted = 0;
  for (;;) {
    const auto most = most_significant(records, motions, ask, rejected < kMostReleases,
                                       2 * (doubted + 1) <= std::ssize(tracks));
    if (!most || !motions.release(most->index)) break;
    result.release.push_back(motions.track(most->index));
    ++(most->is_rejected ? rejected : doubted);
  }
  for (const int track : tracks) {
    const bool is_remembered = std::ranges::count(motions.tracks(), track) > 0;
    if (!is_remembered && is_rejected(records.at(track))) result.free.push_back(track);
  }
}

void note_reverted(TrackRecord& record) {
  record.label = Label::kUnknown;
  record.cannot_rest = record.cannot_rest || record.is_behind;
  record.is_behind = record.is_held = false;
  record.decision_frame.reset();
  record.rejected_in_row = 0;
  record.static_nis.clear();
  record.classifier_memory.clear();
  record.is_remembered = record.rests_beyond_doubt = false;
}

}  // namespace slammot
