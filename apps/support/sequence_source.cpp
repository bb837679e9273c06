#include "apps/support/sequence_source.h"

#include "datasets/native/native_writer.h"
#include "datasets/readers/reader.h"

namespace slammot {

ScenarioOverrides overrides_of(const ScenarioOptions& options) {
  ScenarioOverrides overrides;
  for (const std::string& text : options.settings) {
    const Assignment assignment = parse_assignment(text);
    overrides[assignment.key] = assignment.value;
  }
  return overrides;
}

Sequence simulate_to(const ScenarioOptions& options, const std::filesystem::path& folder) {
  write_native(simulate(options.scenario, overrides_of(options), options.seed), folder);
  return read_sequence(folder);
}

}  // namespace slammot
