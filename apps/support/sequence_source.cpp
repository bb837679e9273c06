#include "apps/support/sequence_source.h"

#include <stdexcept>

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

Sequence selected(Sequence sequence, const FrameSelection& frames) {
  const std::string name = sequence.name;
  Sequence result = select_frames(std::move(sequence), frames.first, frames.last, frames.step);
  if (result.frames.empty()) {
    throw std::invalid_argument("frames.first and frames.last leave no frame of " + name);
  }
  return result;
}

}  // namespace slammot
