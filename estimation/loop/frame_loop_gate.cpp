// The gate of a frame, in the loop: which of its measurements are used, whether the camera was
// jolted, and what was expected of each landmark.
#include <algorithm>
#include <iterator>

#include "estimation/loop/frame_loop.h"

namespace slammot {

namespace {

// Of a measurement or a prediction.
constexpr auto kView = [](const auto& z) { return std::pair(z.track, z.camera); };

// Of observations by track, the first of each.
void first_of_each(std::span<const Observation> all, std::vector<Observation>& result) {
  result.clear();
  std::ranges::unique_copy(all, std::back_inserter(result), {}, &Observation::track);
}

}  // namespace

// Of all cameras, by track and camera.
void FrameLoop::find_measured(const Frame& frame) {
  measured_.clear();
  for (const auto* of : {&frame.observations, &frame.other_views}) {
    for (const Observation& z : *of) {
      if (manager_.holds(z.track)) measured_.push_back(z);
    }
  }
  if (!frame.other_views.empty()) std::ranges::sort(measured_, {}, kView);
}

void FrameLoop::gate(const Frame& frame, double dt, FrameReport& report) {
  find_measured(frame);
  belief_->innovations(measured_, innovation_);
  gate_.judge(innovation_);
  // What has entered at this frame's camera would not move with it.
  if (noise_.adapts() && dt > 0.0) follow_jolt(report.admitted == 0);
  split_by_gate(dt, report);
}

void FrameLoop::split_by_gate(double dt, FrameReport& report) {
  in_view_.clear();
  accepted_.clear();
  explained_by_motion_.clear();
  unused_.clear();
  for (std::size_t i = 0; i < innovation_.z.size(); ++i) {
    const Observation& z = innovation_.z[i];
    in_view_.push_back(z);
    if (gate_.accepts(i)) {
      accepted_.push_back(z);
      report.accepted_static += rests(manager_.records().at(z.track)) ? 1 : 0;
      report.nis_sum += gate_.nis(i);
      lasting_.add(z.track, z.camera, manager_.records().at(z.track).first_frame,
                   gate_.scaled_given_others(i));
      continue;
    }
    refused_by_others_ += gate_.accepts_alone(i) && !gate_.agrees(i) ? 1 : 0;
    const double moved = moved_px(manager_.records().at(z.track), setup_.camera, dt);
    if (!gate_.accepts_moved(innovation_, i, moved)) continue;
    // Given the others; of one that failed on its own already, that one.
    const double nis = gate_.accepts_alone(i) ? gate_.nis_given_others(i) : gate_.nis(i);
    explained_by_motion_.push_back({z.track, nis});
  }
  report.joint_nis = gate_.joint_nis();
  const LastingErrors::Ended lasting = lasting_.take(manager_.records());
  report.lasting_sums = lasting.sums;
  report.lasting_nis = lasting.nis;
  report.accepted = static_cast<int>(accepted_.size());
  report.rejected = static_cast<int>(in_view_.size() - accepted_.size());
  report.out_of_view = static_cast<int>(measured_.size() - in_view_.size());
  sort_landmarks();
  drop_explained_of_used();
}

// By landmark what split_by_gate() has by measurement: used, in view, unused (rejected first).
void FrameLoop::sort_landmarks() {
  first_of_each(accepted_, used_);
  first_of_each(in_view_, landmarks_in_view_);
  first_of_each(measured_, landmarks_measured_);
  const auto without = [this](const std::vector<Observation>& all, const auto& used) {
    for (const Observation& z : all) {
      if (!std::ranges::binary_search(used, z.track, {}, &Observation::track)) {
        unused_.push_back(z.track);
      }
    }
  };
  without(landmarks_in_view_, used_);
  without(landmarks_measured_, landmarks_in_view_);
}

void FrameLoop::drop_explained_of_used() {
  // What one camera of a rig sees and another does not is a wrong match.
  std::erase_if(explained_by_motion_, [this](const LeaveOneOut& z) {
    return std::ranges::binary_search(used_, z.track, {}, &Observation::track);
  });
  const auto is_again = [](const LeaveOneOut& a, const LeaveOneOut& b) {
    return a.track == b.track;
  };
  explained_by_motion_.erase(
      std::unique(explained_by_motion_.begin(), explained_by_motion_.end(), is_again),
      explained_by_motion_.end());
}

// The camera's step may have been noisier than was predicted (camera_noise.h).
void FrameLoop::follow_jolt(bool may_widen) {
  const Agreement predicted = agreement();
  const double factor = AdaptiveCameraNoise::jolt(predicted.median_nis);
  bool most_agree = predicted.most_agree;
  if (factor > 1.0 && may_widen) {
    scale_step(factor);
    most_agree = agreement().most_agree;
    if (!most_agree) scale_step(1.0 / factor);
    widened_ += most_agree ? 1 : 0;
  }
  if (most_agree) noise_.note(predicted.median_nis);
}

void FrameLoop::scale_step(double factor) {
  belief_->widen(factor);
  belief_->innovations(measured_, innovation_);
  gate_.judge(innovation_);
}

FrameLoop::Agreement FrameLoop::agreement() {
  nis_.clear();
  nis_of_agreed_.clear();
  for (std::size_t i = 0; i < innovation_.z.size(); ++i) {
    if (!rests(manager_.records().at(innovation_.z[i].track))) continue;
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

// Of what was measured as the gate had them; of the rest, and of what camera 0 did not measure,
// those in its image.
void FrameLoop::note_predictions(FrameReport& report) {
  for (std::size_t i = 0; i < innovation_.z.size(); ++i) {
    const Observation& z = innovation_.z[i];
    report.predictions.push_back({z.track, z.pixel - innovation_.nu[i], gate_.S(i),
                                  gate_.accepts(i) ? Measured::kAccepted : Measured::kRejected,
                                  z.camera});
  }
  std::vector<int> others;
  for (const auto& [track, record] : manager_.records()) {
    if (!std::ranges::binary_search(measured_, std::pair(track, 0), {}, kView)) {
      others.push_back(track);
    }
  }
  std::vector<Prediction> expected;
  belief_->predict_pixels(others, expected);
  for (Prediction& p : expected) p.S.diagonal().array() += setup_.pixel_sigma * setup_.pixel_sigma;
  std::ranges::copy_if(expected, std::back_inserter(report.predictions),
                       [&](const Prediction& p) { return setup_.camera.in_image(p.pixel); });
  std::erase_if(report.predictions, [](const Prediction& p) { return !p.S.allFinite(); });
  std::ranges::sort(report.predictions, {}, kView);
}

}  // namespace slammot
