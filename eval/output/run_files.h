// Names and heads of the files of a run folder, shared by writer and reader.
#pragma once

namespace slammot::run_files {

inline constexpr char kDescription[] = "run.yaml";
inline constexpr char kFormat[] = "slammot-run-1";
inline constexpr char kTrajectory[] = "trajectory.tum";
inline constexpr char kPoseCovariance[] = "pose_covariance.csv";
inline constexpr char kTrajectorySmoothed[] = "trajectory_smoothed.tum";
inline constexpr char kTrajectoryLastScale[] = "trajectory_last_scale.tum";
inline constexpr char kPoseCovarianceSmoothed[] = "pose_covariance_smoothed.csv";
inline constexpr char kLandmarks[] = "landmarks.csv";
inline constexpr char kPredictions[] = "predictions.csv";
inline constexpr char kClassification[] = "classification.csv";
inline constexpr char kTiming[] = "timing.csv";
inline constexpr char kMetrics[] = "metrics.json";

}  // namespace slammot::run_files
