// Metrics of stored runs, also of runs made elsewhere, against a sequence.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "eval/metrics/pose_pairs.h"
#include "eval/output/metrics_table.h"
#include "eval/output/run_reader.h"
#include "eval/trajectory/align_run.h"
#include "eval/trajectory/error_convention.h"
#include "eval/trajectory/extrinsics.h"

namespace slammot {

// How runs that were made elsewhere are read: those without a run.yaml of this program's format.
struct ForeignOptions {
  ErrorConvention convention;  // of their pose_covariance.csv
  TimeMatching times;
  std::optional<Eigen::Isometry3d> T_body_camera;  // of poses that are a body's
};

struct JudgeOptions {
  ForeignOptions foreign;
  AlignBy align = AlignBy::kNone;  // also runs of this program
  bool force_sequence = false;     // also another than run.yaml states by its SHA-256
};

struct JudgedRun {
  std::filesystem::path path;
  std::string estimator;  // its name
  std::shared_ptr<const Sequence> sequence;
  StoredRun stored;
  RunMetrics metrics;
};

// Reads every sequence once.
class Judge {
 public:
  explicit Judge(JudgeOptions options) : options_(options) {}

  // `run`: a run folder, or the file of a trajectory (trajectory_file.h). Without `against`, the
  // sequence is the one run.yaml names. Throws InputError.
  JudgedRun operator()(const std::filesystem::path& run,
                       const std::optional<std::filesystem::path>& against);

 private:
  std::shared_ptr<const Sequence> sequence_at(const std::filesystem::path& path);

  JudgeOptions options_;
  std::map<std::filesystem::path, std::shared_ptr<const Sequence>> sequences_;
};

// The last part of a run's path, `..` resolved; without the ending of a file.
std::string run_name(const std::filesystem::path& run);

}  // namespace slammot
