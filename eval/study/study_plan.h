// What the judge of a study (python/slammot/pooling) needs to know beside the runs: plan.json.
//
//   format "slammot-plan-1", version, provenance, name, title, runs, first_seed, figures[], latex,
//   metrics[] the table of metrics, reference (labels that somebody published)
//   groups[] {name, scenario, sequence, seeds, scene, sweep, cells[]}; cells[] in the order of
//   results.jsonl: {label, estimator, kind, oracle, configuration}
#pragma once

#include <nlohmann/json.hpp>

#include "eval/provenance/provenance.h"
#include "eval/study/study.h"

namespace slammot {

nlohmann::ordered_json study_plan(const Study& study, const Provenance& made_by = provenance());

}  // namespace slammot
