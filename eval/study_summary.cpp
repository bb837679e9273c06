#include "slammot/eval/study_summary.h"

#include <cmath>
#include <fstream>
#include <map>

#include "slammot/eval/bootstrap.h"
#include "slammot/eval/chi_square.h"
#include "slammot/eval/statistics.h"
#include "slammot/models/estimator.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;
using Samples = std::vector<double>;

// A cell that only gives the Cramer-Rao bound of its group, and takes part in no comparison.
constexpr std::string_view kBound = "bound";

constexpr const char* kCounts[] = {"static", "moving", "static_often_seen", "moving_often_seen"};

double number(const Json& json) { return json.is_number() ? json.get<double>() : kUndefined; }

Json json_of(const Estimate& e) {
  return {{"value", e.value}, {"lower", e.lower}, {"upper", e.upper}, {"runs", e.samples}};
}

Json quartiles(const Samples& s) {
  return {{"count", s.size()},          {"q05", quantile(s, 0.05)}, {"q25", quantile(s, 0.25)},
          {"median", quantile(s, 0.5)}, {"q75", quantile(s, 0.75)}, {"q95", quantile(s, 0.95)}};
}

// Samples of every frame over the runs.
using ByFrame = std::map<int, Samples>;

void gather(const Json& frames, const char* what, ByFrame& into) {
  const Json& index = frames.at("frame");
  const Json& values = frames.at(what);
  for (std::size_t i = 0; i < index.size(); ++i) {
    into[index[i].get<int>()].push_back(number(values[i]));
  }
}

// A NEES that is not finite belongs to a covariance that is none.
double finite_or_infinite(double x) { return std::isnan(x) ? INFINITY : x; }

struct Nees {
  Json per_frame = Json::array();
  double mean = kUndefined;    // over frames and runs
  double inside = kUndefined;  // part of the frames inside their two-sided 95% interval
  double worst = kUndefined;   // largest of a frame
};

Nees anees(const ByFrame& frames, int dof) {
  Nees result;
  Samples means;
  double inside = 0.0;
  for (const auto& [frame, samples] : frames) {
    Samples values;
    for (const double x : samples) values.push_back(finite_or_infinite(x));
    const double value = mean(values);
    const Interval interval = nees_interval(dof, static_cast<int>(values.size()));
    inside += value >= interval.lower && value <= interval.upper;
    means.push_back(value);
    result.per_frame.push_back(value);
  }
  result.mean = mean(means);
  result.worst = maximum(means);
  result.inside = inside / static_cast<double>(frames.size());
  return result;
}

// The runs of one cell, taken one by one.
class Cell {
 public:
  explicit Cell(const StudyCell& cell) : cell_(cell) {}

  void add(const Json& run);
  void add_timing(const Json& timing);
  Json json() const;

  // By seed: RMSE over the run, infinite of a run that diverged.
  std::map<std::uint64_t, double> position_rmse;

 private:
  void add_landmarks(const Json& ages);
  void add_tracks(const Json& tracks);
  Json per_frame() const;
  Json by_age() const;
  Json tracks_json() const;

  struct Age {
    Samples statics, movings, velocities;
    double position_sum = 0.0, velocity_sum = 0.0;
    int position_count = 0, velocity_count = 0;
  };
  struct Track {
    std::map<int, std::array<Samples, 3>> velocity, sigma, truth;  // by frame and axis
  };

  const StudyCell& cell_;
  int runs_ = 0;
  Json diverged_ = Json::array(), lost_ = Json::array();
  std::map<std::string, Samples> scalars_;
  std::map<std::string, ByFrame> frames_, smoothed_;
  std::map<int, Age> ages_;
  std::map<int, Track> tracks_;
  std::map<std::string, std::vector<long>> counts_;
  std::map<std::string, double> coverage_;
  std::map<std::string, Samples> timing_;
  std::map<std::string, double> stages_;
};

