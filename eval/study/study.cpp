#include "eval/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "datasets/simulation/scenario.h"
#include "datasets/text/text_table.h"
#include "datasets/text/yaml_map.h"
#include "eval/configuration/registry.h"
#include "eval/study/study_cross.h"
#include "eval/study/study_figures.h"
#include "eval/study/study_sequence.h"

namespace slammot {
namespace {

void add_line(std::string& text, const std::string& line) {
  if (!text.ends_with('\n')) text += '\n';
  text += line + '\n';
}

class Reader {
 public:
  Reader(std::filesystem::path file, const std::vector<std::string>& settings)
      : file_(std::move(file)), settings_(settings) {}

  Study read() {
    Study study;
    study.text = read_text_file(file_);
    for (const std::string& setting : settings_)
      add_line(study.text, std::string(kSetLine) + setting);
    YamlMap top = load_yaml(file_, study.text);
    if (const std::string format = top.text("format"); format != "slammot-study-1") {
      top.refuse(top.take("format"), "unknown format '" + format + "' (known: slammot-study-1)");
    }
    study.name = top.text("name");
    if (const std::string fault = folder_name_fault(study.name); !fault.empty()) {
      top.refuse(top.take("name"), "'name' " + fault);
    }
    study.title = top.has("title") ? top.text("title") : study.name;
    if (top.has("runs")) study.runs = top.positive_integer("runs");
    if (top.has("seed")) {
      study.first_seed = static_cast<std::uint64_t>(top.positive_integer("seed"));
    }
    const auto scenarios = named(top, "scenarios", "scenario");
    const auto estimators = named(top, "estimators", "estimator");
    Settings all;
    if (top.has("configuration")) all = assignments(top.take("configuration"), "configuration");
    const auto sweep = swept(top);
    read_record(top, study);
    read_figures(top, study);
    read_reference(top, study);
    read_latex(top, study);
    top.finish();
    try {
      const Settings set = settings_in(study.text);
      require_free(set, estimators, sweep);
      all.insert(all.end(), set.begin(), set.end());
      study.cells = cross(scenarios, sweep, estimators, all);
    } catch (const std::invalid_argument& error) {
      throw InputError(file_, 0, error.what());
    }
    return study;
  }

 private:
  [[noreturn]] void refuse(const YAML::Node& at, const std::string& reason) const {
    throw InputError(file_, at.Mark().line + 1, reason);
  }

  std::string scalar(const YAML::Node& node, const std::string& what) const {
    if (!node.IsScalar()) refuse(node, fmt::format("'{}' must be one value", what));
    if (has_control_character(node.Scalar())) {
      refuse(node, fmt::format("'{}' contains a control character", what));
    }
    return node.Scalar();
  }

  Settings settings(const YAML::Node& node, const std::string& what) const {
    if (!node.IsMap()) refuse(node, fmt::format("'{}' must be a map of keys to values", what));
    Settings result;
    for (const auto& pair : node) {
      result.emplace_back(pair.first.Scalar(), scalar(pair.second, pair.first.Scalar()));
    }
    return result;
  }

  // Of keys of the configuration, each tried.
  Settings assignments(const YAML::Node& node, const std::string& what) const {
    Settings result = settings(node, what);
    for (const auto& pair : node) {
      try_assignment(pair.first, {pair.first.Scalar(), pair.second.Scalar()});
    }
    return result;
  }

  void try_assignment(const YAML::Node& at, const Assignment& assignment) const {
    try {
      Configuration scratch;
      assign(scratch, assignment);
    } catch (const std::invalid_argument& error) {
      refuse(at, error.what());
    }
  }

  void try_estimator(const YAML::Node& at, const std::string& name) const {
    try {
      find_estimator(name);
    } catch (const std::invalid_argument& error) {
      refuse(at, error.what());
    }
  }

  std::vector<NamedSettings> named(YamlMap& top, const std::string& list, const std::string& kind) {
    const YAML::Node node = top.take(list);
    if (!node.IsSequence() || node.size() == 0) {
      top.refuse(node, fmt::format("'{}' must be a list of at least one {}", list, kind));
    }
    std::vector<NamedSettings> result;
    std::set<std::string> labels;
    for (const auto& item : node) {
      YamlMap map(file_, item, "an entry of '" + list + "'");
      NamedSettings row;
      row.line = item.Mark().line + 1;
      row.recorded = kind == "scenario" && map.has("sequence");
      row.name = row.recorded ? folder_of(map.text("sequence")) : map.text(kind);
      const std::string name =
          row.recorded ? std::filesystem::path(row.name).filename().string() : row.name;
      if (kind == "estimator") try_estimator(item[kind], row.name);
      row.label = map.has("label") ? map.text("label") : name;
      if (map.has("set")) {
        const YAML::Node set = map.take("set");
        row.settings = kind == "estimator" ? assignments(set, "set") : settings(set, "set");
      }
      map.finish();
      if (row.label.find(',') != std::string::npos) {
        refuse(item, "the label '" + row.label + "' has a comma, which separates swept values");
      }
      if (!labels.insert(row.label).second) refuse(item, "two are called '" + row.label + "'");
      result.push_back(std::move(row));
    }
    return result;
  }

  // Relative to the study's file.
  std::string folder_of(const std::string& sequence) const {
    const std::filesystem::path folder = (file_.parent_path() / sequence).lexically_normal();
    return (folder.has_filename() ? folder : folder.parent_path()).string();
  }

