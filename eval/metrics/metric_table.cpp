// The rows. Numbers of one struct stand together; a caller's own row needs none of these helpers.
#include "eval/metrics/metric.h"
#include "eval/metrics/metrics.h"

namespace slammot {
namespace {

using Pick = std::function<const NeesSummary*(const FinishedRun&)>;

Metric shown(Metric m, Shown where) {
  m.shown = where;
  return m;
}

Metric on_terminal(Metric m) { return shown(std::move(m), Shown::kTerminal); }
Metric on_page(Metric m) { return shown(std::move(m), Shown::kPage); }

Metric neither(Metric m) {
  m.better = Better::kNeither;
  return m;
}

Metric count(Metric m) {
  m.form = Form::kCount;
  return neither(std::move(m));
}

Metric near_expected(Metric m, const std::string& key) {
  m.better = Better::kNearExpected;
  m.expected = key;
  return m;
}

Metric pooled(Metric m, Pooled how) {
  m.pooled = how;
  return m;
}

template <typename Member, typename Struct>
double number(Member member, const Struct& s) {
  return static_cast<double>(std::invoke(member, s));
}

// A number that only metrics.json has.
Metric detail(const std::string& block, const std::string& leaf, const std::string& caption,
              std::function<double(const FinishedRun&)> value, Scope scope = Scope::kRun) {
  return {.key = block + "." + leaf,
          .unit = "",
          .name = leaf,
          .caption = caption,
          .value = std::move(value),
          .scope = scope,
          .better = Better::kNeither,
          .pooled = Pooled::kNot,
          .block = block,
          .leaf = leaf};
}

MetricTable nees_rows(const std::string& block, Scope scope, const Pick& summary) {
  const auto row = [&](const char* leaf, const char* caption, auto member) {
    const auto value = [=](const FinishedRun& f) {
      const NeesSummary* s = summary(f);
      return s == nullptr ? kUndefined : number(member, *s);
    };
    return detail(block, leaf, caption, value, scope);
  };
  using S = NeesSummary;
  return {count(row("dof", "degrees of freedom: the mean NEES of a consistent estimator", &S::dof)),
          count(row("used", "samples", &S::used)),
          count(row("covariances_not_positive_definite", "samples whose NEES is infinite",
                    &S::failures)),
          row("mean", "mean NEES over the samples", &S::mean),
          row("mean_over_dof", "mean NEES over its degrees of freedom",
              [](const S& s) { return s.mean / s.dof; }),
          row("median", "median NEES", &S::median),
          row("q95", "95% quantile of the NEES", &S::q95),
          row("fraction_inside", "samples inside the two-sided 95% interval of chi-square",
              &S::interval_coverage)};
}

// The mean heads a column where `name` is given.
MetricTable pose_nees_rows(const std::string& part, NeesSummary PoseConsistency::*summary,
                           const std::string& name = "") {
  MetricTable rows = nees_rows("nees." + part, Scope::kTrajectory, [=](const FinishedRun& f) {
    const auto& consistency = f.trajectory.consistency.value;
    return consistency ? &(*consistency.*summary) : nullptr;
  });
  for (Metric& row : rows) {
    if (name.empty() || row.leaf != "mean") continue;
    row = on_terminal(near_expected(std::move(row), "nees." + part + ".dof"));
    row.name = name;
  }
  return rows;
}

MetricTable landmark_nees_rows(const std::string& part, NeesSummary LandmarkConsistency::*summary) {
  return nees_rows("landmark_nees." + part, Scope::kRun, [=](const FinishedRun& f) {
    const auto& consistency = f.metrics.landmark_consistency.value;
    return consistency ? &(*consistency.*summary) : nullptr;
  });
}

MetricTable landmark_error_rows(const std::string& what, ErrorSummary LandmarkErrors::*summary) {
  const auto row = [&](const char* leaf, const char* caption, auto member) {
    const auto value = [=](const FinishedRun& f) {
      const auto& errors = f.metrics.landmark_errors.value;
      return errors ? number(member, *errors.*summary) : kUndefined;
    };
    return detail("landmark_errors." + what, leaf, caption, value);
  };
  using E = ErrorSummary;
  return {count(row("used", "landmarks with a true value", &E::used)),
          row("rmse", "root mean square over the landmarks", &E::rmse),
          row("median", "median over the landmarks", &E::median),
          row("q95", "95% quantile over the landmarks", &E::q95)};
}

Metric coverage_row() {
  return {.key = "coverage",
          .unit = "",
          .name = "coverage",
          .caption = "poses judged, of the frames of the sequence",
          .value =
              [](const FinishedRun& f) {
                const auto& accuracy = f.trajectory.accuracy.value;
                const auto frames = static_cast<double>(f.sequence.frames.size());
                return accuracy ? accuracy->poses / frames : kUndefined;
              },
          .scope = Scope::kTrajectory,
          .form = Form::kRatio,
          .better = Better::kNeither,
          .block = "accuracy"};
}

MetricTable accuracy_rows() {
  const auto row = [](const char* key, const char* unit, const char* name, const char* caption,
                      auto member) {
    const auto value = [=](const FinishedRun& f) {
      const auto& accuracy = f.trajectory.accuracy.value;
      return accuracy ? number(member, *accuracy) : kUndefined;
    };
    return Metric{.key = key,
                  .unit = unit,
                  .name = name,
                  .caption = caption,
                  .value = value,
                  .scope = Scope::kTrajectory,
                  .decimals = 4,
                  .pooled = Pooled::kNot,
                  .block = "accuracy"};
  };
  using A = Accuracy;
  constexpr Pooled kRms = Pooled::kRootMeanSquare;
  return {
      on_terminal(coverage_row()),
      count(row("poses", "", "poses", "poses with a true pose near in time", &A::poses)),
      pooled(on_terminal(row(kPositionRmse, "m", "position RMSE",
                             "RMSE of the position, without alignment", &A::position_rmse)),
             kRms),
      row("position_max_m", "m", "largest error", "largest position error", &A::position_max),
      pooled(on_page(row("position_final_m", "m", "final error", "position error of the last pose",
                         &A::position_final)),
             Pooled::kMean),
      pooled(on_terminal(row("rotation_rmse_deg", "deg", "rotation RMSE",
                             "RMSE of the orientation, without alignment", &A::rotation_rmse_deg)),
             kRms),
      row("rotation_max_deg", "deg", "largest rotation error", "largest orientation error",
          &A::rotation_max_deg),
      pooled(on_terminal(row("ate_se3_m", "m", "ATE SE(3)",
                             "RMSE of the position after rigid alignment", &A::ate_se3)),
             kRms),
      pooled(on_terminal(row(kAteSim3, "m", "ATE Sim(3)",
                             "RMSE of the position after similarity alignment", &A::ate_sim3)),
             kRms),
      pooled(on_terminal(
                 neither(row("sim3_scale", "", "scale",
                             "true over estimated size, of the similarity alignment", &A::scale))),
             Pooled::kMean),
      count(row("rpe_1s_pairs", "", "RPE pairs", "pairs of poses one second apart",
                &A::relative_pairs)),
      pooled(on_terminal(row("rpe_1s_position_rmse_m", "m", "RPE 1 s",
                             "RMSE of the displacement in one second", &A::relative_position_rmse)),
             kRms),
      pooled(on_page(row("rpe_1s_rotation_rmse_deg", "deg", "RPE 1 s, rotation",
                         "RMSE of the rotation in one second", &A::relative_rotation_rmse_deg)),
             kRms),
  };
}

MetricTable nis_rows() {
  const auto row = [](const char* key, const char* leaf, const char* name, const char* caption,
                      auto member) {
    return Metric{.key = key,
                  .unit = "",
                  .name = name,
                  .caption = caption,
                  .value = [=](const FinishedRun& f) { return number(member, f.metrics.nis); },
                  .better = Better::kNeither,
                  .block = "nis",
                  .leaf = leaf};
  };
  using N = NisMetrics;
  Metric mean = on_terminal(
      row("nis_mean", "mean", "NIS", "mean NIS of the accepted measurements", &N::mean));
  mean.expected = "nis_expected";
  return {pooled(count(row("nis_dof", "dof", "NIS dof", "degrees of freedom of the NIS", &N::dof)),
                 Pooled::kNot),
          mean,
          row("nis_expected", "expected_mean", "expected NIS",
              "mean NIS of a consistent estimator, whose gate cuts off the tail", &N::expected),
          on_terminal(row("nis_joint", "joint_mean", "joint NIS",
                          "NIS of all accepted of a frame together, over their number; 2 is right "
                          "with an open gate, the expected NIS where errors are independent",
                          &N::joint_mean))};
}

// What an estimator without known landmarks believes to know of the scale, over what was stated.
MetricTable scale_rows() {
  const auto row = [](const char* leaf, const char* name, const char* caption, auto value) {
    return Metric{.key = std::string("scale.") + leaf,
                  .unit = "",
                  .name = name,
                  .caption = caption,
                  .value = [=](const FinishedRun& f) { return value(f.run.scale); },
                  .better = Better::kNeither,
                  .block = "scale",
                  .leaf = leaf};
  };
  using S = ScaleInformation;
  return {pooled(row("stated", "scale, stated",
                     "information on the log of the scale after the first frame",
                     [](const S& s) { return s.stated; }),
                 Pooled::kNot),
          on_page(row("largest", "scale, largest",
                      "the largest information on the scale over the stated one: above 1 something "
                      "seems to have told it",
                      [](const S& s) { return s.largest / s.stated; })),
          on_page(row("last", "scale, last",
                      "information on the scale after the last frame over the stated one",
                      [](const S& s) { return s.last / s.stated; }))};
}

// A run that ended early has said so.
bool warned(const RunMetrics& m) { return m.warned(); }
bool failed_silently(const RunMetrics& m) { return m.failed && !m.warned(); }

// What a run says against itself, without truth (self_check.h), and where it ought to have.
MetricTable warning_rows() {
  const auto row = [](const char* key, const char* name, const char* caption,
                      bool (*holds)(const RunMetrics&)) {
    return Metric{.key = key,
                  .unit = "",
                  .name = name,
                  .caption = caption,
                  .value = [=](const FinishedRun& f) { return holds(f.metrics) ? 1.0 : 0.0; },
                  .form = Form::kRatio};
  };
  return {neither(row("warned", "warned", "the run warns, or diverged", warned)),
          row("failed_silently", "failed, not warned", "the run failed, and nothing in it says so",
              failed_silently)};
}

// What later measurements buy: the pose of so many frames ago, as it is believed now.
struct LagQuantity {
  const char* leaf;
  const char* ratio;
  const char* caption;
  Pooled how;
  double (*value)(const TrajectoryMetrics&);
};

constexpr LagQuantity kLagQuantities[] = {
    {"position_rmse_m", "position_rmse_ratio", "RMSE of the position [m]", Pooled::kRootMeanSquare,
     [](const TrajectoryMetrics& t) {
       return t.accuracy.value ? t.accuracy.value->position_rmse : kUndefined;
     }},
    {"rotation_rmse_deg", "rotation_rmse_ratio", "RMSE of the rotation [deg]",
     Pooled::kRootMeanSquare,
     [](const TrajectoryMetrics& t) {
       return t.accuracy.value ? t.accuracy.value->rotation_rmse_deg : kUndefined;
     }},
    {"nees_pose", "nees_pose_ratio", "mean pose NEES", Pooled::kMean,
     [](const TrajectoryMetrics& t) {
       return t.consistency.value ? t.consistency.value->pose.mean : kUndefined;
     }}};

double at_lag(const FinishedRun& f, int lag, const LagQuantity& quantity) {
  const auto found = f.metrics.lagged.find(lag);
  return found == f.metrics.lagged.end() ? kUndefined : quantity.value(found->second);
}

// Of one run: paired, so that in the mean over runs no bad one hides what the others gain.
double over_filtered(const FinishedRun& f, int lag, const LagQuantity& quantity) {
  const double filtered = at_lag(f, 0, quantity);
  return filtered > 0.0 ? at_lag(f, lag, quantity) / filtered : kUndefined;
}

MetricTable lag_rows() {
  MetricTable rows;
  const auto add = [&](int lag, const char* leaf, const std::string& caption, Pooled how,
                       std::function<double(const FinishedRun&)> value) {
    const std::string frames =
        lag == 1 ? " one frame later" : " " + std::to_string(lag) + " frames later";
    rows.push_back(pooled(
        detail("lag." + std::to_string(lag), leaf, caption + frames, std::move(value)), how));
  };
  const auto add_all = [&](int lag) {
    for (const LagQuantity& q : kLagQuantities) {
      add(lag, q.leaf, q.caption, q.how, [=](const FinishedRun& f) { return at_lag(f, lag, q); });
    }
  };
  add_all(0);
  for (const int lag : kLags) {
    add_all(lag);
    for (const LagQuantity& q : kLagQuantities) {
      add(lag, q.ratio, std::string(q.caption) + " over that as filtered,", Pooled::kMean,
          [=](const FinishedRun& f) { return over_filtered(f, lag, q); });
    }
  }
  return rows;
}

MetricTable class_rows(const std::string& truth, ClassCounts ClassificationMetrics::*counts) {
  const auto row = [&](const char* leaf, const char* caption, auto member) {
    const auto value = [=](const FinishedRun& f) {
      return number(member, f.metrics.classification.*counts);
    };
    return detail("classification." + truth, leaf, caption, value);
  };
  const auto ratio = [](Metric m, Better better) {
    m.form = Form::kRatio;
    m.better = better;
    return m;
  };
  using C = ClassCounts;
  Metric right = on_page(ratio(
      row("rightly_classified", "labelled as they are", &C::rightly_classified), Better::kLarger));
  right.name = truth + " right";
  return {count(row("right", "labelled as they are", &C::right)),
          count(row("wrong", "labelled the other class", &C::wrong)),
          count(row("undecided", "left unknown", &C::undecided)),
          right,
          ratio(row("wrongly_classified", "labelled the other class", &C::wrongly_classified),
                Better::kSmaller),
          ratio(row("misclassified", "labelled the other class or left unknown (thesis 4.1.1)",
                    &C::misclassified),
                Better::kSmaller)};
}

MetricTable classification_rows() {
  using C = ClassificationMetrics;
  const auto of = [](auto member) {
    return [=](const FinishedRun& f) { return number(member, f.metrics.classification); };
  };
  return {
      count(detail("classification", "without_truth",
                   "classified landmarks whose true class is not known", of(&C::without_truth))),
      {.key = "median_frames_to_decision",
       .unit = "frames",
       .name = "frames to decision",
       .caption = "median number of measurements until a label is decided",
       .value = of(&C::median_frames_to_decision),
       .decimals = 1,
       .block = "classification"}};
}

MetricTable runtime_rows() {
  const auto row = [](const char* key, const char* unit, const char* name, const char* caption,
                      Pooled pooled, int decimals, auto member) {
    return Metric{.key = key,
                  .unit = unit,
                  .name = name,
                  .caption = caption,
                  .value = [=](const FinishedRun& f) { return number(member, f.metrics.runtime); },
                  .decimals = decimals,
                  .pooled = pooled,
                  .block = "runtime"};
  };
  using R = RuntimeMetrics;
  constexpr Pooled kClock = Pooled::kMedianTiming;
  Metric rate = row("frames_per_second", "1/s", "frames per second",
                    "frames over their time, smoothing after the last one included", kClock, 1,
                    &R::frames_per_second);
  rate.better = Better::kLarger;
  const Metric size =
      neither(row("state_size_median", "", "state size", "median size of the state vector",
                  Pooled::kNot, 0, &R::state_size_median));
  return {on_terminal(row("frame_median_ms", "ms", "time per frame",
                          "median time of a frame; of a batch with its share of the solution",
                          kClock, 2, &R::frame_median_ms)),
          row("frame_p95_ms", "ms", "time per frame, 95%", "95% quantile of the time of a frame",
              Pooled::kNot, 2, &R::frame_p95_ms),
          rate,
          row("smoothing_ms", "ms", "smoothing", "time of the smoothing after the last frame",
              kClock, 2, &R::smoothing_ms),
          on_terminal(size),
          neither(row("state_size_max", "", "largest state", "largest size of the state vector",
                      Pooled::kMean, 0, &R::state_size_max))};
}

void append(MetricTable& table, MetricTable more) {
  table.insert(table.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
}

MetricTable all_rows() {
  MetricTable table = accuracy_rows();
  append(table, pose_nees_rows("pose", &PoseConsistency::pose, "pose NEES"));
  append(table, pose_nees_rows("position", &PoseConsistency::position, "position NEES"));
  append(table, pose_nees_rows("rotation", &PoseConsistency::rotation));
  append(table, landmark_error_rows("static_position_m", &LandmarkErrors::static_position));
  append(table, landmark_error_rows("moving_position_m", &LandmarkErrors::moving_position));
  append(table, landmark_error_rows("moving_velocity_m_s", &LandmarkErrors::moving_velocity));
  append(table, landmark_nees_rows("position", &LandmarkConsistency::position));
  append(table, landmark_nees_rows("velocity", &LandmarkConsistency::velocity));
  append(table, class_rows("static", &ClassificationMetrics::statics));
  append(table, class_rows("moving", &ClassificationMetrics::movings));
  append(table, classification_rows());
  append(table, nis_rows());
  append(table, scale_rows());
  append(table, warning_rows());
  append(table, lag_rows());
  append(table, runtime_rows());
  return table;
}

MetricTable& program_table() {
  static MetricTable table = all_rows();
  return table;
}

}  // namespace

const MetricTable& metric_table() { return program_table(); }

void add_metrics(const MetricTable& more) {
  for (const Metric& added : more) {
    for (const Metric& metric : metric_table()) {
      if (metric.key != added.key) continue;
      throw std::invalid_argument("there is a metric '" + added.key + "' already");
    }
    program_table().push_back(added);
  }
}

MetricTable metric_table_with(const MetricTable& more) {
  MetricTable table = metric_table();
  append(table, more);
  return table;
}

double value_of(const std::vector<MetricValue>& values, const std::string& key) {
  for (const MetricValue& v : values) {
    if (v.metric.key == key) return v.value;
  }
  return kUndefined;
}

}  // namespace slammot
