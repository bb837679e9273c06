// Soak: laps of `circle` without end through one estimator, watching memory and time per frame.
//
// The same points come back every lap, so that a map that is kept stops growing after the first;
// what grows after that is a leak. Prints, for each tenth of the run, the resident memory and the
// time per frame; ends with the ratios of the last tenth to the second. Exit 1 when memory grew by
// more than 10% or time by more than 50%.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/run/process.h"

namespace {

// Resident set [MB], from /proc.
double resident_memory() {
  std::ifstream status("/proc/self/statm");
  long total = 0, resident = 0;
  status >> total >> resident;
  return static_cast<double>(resident) * 4096.0 / 1e6;
}

}  // namespace

int main(int argc, char** argv) {
  slammot::prepare_process();
  std::string name = "ekf";
  int frames = 100000;
  CLI::App app("slammot soak: constant memory and time over many frames");
  app.add_option("--estimator", name, "a row of the registry");
  app.add_option("--frames", frames, "how many frames");
  CLI11_PARSE(app, argc, argv);

  const slammot::Sequence lap = slammot::simulate("circle", {}, 1);
  constexpr int kLap = 450;  // frames until the camera is where it began
  slammot::Configuration configuration;
  const slammot::EstimatorRow& row = slammot::find_estimator(name);
  row.adjust(configuration);
  const auto estimator = row.make(slammot::make_setup(lap, configuration), configuration);
  slammot::NoStages stages;
  const double dt = lap.frames[1].timestamp - lap.frames[0].timestamp;
  double memory[10] = {}, time[10] = {};
  for (int i = 0; i < frames; ++i) {
    // Moving points are new every lap; static ones keep their track.
    slammot::Frame frame = lap.frames[static_cast<std::size_t>(i % kLap)];
    frame.index = i;
    frame.timestamp = i * dt;
    for (slammot::Observation& z : frame.observations) {
      const auto truth = lap.landmarks.find(z.track);
      const bool moving =
          truth != lap.landmarks.end() && truth->second.label == slammot::Label::kMoving;
      if (moving) z.track += 10000 * (1 + i / kLap % 100000);
    }
    const auto begin = std::chrono::steady_clock::now();
    estimator->process(frame, stages);
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - begin;
    const int tenth = static_cast<int>(10LL * i / frames);
    time[tenth] += elapsed.count() / (frames / 10);
    memory[tenth] = resident_memory();
    if ((i + 1) % (frames / 10) == 0) {
      std::printf("frame %7d  %8.1f MB  %8.3f ms a frame\n", i + 1, memory[tenth], time[tenth]);
      std::fflush(stdout);
    }
  }
  const double memory_ratio = memory[9] / memory[1], time_ratio = time[9] / time[1];
  std::printf("last tenth to second: memory %.3f, time %.3f\n", memory_ratio, time_ratio);
  return memory_ratio > 1.1 || time_ratio > 1.5 ? 1 : 0;
}
