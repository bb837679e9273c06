#include "eval/study/study_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>

#include "datasets/text/text_table.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Where a run's line stands.
struct Place {
  fs::path file;
  std::streamoff offset = 0;
};

bool is_journal(const fs::path& file) {
  return file.filename().string().starts_with("journal-") && file.extension() == ".jsonl";
}

std::vector<fs::path> journals(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (is_journal(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

RunKey key_of(const Json& line) {
  return {line.at("cell").get<int>(), line.at("seed").get<std::uint64_t>()};
}

// Every whole line of a file.
void for_each_line(const fs::path& file,
                   const std::function<void(std::streamoff, int, const std::string&)>& visit) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  std::streamoff offset = 0;
  for (int number = 1; std::getline(in, line); ++number) {
    if (in.eof()) break;  // no newline: it was being written
    visit(offset, number, line);
    offset += static_cast<std::streamoff>(line.size()) + 1;
  }
}

Json parse(const fs::path& file, int number, const std::string& line) {
  try {
    return Json::parse(line);
  } catch (const Json::exception&) {
    throw InputError(file, number, "is not a line of JSON");
  }
}

void add_places(const fs::path& file, std::map<RunKey, Place>& places) {
  for_each_line(file, [&](std::streamoff offset, int number, const std::string& line) {
    const Json json = parse(file, number, line);
    if (!json.contains("result")) throw InputError(file, number, "is not a finished run");
    places.insert({key_of(json["result"]), {file, offset}});
  });
}

Json read_line(const Place& place) {
  std::ifstream in(place.file, std::ios::binary);
  in.seekg(place.offset);
  std::string line;
  std::getline(in, line);
  return Json::parse(line);
}

void replace(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  const fs::path unfinished =
      fmt::format("{}.{}.unfinished", file.string(), static_cast<int>(::getpid()));
  {
    std::ofstream out(unfinished, std::ios::binary);
    write(out);
    out.flush();
    if (!out) throw std::runtime_error(unfinished.string() + ": cannot be written");
  }
  fs::rename(unfinished, file);
}

bool is_of(const Study& study, const fs::path& folder) {
  return fs::exists(folder / "study.yaml") && read_text_file(folder / "study.yaml") == study.text;
}

}  // namespace

// SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t Shard::scattered(int task) {
  std::uint64_t z = static_cast<std::uint64_t>(task) + 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

std::string Shard::journal() const { return fmt::format("journal-{}-of-{}.jsonl", index, count); }

std::set<RunKey> finished_runs(const fs::path& folder) {
  std::map<RunKey, Place> places;
  for (const fs::path& file : journals(folder)) add_places(file, places);
  std::set<RunKey> keys;
  for (const auto& [key, place] : places) keys.insert(key);
  return keys;
}

Journal::Journal(const fs::path& folder, const Shard& shard) : file_(folder / shard.journal()) {
  std::streamoff whole = 0;
  for_each_line(file_, [&](std::streamoff offset, int, const std::string& line) {
    whole = offset + static_cast<std::streamoff>(line.size()) + 1;
  });
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor_ < 0 || ::ftruncate(descriptor_, whole) != 0) {
    throw std::runtime_error(file_.string() + ": " + std::strerror(errno));
  }
}

Journal::~Journal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Journal::append(const StudyRun& run) {
  const std::string line = Json{{"result", run.result}, {"timing", run.timing}}.dump() + '\n';
  const std::lock_guard lock(mutex_);
  std::size_t written = 0;
  while (written < line.size()) {
    const ssize_t n = ::write(descriptor_, line.data() + written, line.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw std::runtime_error(file_.string() + ": " + std::strerror(errno));
    written += static_cast<std::size_t>(n);
  }
  ::fdatasync(descriptor_);
}

void merge_runs(const Study& study, const std::vector<fs::path>& folders, const fs::path& output) {
  std::map<RunKey, Place> places;
  for (const fs::path& folder : folders) {
    if (!fs::is_directory(folder)) {
      throw std::invalid_argument(folder.string() + ": no such folder");
    }
    if (!is_of(study, folder)) {
      throw std::invalid_argument(folder.string() +
                                  " holds another study (its study.yaml differs)");
    }
    for (const fs::path& file : journals(folder)) add_places(file, places);
  }
  const int cells = static_cast<int>(study.cells.size());
  for (int cell = 0; cell < cells; ++cell) {
    for (int run = 0; run < study.runs_of(static_cast<std::size_t>(cell)); ++run) {
      if (places.count({cell, study.seed(run)}) > 0) continue;
      const StudyCell& c = study.cells[static_cast<std::size_t>(cell)];
      throw std::invalid_argument(
          fmt::format("a run is missing: {}, {}, seed {}", c.group, c.label, study.seed(run)));
    }
  }
  const auto write_part = [&](const char* part) {
    replace(output / fmt::format("{}.jsonl", part == std::string("result") ? "results" : part),
            [&](std::ostream& out) {
              for (int cell = 0; cell < cells; ++cell) {
                for (int run = 0; run < study.runs_of(static_cast<std::size_t>(cell)); ++run) {
                  out << read_line(places.at({cell, study.seed(run)})).at(part).dump() << '\n';
                }
              }
            });
  };
  write_part("timing");
  write_part("result");
}

void claim_folder(const Study& study, const fs::path& folder, const Shard& shard, bool resume) {
  fs::create_directories(folder);
  const fs::path mark = folder / "study.yaml";
  if (fs::exists(mark) && !is_of(study, folder)) {
    throw std::invalid_argument(folder.string() + " holds another study (its study.yaml differs)");
  }
  if (fs::exists(folder / "compare.json")) {
    throw std::invalid_argument(folder.string() + " holds a comparison: a study needs its own");
  }
  if (!resume && fs::exists(folder / shard.journal())) {
    throw std::invalid_argument(folder.string() + " has runs already: --resume goes on with them");
  }
  if (fs::exists(mark)) return;
  // Whole at once: another shard that begins now sees all of it or nothing.
  replace(mark, [&](std::ostream& out) { out << study.text; });
}

}  // namespace slammot
