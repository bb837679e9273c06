#include "eval/study/summary/study_landmarks.h"

#include "eval/output/metrics_json.h"
#include "eval/pooling/estimate_json.h"
#include "eval/statistics/statistics.h"

namespace slammot {

namespace {

using Json = nlohmann::ordered_json;

void append(const Json& values, std::vector<double>& to) {
  for (const Json& v : values) to.push_back(number(v));
}

Json quartiles(const std::vector<double>& s) {
  return {{"count", s.size()},          {"q05", quantile(s, 0.05)}, {"q25", quantile(s, 0.25)},
          {"median", quantile(s, 0.5)}, {"q75", quantile(s, 0.75)}, {"q95", quantile(s, 0.95)}};
}

Json nees_json(const std::vector<RunSum>& runs) {
  double count = 0.0;
  for (const RunSum& r : runs) count += r.count;
  if (count == 0.0) return nullptr;
  const Estimate e = bootstrap_mean(runs);
  return {{"mean", e.value}, {"count", count}, {"lower", e.lower}, {"upper", e.upper}};
}

}  // namespace

void LandmarkAges::add(const Json& landmarks) {
  for (const Json& a : landmarks) {
    Age& age = ages_[count_of(a.at("observations"))];
    append(a.at("static_position_m"), age.statics);
    append(a.at("moving_position_m"), age.movings);
    append(a.at("moving_velocity_m_s"), age.velocities);
    age.position_nees.push_back(run_sum(a.at("nees_position_mean"), a.at("nees_position_count")));
    age.velocity_nees.push_back(run_sum(a.at("nees_velocity_mean"), a.at("nees_velocity_count")));
  }
}

Json LandmarkAges::json() const {
  Json json = Json::array();
  for (const auto& [observations, age] : ages_) {
    json.push_back({{"observations", observations},
                    {"static_position_m", quartiles(age.statics)},
                    {"moving_position_m", quartiles(age.movings)},
                    {"moving_velocity_m_s", quartiles(age.velocities)},
                    {"nees_position", nees_json(age.position_nees)},
                    {"nees_velocity", nees_json(age.velocity_nees)}});
  }
  return json;
}

void RecordedTracks::add(const Json& tracks) {
  for (const Json& t : tracks) {
    auto& moments = tracks_[count_of(t.at("track"))];
    for (std::size_t i = 0; i < t.at("frame").size(); ++i) {
      Moment& moment = moments[count_of(t["frame"].at(i))];
      const Json& truth = t.at("truth").at(i);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        moment.velocity[axis].push_back(number(t.at("velocity").at(i).at(axis)));
        moment.sigma[axis].push_back(number(t.at("sigma").at(i).at(axis)));
        moment.truth[axis].push_back(truth.is_null() ? kUndefined : number(truth.at(axis)));
      }
    }
  }
}

Json RecordedTracks::json() const {
  Json json = Json::array();
  for (const auto& [id, moments] : tracks_) {
    Json one = {{"track", id}};
    for (const char* key : {"frame", "velocity", "spread", "sigma", "truth"}) {
      one[key] = Json::array();
    }
    for (const auto& [frame, moment] : moments) {
      Json velocity, spread, sigma, truth;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::vector<double>& v = moment.velocity[axis];
        velocity.push_back(median(v));
        spread.push_back({quantile(v, 0.05), quantile(v, 0.95)});
        sigma.push_back(median(moment.sigma[axis]));
        truth.push_back(median(moment.truth[axis]));
      }
      one["frame"].push_back(frame);
      one["velocity"].push_back(velocity);
      one["spread"].push_back(spread);
      one["sigma"].push_back(sigma);
      one["truth"].push_back(truth);
    }
    json.push_back(one);
  }
  return json;
}

}  // namespace slammot
