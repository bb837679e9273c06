// The finished runs of a study as lines of JSON, appended at once.
//
//   {"journal": {format, version, program, configuration, recordings}}   who made the lines that
//   follow
//   {"result": {cell, seed, ..}, "timing": {cell, seed, ..}} a run, in the order of finishing
//
// A line that was being written when the program was killed is no line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "datasets/output/file_lock.h"

namespace slammot {

// What runs depend on. `program`: SHA-256 of the program's file. `configuration`: SHA-256 of all
// that is set, defaults included. `recordings`: SHA-256 of those of the recorded sequences, empty
// where there is none.
struct JournalIdentity {
  std::string version, program, configuration;
  std::string recordings = {};

  bool operator==(const JournalIdentity&) const = default;
};

// Which journals a study may go on with. Another configuration is always refused, another program
// or another content of a recording unless these are to be mixed.
struct JournalRules {
  JournalIdentity identity;
  int cells = 0;
  bool mix = false;
};

using RunKey = std::pair<int, std::uint64_t>;  // cell, seed

// Where a run's line stands.
struct RunPlace {
  std::filesystem::path file;
  std::streamoff offset = 0;
};

// Adds the runs in the journals of a folder. Throws InputError with file and line for what is not a
// run of this study, or std::invalid_argument if the rules forbid it.
void add_journals(const std::filesystem::path& folder, const JournalRules& rules,
                  std::map<RunKey, RunPlace>& places);

nlohmann::ordered_json read_run_line(const RunPlace& place);

// Appends, one whole line at a time, from any thread. While it lives no other process can open this
// journal, nor one of the same folder that divides the study into another number of shards.
class Journal {
 public:
  // `name` is journal-I-of-N.jsonl. Cuts off a line that was left half written. Throws
  // std::invalid_argument if another process is at work, std::runtime_error if it cannot be
  // written.
  Journal(const std::filesystem::path& folder, const std::string& name,
          const JournalIdentity& identity);

  void append(const nlohmann::ordered_json& result, const nlohmann::ordered_json& timing);

 private:
  void open(const JournalIdentity& identity);
  void require_no_other_division() const;
  [[noreturn]] void fail() const;

  std::filesystem::path file_;
  FileLock lock_;
  std::string head_;  // written with the first run, if this program's does not stand there yet
  std::mutex mutex_;
};

}  // namespace slammot
