// libFuzzer's entry. SLAMMOT_FUZZ names the target; without it the names are listed.
// SLAMMOT_FUZZ_SEED is a file to which the target's good file is written, to begin with. A
// std::logic_error leaves, and is a crash.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>

#include "tests/fuzz/target.h"

namespace {

std::unique_ptr<slammot::fuzz::Bench> bench;

void choose(std::string_view name) {
  for (const auto& target : slammot::fuzz::SLAMMOT_FUZZ_TABLE()) {
    if (target.name == name) bench = std::make_unique<slammot::fuzz::Bench>(target);
    if (name.empty()) std::printf("%s\n", std::string(target.name).c_str());
  }
  if (!bench) std::exit(name.empty() ? 0 : 2);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* name = std::getenv("SLAMMOT_FUZZ");
  choose(name ? name : "");
  if (const char* seed = std::getenv("SLAMMOT_FUZZ_SEED")) {
    std::ofstream(seed, std::ios::binary) << bench->good();
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  bench->run({reinterpret_cast<const char*>(data), size});
  return 0;
}