void Cell::add(const Json& run) {
  ++runs_;
  const auto seed = run.at("seed").get<std::uint64_t>();
  const bool diverged = !run.at("diverged").is_null();
  position_rmse[seed] = INFINITY;
  if (diverged) {
    diverged_.push_back({{"seed", seed},
                         {"frame", run["diverged"].value("frame", Json())},
                         {"reason", run["diverged"].at("reason")}});
  }
  if (!run.contains("frames")) return;  // it never began
  if (!run.at("lost_at").is_null()) lost_.push_back({{"seed", seed}, {"frame", run["lost_at"]}});
  for (const char* what : {"position_error_m", "rotation_error_deg", "nees_pose", "nees_position",
                           "nees_rotation", "position_sigma_m"}) {
    gather(run.at("frames"), what, frames_[what]);
    if (run.contains("smoothed_frames")) gather(run["smoothed_frames"], what, smoothed_[what]);
  }
  for (const char* what : kCounts) {
    auto& sums = counts_[what];
    sums.resize(3);
    for (std::size_t i = 0; i < 3; ++i) sums[i] += run.at(what)[i].get<long>();
  }
  for (const auto& [key, value] : run.at("coverage").items()) coverage_[key] += number(value);
  for (const char* what : {"nis_mean", "nis_expected", "median_frames_to_decision"}) {
    scalars_[what].push_back(number(run.at(what)));
  }
  add_landmarks(run.at("landmarks"));
  add_tracks(run.at("tracks"));
  if (diverged) return;
  for (const char* which : {"filtered", "smoothed"}) {
    if (run.at(which).is_null()) continue;
    for (const auto& [key, value] : run[which].items()) {
      scalars_[std::string(which) + "_" + key].push_back(number(value));
    }
  }
  position_rmse[seed] = number(run.at("filtered").at("position_rmse_m"));
}

void Cell::add_landmarks(const Json& ages) {
  const auto append = [](const Json& values, Samples& to) {
    for (const Json& v : values) to.push_back(number(v));
  };
  for (const Json& a : ages) {
    Age& age = ages_[a.at("observations").get<int>()];
    append(a.at("static_position_m"), age.statics);
    append(a.at("moving_position_m"), age.movings);
    append(a.at("moving_velocity_m_s"), age.velocities);
    const int positions = a.at("nees_position_count").get<int>();
    const int velocities = a.at("nees_velocity_count").get<int>();
    if (positions > 0) age.position_sum += positions * number(a.at("nees_position_mean"));
    if (velocities > 0) age.velocity_sum += velocities * number(a.at("nees_velocity_mean"));
    age.position_count += positions;
    age.velocity_count += velocities;
  }
}

void Cell::add_tracks(const Json& tracks) {
  for (const Json& t : tracks) {
    Track& track = tracks_[t.at("track").get<int>()];
    for (std::size_t i = 0; i < t.at("frame").size(); ++i) {
      const int frame = t["frame"][i].get<int>();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        track.velocity[frame][axis].push_back(number(t.at("velocity")[i][axis]));
        track.sigma[frame][axis].push_back(number(t.at("sigma")[i][axis]));
        const Json& truth = t.at("truth")[i];
        track.truth[frame][axis].push_back(truth.is_null() ? kUndefined : number(truth[axis]));
      }
    }
  }
}

void Cell::add_timing(const Json& timing) {
  for (const char* what : {"seconds", "frame_median_ms", "frames_per_second", "smoothing_ms"}) {
    if (timing.contains(what)) timing_[what].push_back(number(timing[what]));
  }
  if (!timing.contains("stages_ms")) return;
  for (const auto& [stage, ms] : timing["stages_ms"].items()) stages_[stage] += number(ms);
}

Json Cell::per_frame() const {
  Json json;
  const ByFrame& position = frames_.at("position_error_m");
  Json frame = Json::array(), runs = Json::array(), lower = Json::array(), upper = Json::array();
  Json rmse = Json::array(), q25 = Json::array(), q50 = Json::array(), q75 = Json::array(),
       q95 = Json::array(), sigma = Json::array(), rotation = Json::array();
  for (const auto& [index, errors] : position) {
    const Interval interval = nees_interval(6, static_cast<int>(errors.size()));
    frame.push_back(index);
    runs.push_back(errors.size());
    lower.push_back(interval.lower);
    upper.push_back(interval.upper);
    rmse.push_back(root_mean_square(errors));
    q25.push_back(quantile(errors, 0.25));
    q50.push_back(quantile(errors, 0.5));
    q75.push_back(quantile(errors, 0.75));
    q95.push_back(quantile(errors, 0.95));
    sigma.push_back(root_mean_square(frames_.at("position_sigma_m").at(index)));
    rotation.push_back(root_mean_square(frames_.at("rotation_error_deg").at(index)));
  }
  return {{"frame", frame},
          {"runs", runs},
          {"anees_pose", anees(frames_.at("nees_pose"), 6).per_frame},
          {"anees_pose_lower", lower},
          {"anees_pose_upper", upper},
          {"anees_position", anees(frames_.at("nees_position"), 3).per_frame},
          {"anees_rotation", anees(frames_.at("nees_rotation"), 3).per_frame},
          {"position_rmse_m", rmse},
          {"position_q25_m", q25},
          {"position_median_m", q50},
          {"position_q75_m", q75},
          {"position_q95_m", q95},
          {"position_sigma_m", sigma},
          {"rotation_rmse_deg", rotation}};
}

