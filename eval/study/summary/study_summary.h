// What the runs of a study say together: summary.json, whose fields docs/formats.md gives.
//
// Diverged runs are never dropped silently: they are listed with their seeds, their frames count
// until they end, and in a paired comparison they lose. An accuracy over whole runs is over those
// that finished, and says how many.
#pragma once

#include <nlohmann/json.hpp>

#include "eval/provenance/provenance.h"
#include "eval/study/study.h"

namespace slammot {

// Reads results.jsonl and timing.jsonl of the folder, both sorted by cell: the samples of one cell
// are in memory at a time.
nlohmann::ordered_json summarise_study(const Study& study, const std::filesystem::path& folder,
                                       const Provenance& made_by = provenance());

}  // namespace slammot
