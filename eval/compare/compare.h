// Several estimators over one sequence, side by side: a run folder each, compare.json, and a table.
//
// compare.json (what python/slammot/report reads; null where a number is not defined):
//   format "slammot-compare-1", version, command,
//   sequence {name, path, sha256, seed, frames, exact_truth, width, height, pixel_sigma}
//            in a report of runs that of the first, and {count, names[]} of all
//   truth    {timestamp[], position[[x,y,z]], landmarks[{track, class, position[x,y,z],
//   last[x,y,z]}]}
//            `last` is where a moving landmark is at its last frame
//   metrics[] the table of metrics: what each key of `runs[].metrics` means
//   runs[]   {label, estimator, kind, oracle, landmark, folder (relative), overrides{},
//             configuration{},
//             metrics (as metrics.json, without the NEES series), series, smoothed_series (or
//             null)}
//   series   {stride, frame[], timestamp[], position[[x,y,z]], position_error_m[],
//             rotation_error_deg[], nees_pose[], nees_position[], nees_rotation[], and for the
//             filtered one nis_mean[], accepted[], rejected[], state_size[], frame_ms[]}
//            every stride-th frame, at most about 2000. With a measured truth also alignment
//            {scale, rotation[[3],[3],[3]], translation[3]} by Sim(3) and
//            aligned_position_error_m[]
//   runs[].frames          errors and NEES of every frame (eval/output/judged_frames.h), and
//            timestamp[]: what runs of one name, and two of them, say together is made of them
//            (python/slammot/pooling/estimators.py writes it to pooled.json); the name is in
//            runs[].pooled, and stored runs have sequence {name, sha256}
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "eval/output/metrics_table.h"
#include "eval/output/run_writer.h"
#include "eval/run/run.h"

namespace slammot {

struct ComparedRun {
  std::string label;  // also the name of its folder
  std::string estimator;
  std::vector<Assignment> overrides;
};

struct CompareOptions {
  std::filesystem::path output;
  std::string command;
  std::optional<std::uint64_t> seed;
  bool landmarks_every_frame = false;
  CheckRotation check_rotation;  // may be empty
  MetricTable metrics = metric_table();
  // After each frame of a run, of which `run` were before; may be empty.
  std::function<void(const std::string& label, std::size_t run, int done, int total)> progress;
};

// Each estimator with each landmark model, labelled `estimator-landmark`; once, if it has no
// models. An estimator may have settings of its own, `NAME:KEY=VALUE,..`, which win.
std::vector<ComparedRun> crossed(const std::vector<std::string>& estimators,
                                 const std::vector<std::string>& landmarks);

ComparedRun with_settings(const std::string& text);

// Runs all, in order, and writes the output folder.
std::vector<NamedMetrics> compare(const Sequence& sequence, const Configuration& configuration,
                                  const std::vector<ComparedRun>& runs,
                                  const CompareOptions& options);

}  // namespace slammot
