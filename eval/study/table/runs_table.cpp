#include "eval/study/table/runs_table.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <functional>

#include "datasets/output/output_files.h"
#include "eval/pooling/estimate_json.h"
#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

// What a column takes its field from; `result` and `timing` are lines of the two files.
struct Run {
  const StudyCell& cell;
  const Json& result;
  const Json& timing;
};

struct Column {
  std::string name;
  std::function<std::string(const Run&)> field;
};

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? "\"\"" : std::string(1, c);
  return field + '"';
}

// Shortest that reads back; nothing where it is not defined.
std::string field_of(const Json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (value.is_string()) return quoted(value.get<std::string>());
  const bool defined = value.is_number() && std::isfinite(value.get<double>());
  return defined ? value.dump() : "";
}

Json member(const Json& object, const std::string& key) {
  return object.is_object() ? object.value(key, Json()) : Json();
}

void add_metrics(const Study& study, std::vector<Column>& columns) {
  for (const Metric& metric : study.metrics) {
    const std::string key = metric.key;
    if (metric.pooled == Pooled::kNot) continue;
    if (metric.pooled == Pooled::kMedianTiming) {
      columns.push_back({key, [=](const Run& r) { return field_of(member(r.timing, key)); }});
    } else if (metric.scope == Scope::kRun) {
      columns.push_back({key, [=](const Run& r) { return field_of(member(r.result, key)); }});
    } else {
      for (const std::string of : {"filtered", "smoothed"}) {
        columns.push_back({fmt::format("{}_{}", of, key), [=](const Run& r) {
                             return field_of(member(member(r.result, of), key));
                           }});
      }
    }
  }
}

// Means over the frames of a run; a covariance that is not positive definite makes them undefined.
void add_nees(std::vector<Column>& columns) {
  for (const auto& [prefix, block] :
       {std::pair("filtered_", "frames"), std::pair("smoothed_", "smoothed_frames")}) {
    for (const std::string part : {"nees_pose", "nees_position", "nees_rotation"}) {
      columns.push_back({prefix + part, [=, in = std::string(block)](const Run& r) {
                           std::vector<double> values;
                           for (const Json& value : member(member(r.result, in), part)) {
                             values.push_back(number(value));
                           }
                           return values.empty() ? "" : field_of(Json(mean(values)));
                         }});
    }
  }
}

void add_labels(std::vector<Column>& columns) {
  constexpr const char* kVerdicts[] = {"right", "wrong", "undecided"};
  for (const std::string truth : {"static", "moving"}) {
    for (std::size_t i = 0; i < std::size(kVerdicts); ++i) {
      columns.push_back({truth + "_" + kVerdicts[i], [=](const Run& r) {
                           const Json counts = member(r.result, truth);
                           return counts.is_array() ? field_of(counts.at(i)) : "";
                         }});
    }
  }
}

// A scenario's name, or a recorded sequence's folder.
std::string scene_of(const StudyCell& cell) {
  return cell.sequence.empty() ? cell.scenario : cell.sequence.string();
}

std::vector<Column> columns_of(const Study& study) {
  std::vector<Column> columns = {
      {"scenario", [](const Run& r) { return quoted(scene_of(r.cell)); }},
      {"group", [](const Run& r) { return quoted(r.cell.group); }},
      {"estimator", [](const Run& r) { return quoted(r.cell.estimator); }},
      {"label", [](const Run& r) { return quoted(r.cell.label); }}};
  for (std::size_t i = 0; i < study.cells.front().sweep.size(); ++i) {
    columns.push_back({study.cells.front().sweep[i].first,
                       [=](const Run& r) { return quoted(r.cell.sweep[i].second); }});
  }
  const auto add = [&](const char* name, auto field) { columns.push_back({name, field}); };
  add("seed", [](const Run& r) { return field_of(r.result.at("seed")); });
  add("diverged", [](const Run& r) { return field_of(!r.result.at("diverged").is_null()); });
  add("diverged_frame",
      [](const Run& r) { return field_of(member(r.result.at("diverged"), "frame")); });
  add("failed", [](const Run& r) { return field_of(!member(r.result, "lost_at").is_null()); });
  add("failed_frame", [](const Run& r) { return field_of(member(r.result, "lost_at")); });
  add_metrics(study, columns);
  add_nees(columns);
  add_labels(columns);
  add("seconds", [](const Run& r) { return field_of(member(r.timing, "seconds")); });
  return columns;
}

Json parsed(const std::filesystem::path& file, int number, const std::string& line) {
  try {
    return Json::parse(line);
  } catch (const Json::exception&) {
    throw InputError(file, number, "is not a line of JSON");
  }
}

const StudyCell& cell_of(const Study& study, const Json& result, const std::filesystem::path& file,
                         int line) {
  const auto cell = member(result, "cell");
  if (!cell.is_number_unsigned() || cell.get<std::size_t>() >= study.cells.size()) {
    throw InputError(file, line, "is no run of this study");
  }
  return study.cells[cell.get<std::size_t>()];
}

void write_rows(const Study& study, const std::filesystem::path& folder, std::ostream& out) {
  const std::filesystem::path results_file = folder / "results.jsonl",
                              timing_file = folder / "timing.jsonl";
  std::ifstream results(results_file), timing(timing_file);
  const std::vector<Column> columns = columns_of(study);
  std::vector<std::string> fields;
  for (const Column& column : columns) fields.push_back(quoted(column.name));
  out << fmt::format("{}\n", fmt::join(fields, ","));
  std::string result_line, timing_line;
  for (int n = 1; std::getline(results, result_line) && std::getline(timing, timing_line); ++n) {
    const Json result = parsed(results_file, n, result_line);
    const Json times = parsed(timing_file, n, timing_line);
    const Run run{cell_of(study, result, results_file, n), result, times};
    fields.clear();
    try {
      for (const Column& column : columns) fields.push_back(column.field(run));
    } catch (const Json::exception&) {
      throw InputError(results_file, n, "is not the line of a finished run");
    }
    out << fmt::format("{}\n", fmt::join(fields, ","));
  }
}

}  // namespace

void write_runs_table(const Study& study, const std::filesystem::path& folder) {
  write_file(folder / "runs.csv", [&](std::ostream& out) { write_rows(study, folder, out); });
}

}  // namespace slammot
