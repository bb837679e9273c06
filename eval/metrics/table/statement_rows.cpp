// What a run says of itself, without truth.
#include "eval/metrics/table/row_forms.h"
#include "eval/metrics/table/rows.h"

namespace slammot {
namespace {

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
                          &N::joint_mean)),
          pooled(count(row("nis_lasting_sums", "lasting_sums", "sums of 30 innovations",
                           "of a track, over the run", &N::lasting_sums)),
                 Pooled::kNot),
          on_terminal(row("nis_lasting", "lasting_mean", "NIS of 30",
                          "NIS of the sum of thirty innovations of a track, given all others; 2 "
                          "where they are independent, more where what a track is off lasts",
                          &N::lasting_mean))};
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
  const auto share = [](const S& s, double information) {
    return s.stated > 0.0 ? information / s.stated : kUndefined;
  };
  return {pooled(row("stated", "scale, stated",
                     "information on the log of the scale after the first frame",
                     [](const S& s) { return s.stated; }),
                 Pooled::kNot),
          on_page(row("largest", "scale, largest",
                      "the largest information on the scale over the stated one: above 1 something "
                      "seems to have told it",
                      [=](const S& s) { return share(s, s.largest); })),
          on_page(row("last", "scale, last",
                      "information on the scale after the last frame over the stated one",
                      [=](const S& s) { return share(s, s.last); }))};
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

}  // namespace

MetricTable statement_rows() {
  MetricTable table = nis_rows();
  append(table, scale_rows());
  append(table, warning_rows());
  return table;
}

}  // namespace slammot
