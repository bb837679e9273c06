// Our window beside GTSAM's BatchFixedLagSmoother: the same measurements, motion prior and depth
// prior, all landmarks static and known to be so, no gate, one thread. The two take turns of a few
// frames, so that what else the machine does slows both alike.
//
//   slammot_bench_gtsam SEQUENCE --window 10 20
#include <time.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "bench/peers/gtsam_window.h"
#include "datasets/readers/reader.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/run/process.h"

namespace slammot::bench {
namespace {

constexpr std::size_t kTurn = 25;  // frames

// Of this process [ms].
double cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

Configuration static_world(int window, const std::vector<std::string>& settings) {
  Configuration configuration;
  configuration.model.classifier.name = "all_static";
  configuration.model.labels.rule = LabelRule::kOneWay;
  configuration.model.labels.births = Births::kStaticFirst;
  configuration.model.depth_prior = DepthPriorSource::kFixed;
  configuration.model.gate = {1.0 - 1e-9, 1.0};
  configuration.model.adaptive_motion = false;
  configuration.model.policy.max_visible = 100000;
  configuration.model.policy.max_landmarks = 100000;
  configuration.window.frames = window;
  for (const std::string& text : settings) assign(configuration, parse_assignment(text));
  return configuration;
}

// One of the two, and what became of it.
struct Contender {
  std::string name;
  std::function<CameraState(const Frame&)> process;
  std::vector<CameraState> cameras = {};
  double milliseconds = 0.0;

  void take(const Frame& frame) {
    const double begin = cpu_time();
    cameras.push_back(process(frame));
    milliseconds += cpu_time() - begin;
  }
};

// Root mean square of |difference(i)| over the frames with a true camera.
template <typename Difference>
double rms(const Sequence& sequence, Difference&& difference) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < sequence.truth.size(); ++i) {
    if (!sequence.truth[i]) continue;
    sum += Eigen::Vector3d(difference(i)).squaredNorm();
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

void report(const Sequence& sequence, const Contender& c) {
  const double position = rms(sequence, [&](std::size_t i) -> Eigen::Vector3d {
    return c.cameras[i].position - sequence.truth[i]->position;
  });
  const double rotation = rms(sequence, [&](std::size_t i) {
    return log_so3(sequence.truth[i]->orientation.conjugate() * c.cameras[i].orientation);
  });
  std::printf("  %-8s %8.3f ms CPU a frame, RMSE %.4f m, %.4f deg\n", c.name.c_str(),
              c.milliseconds / static_cast<double>(c.cameras.size()), position,
              rotation * 180.0 / 3.14159265358979);
}

void compare(const Sequence& sequence, const Configuration& configuration) {
  const Setup setup = make_setup(sequence, configuration);
  const auto ours = find_estimator("window").make(setup, configuration);
  GtsamWindow theirs(setup, configuration.window);
  NoStages stages;
  long refused = 0, offered = 0;
  Contender slammot{"slammot", [&](const Frame& frame) {
                      const FrameReport done = ours->process(frame, stages);
                      refused += done.rejected + done.out_of_view;
                      return ours->camera().state;
                    }};
  Contender gtsam{"GTSAM", [&](const Frame& frame) {
                    theirs.process(frame);
                    return theirs.camera();
                  }};
  const std::vector<Frame>& frames = sequence.frames;
  for (std::size_t begin = 0; begin < frames.size(); begin += kTurn) {
    const std::size_t end = std::min(begin + kTurn, frames.size());
    for (std::size_t i = begin; i < end; ++i) slammot.take(frames[i]);
    for (std::size_t i = begin; i < end; ++i) gtsam.take(frames[i]);
  }
  for (const Frame& frame : frames) offered += std::ssize(frame.observations);
  std::printf(
      "window %d: %zu frames, %.1f measurements a frame, of which ours refused %ld in all\n",
      configuration.window.frames, frames.size(),
      static_cast<double>(offered) / static_cast<double>(frames.size()), refused);
  report(sequence, slammot);
  report(sequence, gtsam);
  const double apart = rms(sequence, [&](std::size_t i) -> Eigen::Vector3d {
    return slammot.cameras[i].position - gtsam.cameras[i].position;
  });
  std::printf("  GTSAM / slammot %.2f; apart by %.4f m (RMS); GTSAM's iterations a frame %.1f\n",
              gtsam.milliseconds / slammot.milliseconds, apart, theirs.iterations());
}

}  // namespace
}  // namespace slammot::bench

int main(int argc, char** argv) {
  slammot::choose_blas_kernels(argv);
  slammot::prepare_process();
  std::string folder;
  std::vector<int> windows = {10, 20};
  std::vector<std::string> settings;
  CLI::App app("slammot_bench_gtsam: our window beside GTSAM's fixed-lag smoother");
  app.add_option("SEQUENCE", folder, "of a static world")->required();
  app.add_option("--window", windows, "cameras in it")->check(CLI::Range(2, 1000));
  app.add_option("--set", settings, "configuration keys of ours");
  CLI11_PARSE(app, argc, argv);
  const slammot::Sequence sequence = slammot::read_sequence(folder);
  for (const int window : windows) {
    slammot::bench::compare(sequence, slammot::bench::static_world(window, settings));
  }
}
