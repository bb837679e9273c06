#include "eval/study/study_store.h"

#include <fmt/format.h>

#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
#include "datasets/sequence/sha256.h"
#include "datasets/text/text_table.h"
#include "eval/configuration/registry.h"
#include "eval/run/process.h"
#include "eval/study/study_cross.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json cell_json(const StudyCell& cell) {
  Json scene = Json::object();
  if (cell.sequence.empty()) {
    for (const ScenarioParameter& p : scenario_parameters(cell.scenario)) scene[p.name] = p.value;
  }
  return {{"group", cell.group},         {"label", cell.label},
          {"scenario", cell.scenario},   {"sequence", cell.sequence},
          {"defaults", scene},           {"set", cell.scene},
          {"estimator", cell.estimator}, {"configuration", configuration_json(cell)}};
}

// Without the number of runs, so that a study can be given more.
std::string configuration_sha256(const Study& study) {
  Json json = {{"seed", study.first_seed}, {"tracks", study.tracks}, {"cells", Json::array()}};
  for (const StudyCell& cell : study.cells) json["cells"].push_back(cell_json(cell));
  Sha256 hash;
  hash.add(json.dump());
  return hash.hex();
}

std::string recordings_sha256(const Study& study) {
  if (study.recordings.empty()) return "";
  Sha256 hash;
  for (const auto& [folder, sha256] : study.recordings) {
    hash.add(fmt::format("{} {}\n", folder, sha256));
  }
  return hash.hex();
}

JournalRules rules_of(const Study& study, bool mix) {
  return {identity_of(study), static_cast<int>(study.cells.size()), mix};
}

// The study's file as it stands in its folder; it may have been read from there.
std::string marked(const std::string& text) {
  return text.starts_with(kStudyOutput.begins) ? text : std::string(kStudyOutput.begins) + text;
}

bool is_of(const Study& study, const fs::path& folder) {
  return is_own(folder, kStudyOutput) &&
         read_text_file(folder / kStudyOutput.mark) == marked(study.text);
}

[[noreturn]] void refuse(const fs::path& folder, const char* reason) {
  throw std::invalid_argument(folder.string() + " " + reason);
}

}  // namespace

JournalIdentity identity_of(const Study& study) {
  return {SLAMMOT_VERSION, program_sha256(), configuration_sha256(study), recordings_sha256(study)};
}

// SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t Shard::scattered(int task) {
  std::uint64_t z = static_cast<std::uint64_t>(task) + 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

std::string Shard::journal() const { return fmt::format("journal-{}-of-{}.jsonl", index, count); }

std::set<RunKey> finished_runs(const Study& study, const fs::path& folder, bool mix) {
  std::map<RunKey, RunPlace> places;
  add_journals(folder, rules_of(study, mix), places);
  std::set<RunKey> keys;
  for (const auto& [key, place] : places) keys.insert(key);
  return keys;
}

void merge_runs(const Study& study, const std::vector<fs::path>& folders, const fs::path& output,
                bool mix) {
  const JournalRules rules = rules_of(study, mix);
  std::map<RunKey, RunPlace> places;
  for (const fs::path& folder : folders) {
    if (!fs::is_directory(folder)) refuse(folder, "is no folder");
    if (!is_of(study, folder)) refuse(folder, "holds another study (its study.yaml differs)");
    add_journals(folder, rules, places);
  }
  const int cells = rules.cells;
  for (int task = 0, all = study.tasks(); task < all; ++task) {
    if (!study.computes(task)) continue;
    const StudyCell& cell = study.cells[static_cast<std::size_t>(task % cells)];
    const std::uint64_t seed = study.seed(task / cells);
    if (places.contains({task % cells, seed})) continue;
    throw std::invalid_argument(
        fmt::format("a run is missing: {}, {}, seed {}", cell.group, cell.label, seed));
  }
  const auto computed_by = [&](int cell) {
    return study.cells[static_cast<std::size_t>(cell)].computed_by;
  };
  OutputFiles files;
  const auto write_part = [&](const char* file, const char* part) {
    files.write(output / file, [&](std::ostream& out) {
      for (int cell = 0; cell < cells; ++cell) {
        for (int run = 0; run < study.runs_of(static_cast<std::size_t>(cell)); ++run) {
          Json line = read_run_line(places.at({computed_by(cell), study.seed(run)})).at(part);
          line["cell"] = cell;
          if (line.contains("seconds") && computed_by(cell) != cell) line["seconds"] = 0.0;
          out << line.dump() << '\n';
        }
      }
    });
  };
  write_part("timing.jsonl", "timing");
  write_part("results.jsonl", "result");
  files.put_in_place();
}

void claim_folder(const Study& study, const fs::path& folder, const Shard& shard, bool resume) {
  fs::create_directories(folder);
  require_output(folder, kStudyOutput, true);
  if (is_own(folder, kStudyOutput)) {
    if (!is_of(study, folder)) refuse(folder, "holds another study (its study.yaml differs)");
    if (!resume && fs::exists(folder / shard.journal())) {
      refuse(folder, "has runs already: --resume goes on with them");
    }
    return;
  }
  // Whole at once: another shard that begins now sees all of it or nothing.
  write_file(folder / kStudyOutput.mark, marked(study.text));
}

}  // namespace slammot
