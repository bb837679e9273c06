#include "estimation/loop/frame_loop.h"

#include <algorithm>
#include <iterator>

namespace slammot {

namespace {

// In one frame, so that its time is bounded. What is still wrong waits for the next.
constexpr int kMostRevisions = 10;

// Frames that are processed again, in units of those that the first labels are open for: in one
// frame and in a run. `circle` and `square` need one and five, the desk among the recordings three
// and fifteen.
constexpr int kMostAnewInAFrame = 4, kMostAnew = 25;

}  // namespace

FrameLoop::FrameLoop(const Setup& setup, const ModelOptions& models, MakeBelief make_belief,
                     std::shared_ptr<const Truth> truth_for_view)
    : setup_(setup),
      models_(models),
      make_belief_(std::move(make_belief)),
      truth_for_view_(std::move(truth_for_view)),
      first_(models.labels),
      point_(find_point(models.point)),
      gate_(models.gate, setup.pixel_sigma),
      noise_(setup.camera_noise, false) {
  start();
}

void FrameLoop::start() {
  belief_ = make_belief_();
  manager_ = std::make_unique<LandmarkManager>(setup_, models_, first_, truth_for_view_);
  // A covariance at the truth must not depend on the estimate.
  noise_ = AdaptiveNoise(setup_.camera_noise, models_.adaptive_motion && !truth_for_view_);
  timestamp_.reset();
}

FrameReport FrameLoop::process(const Frame& frame, StageListener& stages) {
  if (timestamp_ && !(frame.timestamp > *timestamp_)) {
    throw std::invalid_argument("the time of a frame must be later than that of the one before");
  }
  first_.begin(frame);
  if (first_.frames().empty()) return advance(frame, stages);
  const TrackRecords before = manager_->records();
  FrameReport report = advance(frame, stages);
  const int frames = static_cast<int>(first_.frames().size());
  const int unit = std::max(models_.labels.start, models_.labels.start_over);
  const int most = std::min(kMostAnewInAFrame * unit, kMostAnew * unit - anew_);
  for (int k = 1; k <= kMostRevisions && k * frames <= most; ++k) {
    if (!first_.revise(manager_->records())) break;
    anew_ += frames;
    report = start_over(before, stages);
  }
  if (anew_ + frames > kMostAnew * unit) first_.close();
  return report;
}

// What is reported of the frames before is the end of those landmarks that were in the state
// `before`.
FrameReport FrameLoop::start_over(const TrackRecords& before, StageListener& stages) {
  start();
  FrameReport report;
  std::vector<LandmarkEstimate> retired;
  for (const Frame& frame : first_.frames()) {
    const bool is_newest = &frame == &first_.frames().back();
    report = advance(frame, stages);
    std::ranges::copy_if(report.retired, std::back_inserter(retired), [&](const auto& landmark) {
      return is_newest || before.contains(landmark.track);
    });
  }
  report.retired = std::move(retired);
  return report;
}

FrameReport FrameLoop::advance(const Frame& frame, StageListener& stages) {
  FrameReport report;
  stages.begin("predict");
  manager_->retire_leaving(*belief_, report);
  const double dt = time_since_last(frame);
  const bool learns_noise = noise_.adapts() && dt > 0.0;
  const CameraEstimate before = learns_noise ? belief_->camera() : CameraEstimate{};
  belief_->predict(frame, dt, noise_.of_next(), manager_->records());
  manager_->add_known(frame, *belief_, report);
  manager_->end_probation(frame, *belief_, report);

  stages.begin("gate");
  gate(frame, dt, report);

  if (keeps_predictions_) {
    stages.begin(StageListener::kPredictions);
    note_predictions(report);
  }

  stages.begin("update");
  belief_->update(manager_->records(), accepted_, stages);

  // Before labels change: these are marginals of the update.
  stages.begin("marginals");
  if (learns_noise) noise_.learn(before, belief_->camera(), dt);
  if (manager_->watches_innovations()) {
    belief_->leave_one_out(given_others_);
    manager_->note_innovations(given_others_);
    manager_->note_innovations(rejected_);
  }
  manager_->look_at_depths(accepted_, *belief_);

  stages.begin("classify");
  manager_->record(frame.index, accepted_, unused_);
  const std::vector<int>& now_static = manager_->classify(frame.index, accepted_, *belief_);
  stages.begin("collapse");
  if (!now_static.empty()) belief_->collapse(now_static);
  manager_->revert_labels(in_view_, *belief_);

  stages.begin("manage");
  manager_->prune(frame.index, *belief_, report);
  manager_->initialise_new(frame, *belief_, report);
  belief_->finish();

  // Of what the frame leaves behind, like the size of the state.
  report.state_size = belief_->state_size();
  belief_->points(points_);
  report.negative_inverse_depth = static_cast<int>(std::ranges::count_if(
      points_, [&](const LandmarkPoint& p) { return point_.inverse_depth(p.y) < 0.0; }));
  return report;
}

double FrameLoop::time_since_last(const Frame& frame) {
  const double dt = timestamp_ ? frame.timestamp - *timestamp_ : 0.0;
  timestamp_ = frame.timestamp;
  return dt;
}

void FrameLoop::gate(const Frame& frame, double dt, FrameReport& report) {
  measured_.clear();
  in_view_.clear();
  accepted_.clear();
  rejected_.clear();
  unused_.clear();
  for (const Observation& z : frame.observations) {
    if (manager_->knows(z.track)) measured_.push_back(z);
  }
  belief_->innovations(measured_, innovation_);
  gate_.sort(innovation_);
  // What has entered at this frame's camera would not move with it.
  if (noise_.adapts() && dt > 0.0) follow_jolt(report.admitted == 0);
  for (std::size_t i = 0; i < innovation_.z.size(); ++i) {
    const Observation& z = innovation_.z[i];
    in_view_.push_back(z);
    if (gate_.accepts(i)) {
      accepted_.push_back(z);
      report.accepted_static += manager_->records().at(z.track).label == Label::kStatic ? 1 : 0;
      report.nis_sum += gate_.nis(i);
    } else {
      unused_.push_back(z.track);
      const double moved = moved_px(manager_->records().at(z.track), setup_.camera, dt);
      if (!gate_.accepts_moved(innovation_, i, moved)) continue;
      rejected_.push_back(
          {z.track, gate_.accepts_alone(i) ? gate_.nis_given_others(i) : gate_.nis(i)});
    }
  }
  report.joint_nis = gate_.joint_nis();
  report.accepted = static_cast<int>(accepted_.size());
  report.rejected = static_cast<int>(unused_.size());
  report.out_of_view = static_cast<int>(measured_.size() - in_view_.size());
  auto expected = in_view_.begin();
  for (const Observation& z : measured_) {
    if (expected != in_view_.end() && expected->track == z.track) {
      ++expected;
    } else {
      unused_.push_back(z.track);
    }
  }
}

// The camera's step may have been noisier than was predicted (adaptive_noise.h).
void FrameLoop::follow_jolt(bool may_widen) {
  const Agreement predicted = agreement();
  const double factor = AdaptiveNoise::jolt(predicted.median_nis);
  bool most_agree = predicted.most_agree;
  if (factor > 1.0 && may_widen) {
    scale_step(factor);
    most_agree = agreement().most_agree;
    if (!most_agree) scale_step(1.0 / factor);
  }
  if (most_agree) noise_.note(predicted.median_nis);
}

void FrameLoop::scale_step(double factor) {
  belief_->widen(factor);
  belief_->innovations(measured_, innovation_);
  gate_.sort(innovation_);
}

FrameLoop::Agreement FrameLoop::agreement() {
  nis_.clear();
  nis_of_agreed_.clear();
  for (std::size_t i = 0; i < innovation_.z.size(); ++i) {
    if (manager_->records().at(innovation_.z[i].track).label != Label::kStatic) continue;
    nis_.push_back(gate_.nis(i));
    if (gate_.agrees(i)) nis_of_agreed_.push_back(gate_.nis(i));
  }
  if (nis_.size() < kQuorum) return {};
  const std::size_t agreed = nis_of_agreed_.size();
  const bool most_agree = agreed >= kQuorum && 2 * agreed > nis_.size();
  std::vector<double>& of = most_agree ? nis_of_agreed_ : nis_;
  const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
  std::ranges::nth_element(of, middle);
  return {most_agree, *middle};
}

// Of what was measured as the gate had them, of the rest those in the image.
void FrameLoop::note_predictions(FrameReport& report) {
  for (std::size_t i = 0; i < innovation_.z.size(); ++i) {
    const Observation& z = innovation_.z[i];
    report.predictions.push_back({z.track, z.pixel - innovation_.nu[i], gate_.S(i),
                                  gate_.accepts(i) ? Measured::kAccepted : Measured::kRejected});
  }
  std::vector<int> others;
  for (const auto& [track, record] : manager_->records()) {
    if (!std::ranges::binary_search(measured_, track, {}, &Observation::track)) {
      others.push_back(track);
    }
  }
  std::vector<Prediction> expected;
  belief_->predict_pixels(others, expected);
  for (Prediction& p : expected) p.S.diagonal().array() += setup_.pixel_sigma * setup_.pixel_sigma;
  std::ranges::copy_if(expected, std::back_inserter(report.predictions),
                       [&](const Prediction& p) { return setup_.camera.in_image(p.pixel); });
  std::erase_if(report.predictions, [](const Prediction& p) { return !p.S.allFinite(); });
  std::ranges::sort(report.predictions, {}, &Prediction::track);
}

CameraEstimate FrameLoop::camera() const {
  CameraEstimate camera = belief_->camera();
  camera.timestamp = timestamp_.value_or(0.0);
  return camera;
}

std::vector<LandmarkEstimate> FrameLoop::landmarks() const {
  std::vector<int> tracks;
  for (const auto& [track, record] : manager_->records()) tracks.push_back(track);
  return manager_->estimates(tracks, *belief_);
}

std::vector<LandmarkEstimate> FrameLoop::landmarks_measured(int index) const {
  std::vector<int> tracks;
  for (const auto& [track, record] : manager_->records()) {
    if (record.last_frame == index) tracks.push_back(track);
  }
  return manager_->estimates(tracks, *belief_);
}

}  // namespace slammot