Json anees_json(const std::map<std::string, ByFrame>& frames) {
  Json json = Json::object();
  const std::pair<const char*, int> parts[] = {{"pose", 6}, {"position", 3}, {"rotation", 3}};
  for (const auto& [part, dof] : parts) {
    const ByFrame& samples = frames.at(std::string("nees_") + part);
    const Nees n = anees(samples, dof);
    json[part] = {{"dof", dof}, {"mean", n.mean}, {"largest", n.worst}, {"inside", n.inside}};
  }
  return json;
}

Json nees_of_age(double sum, int count) {
  if (count == 0) return nullptr;
  const Interval interval = nees_interval(3, count);
  return {{"mean", sum / count},
          {"count", count},
          {"lower", interval.lower},
          {"upper", interval.upper}};
}

Json Cell::by_age() const {
  Json json = Json::array();
  for (const auto& [observations, age] : ages_) {
    json.push_back({{"observations", observations},
                    {"static_position_m", quartiles(age.statics)},
                    {"moving_position_m", quartiles(age.movings)},
                    {"moving_velocity_m_s", quartiles(age.velocities)},
                    {"nees_position", nees_of_age(age.position_sum, age.position_count)},
                    {"nees_velocity", nees_of_age(age.velocity_sum, age.velocity_count)}});
  }
  return json;
}

Json Cell::tracks_json() const {
  Json json = Json::array();
  for (const auto& [id, track] : tracks_) {
    Json one = {{"track", id},
                {"frame", Json::array()},
                {"velocity", Json::array()},
                {"spread", Json::array()},
                {"sigma", Json::array()},
                {"truth", Json::array()}};
    for (const auto& [frame, velocity] : track.velocity) {
      Json v = Json::array(), spread = Json::array(), s = Json::array(), truth = Json::array();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        v.push_back(median(velocity[axis]));
        spread.push_back({quantile(velocity[axis], 0.05), quantile(velocity[axis], 0.95)});
        s.push_back(median(track.sigma.at(frame)[axis]));
        truth.push_back(median(track.truth.at(frame)[axis]));
      }
      one["frame"].push_back(frame);
      one["velocity"].push_back(v);
      one["spread"].push_back(spread);
      one["sigma"].push_back(s);
      one["truth"].push_back(truth);
    }
    json.push_back(one);
  }
  return json;
}

Json Cell::json() const {
  Json json = {{"label", cell_.label},
               {"estimator", cell_.estimator},
               {"runs", runs_},
               {"diverged", diverged_},
               {"lost", lost_}};
  json["configuration"] = Json::object();
  for (const auto& [key, value] : key_values(cell_.configuration)) {
    json["configuration"][key] = value;
  }
  if (frames_.empty()) return json;  // no run began
  for (const auto& [key, samples] : scalars_) {
    const bool is_rmse = key.find("rmse") != std::string::npos;
    json[key] = json_of(bootstrap(samples, is_rmse ? root_mean_square : mean));
  }
  json["anees"] = anees_json(frames_);
  if (!smoothed_.empty()) json["smoothed_anees"] = anees_json(smoothed_);
  for (const char* what : kCounts) json[what] = counts_.at(what);
  json["coverage"] = coverage_;
  Json timing = Json::object();
  for (const auto& [key, samples] : timing_) timing[key] = median(samples);
  timing["stages_ms"] = stages_;
  json["timing"] = timing;
  json["per_frame"] = per_frame();
  json["by_age"] = by_age();
  json["tracks"] = tracks_json();
  return json;
}

