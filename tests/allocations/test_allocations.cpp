// A filter or window that has warmed up asks for no memory: its matrices and lists keep what they
// had. Only a birth does, for the landmark itself.
//
// Counts what reaches malloc and its relatives, from Eigen and the standard library alike; so this
// is a program of its own, and without a test under a sanitizer, which has its own malloc. What
// OpenBLAS asks for does not count: its kernels for AVX-512 take memory for each small product.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <string_view>

#include "eval/run/process.h"
#include "filters/ekf.h"
#include "models/points/observation.h"
#include "smoothers/window/window.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

thread_local bool is_counting = false;
thread_local long allocations = 0;

void count_for(const void* caller) {
  if (!is_counting) return;
  Dl_info info{};
  const bool is_known = dladdr(caller, &info) != 0 && info.dli_fname != nullptr;
  const std::string_view path = is_known ? info.dli_fname : "";
  if (!path.substr(path.rfind('/') + 1).starts_with("libopenblas")) ++allocations;
}

}  // namespace

extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* __libc_calloc(std::size_t count, std::size_t size);
extern "C" void* __libc_realloc(void* memory, std::size_t size);
extern "C" void* __libc_memalign(std::size_t alignment, std::size_t size);

extern "C" void* malloc(std::size_t size) {
  count_for(__builtin_return_address(0));
  return __libc_malloc(size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
  count_for(__builtin_return_address(0));
  return __libc_calloc(count, size);
}
extern "C" void* realloc(void* memory, std::size_t size) {
  count_for(__builtin_return_address(0));
  return __libc_realloc(memory, size);
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count_for(__builtin_return_address(0));
  return __libc_memalign(alignment, size);
}
extern "C" int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  count_for(__builtin_return_address(0));
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}

namespace slammot {
namespace {

Setup wall_setup() {
  Setup setup;
  setup.camera.fx = setup.camera.fy = 400.0;
  setup.camera.cx = 319.5;
  setup.camera.cy = 239.5;
  setup.camera_noise = {0.3, 0.1, NoiseDiscretisation::kWhiteNoise};
  setup.prior = {0.2, 0.05, 0.0, 2.0, 0.1};
  setup.initial.velocity_sigma = 0.5;
  setup.initial.angular_velocity_sigma = 0.1;
  for (int track = 0; track < 40; ++track) {
    setup.true_labels[track] = track % 4 == 0 ? Label::kMoving : Label::kStatic;
  }
  return setup;
}

// A camera that swings to and fro before a wall of 40 points, of which every fourth moves.
Frame wall_frame(const Setup& setup, int index) {
  const double t = index / 15.0;
  const Eigen::Vector3d r(0.5 * std::sin(t), 0.2 * std::sin(0.7 * t), 0.0);
  Frame frame{index, t, {}, {}};
  for (int track = 0; track < 40; ++track) {
    Eigen::Vector3d point(0.5 * (track % 8) - 1.75, 0.6 * (track / 8) - 1.2, 4.0 + track % 3);
    if (track % 4 == 0) point.x() = 0.05 * track - 2.0 + 0.4 * t;
    const auto seen = setup.camera.project(point - r);
    frame.observations.push_back({track, seen->pixel});
  }
  return frame;
}

// While the motion of what became static is remembered, a window that asks for it allocates.
constexpr int kWarm = LabelOptions{}.memory + 5, kFrames = kWarm + 20;

// Of warm frames in which nothing is born, pruned or larger than ever before.
void expect_no_allocation(Estimator& estimator, const Setup& setup) {
  NoStages stages;
  long first = 0, warm = 0, counted = 0;
  int size = 0, largest = 0;  // of the state: before the frame, and in all frames before it
  for (int index = 0; index < kFrames; ++index) {
    const Frame frame = wall_frame(setup, index);
    allocations = 0;
    is_counting = true;
    const FrameReport report = estimator.process(frame, stages);
    is_counting = false;
    const long here = allocations;
    const bool grown = size > largest;
    largest = std::max(largest, size);
    size = report.state_size;
    if (index == 0) first = here;
    if (index < kWarm || grown || report.admitted > 0 || !report.retired.empty()) continue;
    ASSERT_GE(report.accepted, 30) << "frame " << index;
    ASSERT_GT(report.accepted, report.accepted_static) << "frame " << index;
    warm += here;
    ++counted;
  }
  EXPECT_GT(first, 40) << "the counter does not count";
  EXPECT_GT(counted, 10);
  EXPECT_EQ(warm, 0);
}

// With labels that are given and stay, and with those that are found and may be taken back.
class Allocations : public testing::TestWithParam<bool> {
 protected:
  Allocations() {
    prepare_process();  // more BLAS threads would have buffers of their own
    if (!GetParam()) return;
    models.labels.births = Births::kStaticFirst;
    models.labels.rule = LabelRule::kOneWay;
    models.classifier.name = "truth";
  }

  slammot::Setup setup = wall_setup();
  ModelOptions models;
};
INSTANTIATE_TEST_SUITE_P(Labels, Allocations, testing::Bool(), [](const auto& tested) {
  return std::string(tested.param ? "given" : "estimated");
});

TEST_P(Allocations, NoneByAWarmFilter) {
  expect_no_allocation(*make_ekf(setup, models, {}), setup);
}

TEST_P(Allocations, NoneByAWarmFilterInMetres) {
  models.landmark = "dynamic_inverse_depth";
  expect_no_allocation(*make_ekf(setup, models, {}), setup);
}

TEST_P(Allocations, NoneByAWarmWindow) {
  WindowOptions options;
  options.frames = 10;
  expect_no_allocation(*make_window(setup, models, options), setup);
}

}  // namespace
}  // namespace slammot

#endif
