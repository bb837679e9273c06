// A fingerprint of what the estimators compute, to be taken before and after a change that should
// change nothing: for each of twelve configurations a hash of every estimate and covariance, bit by
// bit, one of all labels, and the counts of all frames. The same on one machine and compiler only.
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/run/process.h"

namespace {

using slammot::LandmarkEstimate;

// FNV-1a.
class Hash {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 1099511628211ULL;
  }
  void add(int number) { add(&number, sizeof number); }
  template <typename Derived>
  void add(const Eigen::PlainObjectBase<Derived>& m) {
    add(m.data(), sizeof(double) * static_cast<std::size_t>(m.size()));
  }
  unsigned long long value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ULL;
};

struct Fingerprint {
  Hash numbers, labels;
  long accepted = 0, rejected = 0, out_of_view = 0, admitted = 0, retired = 0, negative = 0,
       state_size = 0;

  void add(const slammot::CameraEstimate& camera) {
    numbers.add(camera.state.position);
    numbers.add(camera.state.orientation.coeffs());
    numbers.add(camera.state.velocity);
    numbers.add(camera.state.angular_velocity);
    numbers.add(camera.covariance);
  }
  void add(const LandmarkEstimate& l) {
    labels.add(l.track);
    labels.add(static_cast<int>(l.label));
    labels.add(l.decision_frame.value_or(-1));
    labels.add(l.observations);
    if (l.position.allFinite()) {  // a NaN has many bit patterns
      numbers.add(l.position);
      numbers.add(l.position_covariance);
    }
    if (!l.velocity.allFinite()) return;
    numbers.add(l.velocity);
    numbers.add(l.velocity_covariance);
  }
  void add(const slammot::FrameReport& report) {
    accepted += report.accepted;
    rejected += report.rejected;
    out_of_view += report.out_of_view;
    admitted += report.admitted;
    retired += static_cast<long>(report.retired.size());
    negative += report.negative_inverse_depth;
    state_size += report.state_size;
    numbers.add(&report.nis_sum, sizeof report.nis_sum);
    for (const LandmarkEstimate& l : report.retired) add(l);
  }
};

struct Case {
  const char* scenario;
  const char* estimator;
  std::vector<const char*> settings;
};

const std::vector<Case> kCases = {
    {"circle", "ekf", {}},
    {"circle", "ekf", {"landmark=dynamic_inverse_depth", "collapse=drop", "labels=one_way"}},
    {"circle", "ekf", {"ekf.linearisation=fej", "prior.source=fixed"}},
    {"circle", "ekf", {"gauge=none", "policy.movers=joint", "classifier=odds"}},
    {"circle", "ekf", {"ekf.iterations=3"}},
    {"move_stop_move", "ekf", {"prior.inverse_depth_sigma=0.3", "prior.mean_sigma=0.02"}},
    {"circle", "delayed", {}},
    {"circle", "window", {"window.frames=10"}},
    {"circle", "window", {"window.frames=5", "landmark=dynamic_inverse_depth", "collapse=drop"}},
    {"circle", "window", {"window.frames=5", "window.linearisation=fej"}},
    {"move_stop_move", "window", {"window.frames=8"}},
    {"circle", "batch", {"window.frames=5", "frames.last=60"}},
};

Fingerprint run(const Case& c) {
  slammot::Configuration configuration;
  for (const char* s : c.settings) slammot::assign(configuration, slammot::parse_assignment(s));
  const slammot::EstimatorRow& row = slammot::find_estimator(c.estimator);
  row.adjust(configuration);
  const slammot::Sequence sequence =
      slammot::simulate(c.scenario, {{"frames", "150"}, {"first_moving", "3"}}, 3);
  const auto estimator = row.make(slammot::make_setup(sequence, configuration), configuration);
  slammot::NoStages stages;
  Fingerprint print;
  for (const slammot::Frame& frame : sequence.frames) {
    if (configuration.frames.last >= 0 && frame.index > configuration.frames.last) break;
    print.add(estimator->process(frame, stages));
    print.add(estimator->camera());
    if (frame.index % 10 > 0) continue;
    for (const LandmarkEstimate& l : estimator->landmarks()) print.add(l);
  }
  for (const slammot::CameraEstimate& camera : estimator->smoothed(stages)) {
    if (camera.covariance.allFinite()) print.add(camera);
  }
  for (const LandmarkEstimate& l : estimator->landmarks()) print.add(l);
  return print;
}

}  // namespace

int main() {
  slammot::prepare_process();
  std::printf(
      "numbers          labels           accepted rejected unseen born  died  rho<0 size\n");
  for (const Case& c : kCases) {
    const Fingerprint p = run(c);
    std::printf("%016llx %016llx %8ld %8ld %6ld %5ld %5ld %5ld %7ld  %s %s", p.numbers.value(),
                p.labels.value(), p.accepted, p.rejected, p.out_of_view, p.admitted, p.retired,
                p.negative, p.state_size, c.scenario, c.estimator);
    for (const char* s : c.settings) std::printf(" %s", s);
    std::printf("\n");
    std::fflush(stdout);
  }
}