// Position RMSE of a - b by seed, where both finished; a diverged run loses.
Json pair_json(const StudyCell& a, const Cell& first, const StudyCell& b, const Cell& second) {
  Samples differences;
  int wins_a = 0, wins_b = 0;
  for (const auto& [seed, x] : first.position_rmse) {
    const auto other = second.position_rmse.find(seed);
    if (other == second.position_rmse.end()) continue;
    const double y = other->second;
    wins_a += x < y;
    wins_b += y < x;
    if (std::isfinite(x) && std::isfinite(y)) differences.push_back(x - y);
  }
  return {{"a", a.label},
          {"b", b.label},
          {"pairs", first.position_rmse.size()},
          {"wins_a", wins_a},
          {"wins_b", wins_b},
          {"position_rmse_difference_m", json_of(bootstrap(differences, mean))}};
}

void for_each_line(const std::filesystem::path& file,
                   const std::function<void(const Json&)>& visit) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, 0, "cannot be read: is the study complete?");
  std::string line;
  while (std::getline(in, line)) visit(Json::parse(line));
}

// RMSE of the position over the bound's, at the frames of both.
Json over_bound(const Json& cell, const Json& bound) {
  std::map<int, double> sigma;
  const Json& b = bound.at("per_frame");
  for (std::size_t i = 0; i < b.at("frame").size(); ++i) {
    sigma[b["frame"][i].get<int>()] = number(b.at("position_sigma_m")[i]);
  }
  const Json& c = cell.at("per_frame");
  double squares = 0.0, bounds = 0.0;
  Json ratio = Json::array();
  for (std::size_t i = 0; i < c.at("frame").size(); ++i) {
    const double e = number(c.at("position_rmse_m")[i]), s = sigma[c["frame"][i].get<int>()];
    squares += e * e;
    bounds += s * s;
    ratio.push_back(e / s);
  }
  return {{"position", std::sqrt(squares / bounds)}, {"per_frame", ratio}};
}

void add_bound(Json& group) {
  const Json* bound = nullptr;
  for (const Json& cell : group["cells"]) {
    if (cell["label"] == kBound && cell.contains("per_frame")) bound = &cell;
  }
  if (bound == nullptr) return;
  const Json copy = *bound;
  for (Json& cell : group["cells"]) {
    if (cell["label"] != kBound && cell.contains("per_frame")) {
      cell["rmse_over_bound"] = over_bound(cell, copy);
    }
  }
}

}  // namespace

Json summarise_study(const Study& study, const std::filesystem::path& folder) {
  std::vector<Cell> cells;
  cells.reserve(study.cells.size());
  for (const StudyCell& cell : study.cells) cells.emplace_back(cell);
  for_each_line(folder / "results.jsonl",
                [&](const Json& run) { cells.at(run.at("cell").get<std::size_t>()).add(run); });
  for_each_line(folder / "timing.jsonl", [&](const Json& timing) {
    cells.at(timing.at("cell").get<std::size_t>()).add_timing(timing);
  });
  Json json = {{"format", "slammot-summary-1"},
               {"version", SLAMMOT_VERSION},
               {"name", study.name},
               {"title", study.title},
               {"runs", study.runs},
               {"first_seed", study.first_seed},
               {"figures", study.figures},
               {"groups", Json::array()}};
  if (study.reference) {
    json["reference"] = {{"label", study.reference->label},
                         {"static", study.reference->statics},
                         {"moving", study.reference->movings}};
  }
  for (std::size_t i = 0; i < study.cells.size();) {
    const StudyCell& first = study.cells[i];
    Json group = {{"name", first.group}, {"scenario", first.scenario}, {"scene", first.scene}};
    group["sweep"] = Json::object();
    for (const auto& [key, value] : first.sweep) group["sweep"][key] = value;
    group["cells"] = Json::array();
    group["pairs"] = Json::array();
    std::size_t end = i;
    while (end < study.cells.size() && study.cells[end].group == first.group) ++end;
    for (std::size_t a = i; a < end; ++a) {
      group["cells"].push_back(cells[a].json());
      for (std::size_t b = a + 1; b < end; ++b) {
        if (study.cells[a].label == kBound || study.cells[b].label == kBound) continue;
        group["pairs"].push_back(pair_json(study.cells[a], cells[a], study.cells[b], cells[b]));
      }
    }
    add_bound(group);
    json["groups"].push_back(std::move(group));
    i = end;
  }
  return json;
}

}  // namespace slammot
