// Calibration: time-averaged ANEES of the pose on `model_matched` with true labels, where theory
// says 6.
//
//   slammot_calibration --estimator batch --runs 50
#include <tbb/parallel_for.h>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/metrics/nees.h"
#include "eval/run/process.h"
#include "eval/run/run.h"

namespace {

struct Outcome {
  bool diverged = false;
  double filtered = 0.0;  // mean NEES over the run's frames
  double smoothed = 0.0;
};

double mean_nees(const slammot::Sequence& sequence,
                 const std::vector<slammot::CameraEstimate>& cameras) {
  const auto consistency = slammot::pose_consistency(slammot::pair_with_truth(sequence, cameras));
  return consistency.pose.mean;
}

}  // namespace

int main(int argc, char** argv) {
  slammot::prepare_process();
  std::string name = "ekf";
  int runs = 50;
  std::vector<std::string> settings, scene;
  CLI::App app("slammot calibration: ANEES of the pose on `model_matched`, labels given");
  app.add_option("--estimator", name, "a row of the registry");
  app.add_option("--runs", runs, "seeds 1 to this");
  app.add_option("--set", settings, "configuration keys");
  app.add_option("--scenario", scene, "parameters of `matched`, KEY=VALUE");
  CLI11_PARSE(app, argc, argv);

  // `matched` draws velocities in metres, as this landmark model believes.
  slammot::Configuration configuration;
  slammot::assign(configuration, {"landmark", "dynamic_inverse_depth"});
  slammot::assign(configuration, {"classifier", "truth"});
  slammot::assign(configuration, {"labels", "one_way"});
  slammot::assign(configuration, {"prior.source", "fixed"});
  for (const std::string& text : settings) {
    slammot::assign(configuration, slammot::parse_assignment(text));
  }
  std::map<std::string, std::string> parameters;
  for (const std::string& text : scene) {
    const slammot::Assignment a = slammot::parse_assignment(text);
    parameters[a.key] = a.value;
  }
  std::vector<Outcome> outcomes(static_cast<std::size_t>(runs));
  tbb::parallel_for(0, runs, [&](int i) {
    const slammot::Sequence sequence =
        slammot::simulate("model_matched", parameters, static_cast<unsigned>(i + 1));
    const slammot::RunResult run = slammot::run_estimator(sequence, configuration, name);
    Outcome& outcome = outcomes[static_cast<std::size_t>(i)];
    outcome.diverged = run.diverged.has_value();
    outcome.filtered = mean_nees(sequence, run.filtered);
    if (run.diverged) outcome.filtered = outcome.smoothed = INFINITY;
    if (!run.smoothed.empty()) outcome.smoothed = mean_nees(sequence, run.smoothed);
    std::fprintf(stderr, "seed %d done: %.3f %.3f\n", i + 1, outcome.filtered, outcome.smoothed);
  });
  double filtered = 0.0, smoothed = 0.0;
  int diverged = 0;
  for (int i = 0; i < runs; ++i) {
    const Outcome& o = outcomes[static_cast<std::size_t>(i)];
    std::printf("seed %2d  filtered %8.3f  smoothed %8.3f%s\n", i + 1, o.filtered, o.smoothed,
                o.diverged ? "  diverged" : "");
    filtered += o.filtered / runs;
    smoothed += o.smoothed / runs;
    diverged += o.diverged;
  }
  std::printf("%s, %d runs, %d diverged: ANEES of the pose (6): filtered %.3f, smoothed %.3f\n",
              name.c_str(), runs, diverged, filtered, smoothed);
  return diverged > 0;
}
