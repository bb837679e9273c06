#include "eval/provenance/provenance.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <fstream>
#include <thread>

namespace slammot {
namespace {

struct Commit {
  std::string id = "unknown";
  bool modified = true;
};

Commit& commit() {
  static Commit stated;
  return stated;
}

constexpr const char* compiler() {
#ifdef __clang__
  return "clang " __clang_version__;
#else
  return "g++ " __VERSION__;
#endif
}

std::string cpu() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

void state_commit(const std::string& id, bool modified) { commit() = {id, modified}; }

Provenance provenance(int jobs) {
  return {SLAMMOT_VERSION,
          commit().id,
          commit().modified,
          compiler(),
          cpu(),
          static_cast<int>(std::thread::hardware_concurrency()),
          jobs,
          fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))};
}

std::string version_text() {
  return fmt::format("{} (commit {}{}; {})", SLAMMOT_VERSION, commit().id,
                     commit().modified ? ", modified" : "", compiler());
}

nlohmann::ordered_json json_of(const Provenance& p) {
  return {{"version", p.version},   {"commit", p.commit}, {"modified", p.modified},
          {"compiler", p.compiler}, {"cpu", p.cpu},       {"cores", p.cores},
          {"jobs", p.jobs},         {"date", p.date}};
}

}  // namespace slammot