  std::vector<SweptKey> swept(YamlMap& top) const {
    std::vector<SweptKey> result;
    if (!top.has("sweep")) return result;
    const YAML::Node node = top.take("sweep");
    if (!node.IsMap()) refuse(node, "'sweep' must be a map of keys to lists of values");
    for (const auto& pair : node) {
      SweptKey key{pair.first.Scalar(), {}};
      if (!pair.second.IsSequence() || pair.second.size() == 0) {
        refuse(pair.second, fmt::format("'{}' must be a list of values", key.key));
      }
      for (const auto& value : pair.second) {
        key.values.push_back(scalar(value, key.key));
        if (!is_of_scenario(key.key)) try_assignment(pair.first, {key.key, value.Scalar()});
      }
      result.push_back(std::move(key));
    }
    return result;
  }

  void read_record(YamlMap& top, Study& study) const {
    if (!top.has("record")) return;
    YamlMap record = top.map("record");
    study.tracks = record.counts("tracks");
    record.finish();
  }

  void read_figures(YamlMap& top, Study& study) const {
    if (!top.has("figures")) return;
    for (const auto& figure : top.take("figures")) {
      study.figures.push_back(scalar(figure, "figures"));
      try {
        require_figure(study.figures.back());
      } catch (const std::invalid_argument& error) {
        refuse(figure, error.what());
      }
    }
  }

  static void read_reference(YamlMap& top, Study& study) {
    if (!top.has("reference")) return;
    YamlMap map = top.map("reference");
    ReferenceLabels& reference = study.reference.emplace();
    reference.label = map.text("label");
    for (const auto& [key, counts] :
         {std::pair("static", &reference.statics), std::pair("moving", &reference.movings)}) {
      const std::vector<int> given = map.counts(key);
      if (given.size() != counts->size()) map.refuse(map.take(key), "must be three numbers");
      std::ranges::copy(given, counts->begin());
    }
    map.finish();
  }

  void read_latex(YamlMap& top, Study& study) const {
    if (!top.has("latex")) return;
    YamlMap map = top.map("latex");
    LatexTable& latex = study.latex.emplace();
    for (const auto& column : map.take("columns")) {
      latex.columns.push_back(scalar(column, "columns"));
      try {
        require_number(latex.columns.back());
      } catch (const std::invalid_argument& error) {
        refuse(column, error.what());
      }
    }
    if (latex.columns.empty()) map.refuse(map.take("columns"), "'columns' must be a list of keys");
    if (map.has("labels")) {
      for (const auto& [name, label] : settings(map.take("labels"), "labels")) {
        latex.labels[name] = label;
      }
    }
    if (map.has("caption")) latex.caption = map.text("caption");
    map.finish();
  }

  std::filesystem::path file_;
  const std::vector<std::string>& settings_;
};

// A scenario's parameters are known only to its simulator, which checks them; a sequence is read.
void try_scenarios(const std::filesystem::path& file, Study& study) {
  std::set<std::string> tried;
  for (const StudyCell& cell : study.cells) {
    if (!tried.insert(cell.group).second) continue;
    try {
      if (cell.sequence.empty()) {
        check_scenario(cell.scenario, cell.scene, study.first_seed);
      } else {
        const Sequence sequence = study_sequence(cell, study.first_seed);
        study.recordings[cell.sequence.string()] = sequence.sha256;
      }
    } catch (const std::invalid_argument& error) {
      throw InputError(file, cell.line, error.what());
    }
  }
}

// A study is its file and its scripts: with one that has changed, a folder holds another study.
void state_scripts(Study& study) {
  std::set<std::string> stated;
  for (const StudyCell& cell : study.cells) {
    const std::string sha256 = estimator_sha256(cell.estimator);
    if (sha256.empty() || !stated.insert(cell.estimator).second) continue;
    const std::string line = fmt::format("# {} sha256 {}", cell.estimator, sha256);
    if (study.text.find(line + '\n') != std::string::npos) continue;  // the study.yaml of a folder
    add_line(study.text, line);
  }
}

}  // namespace

int Study::tasks() const {
  constexpr std::int64_t kMost = 100'000'000;
  const std::int64_t all = static_cast<std::int64_t>(cells.size()) * runs;
  if (all > kMost) throw std::invalid_argument(fmt::format("{}: {} runs are too many", name, all));
  return static_cast<int>(all);
}

int Study::runs_of(std::size_t cell) const { return is_single_run(cells[cell]) ? 1 : runs; }

bool Study::has_task(int task) const {
  const int count = static_cast<int>(cells.size());
  return task / count < runs_of(static_cast<std::size_t>(task % count));
}

bool Study::computes(int task) const {
  const int cell = task % static_cast<int>(cells.size());
  return has_task(task) && cells[static_cast<std::size_t>(cell)].computed_by == cell;
}

Study parse_study(const std::filesystem::path& file, const std::vector<std::string>& settings) {
  Study study = Reader(file, settings).read();
  try {
    check_figures(study);
  } catch (const std::invalid_argument& error) {
    throw InputError(file, 0, error.what());
  }
  return study;
}

Study read_study(const std::filesystem::path& file, const std::vector<std::string>& settings) {
  Study study = parse_study(file, settings);
  state_scripts(study);
  try_scenarios(file, study);
  return study;
}

}  // namespace slammot
