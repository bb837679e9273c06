// The table of metrics as the reports read it.
#include "eval/output/metrics_json.h"

namespace slammot {

namespace {

constexpr const char* name_of(Better better) {
  switch (better) {
    case Better::kSmaller:
      return "smaller";
    case Better::kLarger:
      return "larger";
    case Better::kNearExpected:
      return "expected";
    case Better::kNeither:
      break;
  }
  return "neither";
}

constexpr const char* name_of(Form form) {
  return form == Form::kCount ? "count" : form == Form::kRatio ? "ratio" : "real";
}

constexpr const char* name_of(Pooled pooled) {
  switch (pooled) {
    case Pooled::kMean:
      return "mean";
    case Pooled::kRootMeanSquare:
      return "rms";
    case Pooled::kMedianTiming:
      return "timing";
    case Pooled::kNot:
      break;
  }
  return "not";
}

}  // namespace

Json metric_table_json(const MetricTable& table) {
  Json json = Json::array();
  for (const Metric& m : table) {
    const std::string prefix = m.block.empty() ? "" : m.block + ".";
    json.push_back({{"key", m.key},
                    {"path", prefix + m.name_in_block()},
                    {"of", m.scope == Scope::kTrajectory ? "trajectory" : "run"},
                    {"name", m.name},
                    {"unit", m.unit},
                    {"caption", m.caption},
                    {"form", name_of(m.form)},
                    {"decimals", m.decimals},
                    {"better", name_of(m.better)},
                    {"expected", m.expected},
                    {"on_page", m.shown != Shown::kFiles},
                    {"pooled", name_of(m.pooled)}});
  }
  return json;
}

}  // namespace slammot
