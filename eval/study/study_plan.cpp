#include "eval/study/study_plan.h"

#include "eval/configuration/registry.h"
#include "eval/output/metrics_json.h"
#include "eval/study/study_cross.h"
#include "eval/study/study_sequence.h"

namespace slammot {
namespace {

Json planned_cell_json(const StudyCell& cell) {
  const EstimatorRow& estimator = find_estimator(cell.estimator);
  return {{"label", cell.label},
          {"estimator", cell.estimator},
          {"kind", to_string(estimator.kind)},
          {"oracle", is_oracle(estimator, cell.configuration)},
          {"configuration", configuration_json(cell)}};
}

Json group_json(const StudyCell& first) {
  const bool recorded = !first.sequence.empty();
  Json group = {{"name", first.group},
                {"scenario", first.scenario},
                {"sequence", recorded ? Json(first.sequence.string()) : Json()},
                {"seeds", !recorded              ? "simulations"
                          : is_single_run(first) ? "one run"
                                                 : "noise"},
                {"scene", first.scene},
                {"sweep", Json::object()},
                {"cells", Json::array()}};
  for (const auto& [key, value] : first.sweep) group["sweep"][key] = value;
  return group;
}

Json latex_json(const std::optional<LatexTable>& latex) {
  if (!latex) return nullptr;
  return {{"columns", latex->columns}, {"labels", latex->labels}, {"caption", latex->caption}};
}

}  // namespace

Json study_plan(const Study& study, const Provenance& made_by) {
  Json json = {{"format", "slammot-plan-1"},
               {"version", SLAMMOT_VERSION},
               {"provenance", json_of(made_by)},
               {"name", study.name},
               {"title", study.title},
               {"runs", study.runs},
               {"first_seed", study.first_seed},
               {"figures", study.figures},
               {"latex", latex_json(study.latex)},
               {"metrics", metric_table_json(study.metrics)},
               {"groups", Json::array()}};
  if (study.reference) {
    json["reference"] = {{"label", study.reference->label},
                         {"static", study.reference->statics},
                         {"moving", study.reference->movings}};
  }
  for (const StudyCell& cell : study.cells) {
    Json& groups = json["groups"];
    if (groups.empty() || groups.back()["name"] != cell.group) groups.push_back(group_json(cell));
    groups.back()["cells"].push_back(planned_cell_json(cell));
  }
  return json;
}

}  // namespace slammot
