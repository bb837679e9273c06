#include "eval/journal/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <vector>

#include "datasets/text/input_error.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr char kFormat[] = "slammot-journal-1";

bool is_journal(const fs::path& file) {
  return file.filename().string().starts_with("journal-") && file.extension() == ".jsonl" &&
         fs::is_regular_file(file);
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

// The shards that the study is divided into: `N.jsonl` of journal-I-of-N.jsonl.
std::string division(const fs::path& journal) {
  const std::string name = journal.filename().string();
  return name.substr(name.rfind('-') + 1);
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

Json json_of(const JournalIdentity& identity) {
  return {{"journal",
           {{"format", kFormat},
            {"version", identity.version},
            {"program", identity.program},
            {"configuration", identity.configuration},
            {"recordings", identity.recordings}}}};
}

JournalIdentity identity_in(const Json& head) {
  return {head.at("version").get<std::string>(), head.at("program").get<std::string>(),
          head.at("configuration").get<std::string>(), head.value("recordings", "")};
}

// A line that is nested deeper than any run's would overflow the stack when it is written again.
Json parse_line(const std::string& line) {
  constexpr int kDeepest = 64;
  return Json::parse(line, [](int depth, Json::parse_event_t, const Json&) {
    if (depth > kDeepest) throw Json::other_error::create(501, "is nested too deeply", nullptr);
    return true;
  });
}

RunKey key_of(const Json& part) {
  const Json &cell = part.at("cell"), &seed = part.at("seed");
  if (!cell.is_number_unsigned() || !seed.is_number_unsigned()) {
    throw Json::other_error::create(501, "cell and seed are no counts", &part);
  }
  const auto number = cell.get<std::uint64_t>();
  constexpr std::uint64_t kMost = 1U << 30U;
  return {static_cast<int>(std::min(number, kMost)), seed.get<std::uint64_t>()};
}

// The lines of one journal, judged by the rules.
class JournalReader {
 public:
  JournalReader(const fs::path& file, const JournalRules& rules, std::map<RunKey, RunPlace>& places)
      : file_(file), rules_(rules), places_(places) {}

  void read(std::streamoff offset, int number, const std::string& line) {
    try {
      const Json json = parse_line(line);
      if (json.contains("journal")) {
        check(identity_in(json["journal"]), number);
        known_ = true;
      } else {
        add(json, offset, number);
      }
    } catch (const Json::exception&) {
      throw InputError(file_, number, "is not the line of a finished run");
    }
  }

 private:
  void check(const JournalIdentity& identity, int number) const {
    if (identity.configuration != rules_.identity.configuration) {
      throw InputError(file_, number, "these runs are of another configuration, or other defaults");
    }
    if (identity.recordings != rules_.identity.recordings && !rules_.mix) {
      throw InputError(file_, number,
                       "a recorded sequence has changed since these runs: --force goes on all the "
                       "same and mixes them");
    }
    if (identity.program != rules_.identity.program && !rules_.mix) {
      throw InputError(file_, number,
                       fmt::format("these runs were made by another build of the program ({}): "
                                   "--force goes on all the same and mixes them",
                                   identity.version));
    }
  }

  void add(const Json& json, std::streamoff offset, int number) {
    if (!known_ && !rules_.mix) {
      throw InputError(file_, number,
                       "these runs do not say what program made them: --force takes them");
    }
    const RunKey key = key_of(json.at("result"));
    const Json& diverged = json["result"].at("diverged");
    if (!diverged.is_null() && !diverged.is_object()) {
      throw InputError(file_, number, "'diverged' is neither null nor a frame with a reason");
    }
    if (key.first >= rules_.cells || key != key_of(json.at("timing"))) {
      throw InputError(file_, number, "is not a run of this study");
    }
    places_.insert({key, {file_, offset}});
  }

  const fs::path& file_;
  const JournalRules& rules_;
  std::map<RunKey, RunPlace>& places_;
  bool known_ = false;  // who made the lines that follow
};

}  // namespace

void add_journals(const fs::path& folder, const JournalRules& rules,
                  std::map<RunKey, RunPlace>& places) {
  for (const fs::path& file : journals(folder)) {
    JournalReader reader(file, rules, places);
    for_each_line(file, [&](std::streamoff offset, int number, const std::string& line) {
      reader.read(offset, number, line);
    });
  }
}

Json read_run_line(const RunPlace& place) {
  std::ifstream in(place.file, std::ios::binary);
  in.seekg(place.offset);
  std::string line;
  std::getline(in, line);
  return parse_line(line);
}

void Journal::fail() const {
  throw std::runtime_error(fmt::format("{}: {}", file_.string(), std::strerror(errno)));
}

// Of two processes that begin at once, each with its own journal locked, one at least sees the
// other.
void Journal::require_no_other_division() const {
  for (const fs::path& other : journals(file_.parent_path())) {
    if (division(other) == division(file_)) continue;
    const int descriptor = ::open(other.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) continue;  // it is read later, and named then
    const bool locked = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0;
    ::close(descriptor);
    if (!locked) continue;
    throw std::invalid_argument(other.string() +
                                ": another process is at work, with another number of shards");
  }
}

Journal::Journal(const fs::path& folder, const std::string& name, const JournalIdentity& identity)
    : file_(folder / name), lock_(file_) {
  open(identity);
}

void Journal::open(const JournalIdentity& identity) {
  require_no_other_division();
  std::streamoff whole = 0;
  std::string head;  // the last one
  for_each_line(file_, [&](std::streamoff offset, int, const std::string& line) {
    if (line.starts_with("{\"journal\"")) head = line;
    whole = offset + static_cast<std::streamoff>(line.size()) + 1;
  });
  if (::ftruncate(lock_.descriptor(), whole) != 0) fail();
  const std::string mine = json_of(identity).dump();
  if (head != mine) head_ = mine + '\n';
}

// A line that cannot be written whole, as on a full device, leaves nothing behind: others may
// follow it.
void Journal::append(const Json& result, const Json& timing) {
  const std::string run = Json{{"result", result}, {"timing", timing}}.dump(
      -1, ' ', false, Json::error_handler_t::replace);
  const std::lock_guard lock(mutex_);
  const std::string line = head_ + run + '\n';
  const off_t before = ::lseek(lock_.descriptor(), 0, SEEK_END);
  if (before < 0) fail();
  for (std::size_t written = 0; written < line.size();) {
    const ssize_t n = ::write(lock_.descriptor(), line.data() + written, line.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int error = errno;
      [[maybe_unused]] const int cut = ::ftruncate(lock_.descriptor(), before);
      errno = error;
      fail();
    }
    written += static_cast<std::size_t>(n);
  }
  if (::fdatasync(lock_.descriptor()) != 0) fail();
  head_.clear();
}

}  // namespace slammot
