// An experiment: each unknown landmark is in the state twice, as a free one (its track) and as a
// static one (~track, its twin). Both see the measurement; what it says to the rest of the state is
// shared out by the odds of the two hypotheses, the likelihood of each to the power of its
// probability, so that one measurement counts once. From static_factor on the twin takes the track
// over, below moving_factor it goes.
#include <cmath>

#include "slammot/filters/ekf_estimator.h"

namespace slammot {

void Ekf::weigh() {
  std::map<int, double> log_likelihood;
  for (std::size_t i = 0; i < gate_.measured.size(); ++i) {
    log_likelihood[gate_.measured[i].track] = gate_.log_likelihood[i];
  }
  for (const auto& [track, of_free] : log_likelihood) {
    const auto of_static = log_likelihood.find(~track);
    if (track < 0 || of_static == log_likelihood.end()) continue;
    state_.landmarks.at(track).record.static_odds += of_static->second - of_free;
  }
  auto P_Ht = *innovation_.P_Ht;
  for (std::size_t i = 0; i < innovation_.matches.size(); ++i) {
    const int track = innovation_.matches[i].track;
    if (!state_.landmarks.contains(~track)) continue;
    const int real = track < 0 ? ~track : track;
    const double odds = state_.landmarks.at(real).record.static_odds;
    const double weight = 1.0 / (1.0 + std::exp(track < 0 ? -odds : odds));
    const double root = std::sqrt(std::max(weight, 1e-6));
    innovation_.nu[i] *= root;
    innovation_.predicted[i].J_pose *= root;
    innovation_.predicted[i].J_anchor *= root;
    innovation_.predicted[i].J_y *= root;
    P_Ht.middleCols<2>(static_cast<Eigen::Index>(2 * i)) *= root;
  }
}

void Ekf::drop_twin(int track) { state_.remove_landmarks({~track}); }

void Ekf::adopt_twin(int track) {
  const TrackRecord record = state_.landmarks.at(track).record;
  state_.remove_landmarks({track});
  auto node = state_.landmarks.extract(~track);
  node.key() = track;
  node.mapped().record = record;
  state_.landmarks.insert(std::move(node));
}

}  // namespace slammot
