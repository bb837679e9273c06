// Laws of the readers over random sequences: what is written is read back, bit for bit.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>

#include "datasets/native/native_reader.h"
#include "datasets/native/native_writer.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

// Any double within these bounds, short or long in its digits.
double within(double lowest, double highest) {
  const auto part = *rc::gen::inRange<std::uint64_t>(0, std::uint64_t{1} << 53);
  return lowest + (highest - lowest) * std::ldexp(static_cast<double>(part), -53);
}

Eigen::Vector3d vector_within(double size) {
  return {within(-size, size), within(-size, size), within(-size, size)};
}

std::string any_name(bool may_have_slash) {
  auto name = *rc::gen::nonEmpty(rc::gen::container<std::string>(rc::gen::element(
      'a', 'Z', '0', ' ', ',', '"', '\\', '\'', '#', ':', '-', '{', '&', '*', '/')));
  if (!may_have_slash) std::erase(name, '/');
  return "n" + name + "\xc3\xa9";
}

CameraState any_camera() {
  CameraState x;
  x.position = vector_within(1e9);
  x.orientation = exp_so3(vector_within(3.0));
  x.velocity = vector_within(100.0);
  x.angular_velocity = vector_within(10.0);
  return x;
}

Sequence any_sequence() {
  Sequence s;
  s.name = any_name(false);
  s.camera = {640,
              480,
              within(100.0, 1000.0),
              within(100.0, 1000.0),
              within(-600.0, 1200.0),
              within(-400.0, 900.0),
              RadtanLens{}};
  s.pixel_sigma = within(1e-3, 10.0);
  if (*rc::gen::arbitrary<bool>()) {
    s.points = *rc::gen::inRange(1, 1000);
    s.motion = StatedMotion{within(0.1, 10.0), within(0.1, 10.0)};
    s.prior = LandmarkPrior{within(-1.0, 1.0), within(0.01, 1.0), within(0.01, 1.0)};
  }
  const bool images = *rc::gen::arbitrary<bool>(), truth = *rc::gen::arbitrary<bool>();
  const bool is_uneven = *rc::gen::arbitrary<bool>();
  if (*rc::gen::arbitrary<bool>()) {
    s.other_cameras = {{s.camera, Eigen::Quaterniond::Identity(), {0.5, 0.0, 0.0}}};
    s.other_images.resize(1);
  }
  double time = within(-1e9, 1e9);
  const int frames = *rc::gen::inRange(1, 6);
  for (int i = 0; i < frames; ++i, time += within(0.001, 1.0)) {
    Frame frame{i, time, {}, {}};
    const int tracks = *rc::gen::inRange(0, 5);
    for (int track = 0; track < tracks; ++track) {
      const double u = track == 0 ? -1e-300 : within(-640.0, 1280.0);
      frame.observations.push_back({7 * track, {u, within(-480.0, 960.0)}});
      if (is_uneven) frame.observations.back().relative_sigma = within(0.1, 10.0);
    }
    s.frames.push_back(frame);
    if (images) s.images.push_back(any_name(true));
    for (auto& names : s.other_images) {
      names.push_back(*rc::gen::arbitrary<bool>() ? any_name(true) : "");
    }
    if (!truth) continue;
    s.truth.emplace_back(any_camera());
    s.truth.back()->position.z() = std::numeric_limits<double>::denorm_min();
  }
  if (*rc::gen::arbitrary<bool>()) {
    s.landmarks[3] = {Label::kStatic, {{0, {vector_within(1e9), vector_within(10.0)}}}};
    s.known.push_back({3, vector_within(1e9), within(1e-6, 1.0)});
  }
  if (*rc::gen::arbitrary<bool>()) s.p_static = {{3, within(0.0, 1.0)}, {7, 1.0}};
  if (*rc::gen::arbitrary<bool>()) s.initial = InitialCamera{any_camera(), 1e-6, 1e-6, 0.1, 0.1};
  return s;
}

RC_GTEST_PROP(ReaderLaws, WhatIsWrittenIsReadBack, ()) {
  const Sequence a = any_sequence();
  const test::TemporaryFolder folder;
  write_native(a, folder.path());
  const Sequence b = read_native(folder.path());
  RC_ASSERT(a.name == b.name);
  RC_ASSERT(a.images == b.images);
  RC_ASSERT(a.other_images == b.other_images);
  RC_ASSERT(a.camera.fx == b.camera.fx);
  RC_ASSERT(a.camera.cy == b.camera.cy);
  RC_ASSERT(a.frames.size() == b.frames.size());
  for (size_t i = 0; i < a.frames.size(); ++i) {
    RC_ASSERT(a.frames[i].timestamp == b.frames[i].timestamp);
    RC_ASSERT(a.frames[i].observations.size() == b.frames[i].observations.size());
    for (size_t k = 0; k < a.frames[i].observations.size(); ++k) {
      const Observation &y = a.frames[i].observations[k], &z = b.frames[i].observations[k];
      RC_ASSERT(y.track == z.track && y.pixel == z.pixel && y.relative_sigma == z.relative_sigma);
    }
    if (a.truth.empty()) continue;
    RC_ASSERT(a.truth[i]->position == b.truth[i]->position);
    RC_ASSERT(a.truth[i]->orientation.coeffs() == b.truth[i]->orientation.coeffs());
  }
  RC_ASSERT(a.points == b.points && a.prior.has_value() == b.prior.has_value());
  if (a.prior) RC_ASSERT(a.prior->mean_sigma == b.prior->mean_sigma);
  RC_ASSERT(a.landmarks.size() == b.landmarks.size());
  RC_ASSERT(a.known.size() == b.known.size());
  RC_ASSERT(a.p_static == b.p_static);
  if (!a.known.empty()) {
    RC_ASSERT(a.known[0].position == b.known[0].position);
    RC_ASSERT(a.landmarks.at(3).at(0)->velocity == b.landmarks.at(3).at(0)->velocity);
  }
  RC_ASSERT(a.initial.has_value() == b.initial.has_value());
  if (a.initial) {
    RC_ASSERT(a.initial->state.velocity == b.initial->state.velocity);
    RC_ASSERT(a.initial->state.orientation.coeffs() == b.initial->state.orientation.coeffs());
  }
  // And what is read is written the same again.
  const test::TemporaryFolder again;
  write_native(b, again.path());
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    RC_ASSERT(test::read_text(entry.path()) ==
              test::read_text(again.path() / entry.path().filename()));
  }
}

}  // namespace
}  // namespace slammot
