#include "bench/peers/gtsam_window.h"

#include <gtsam/inference/Symbol.h>

#include <algorithm>
#include <cmath>

namespace slammot::bench {
namespace {

Key camera_key(int frame) { return gtsam::Symbol('x', static_cast<std::uint64_t>(frame)); }

// GTSAM's own rule: it ends when a step has lowered chi-square by less. Its error is half of that.
constexpr double kDecrease = 1e-2;

gtsam::LevenbergMarquardtParams parameters(const WindowOptions& options) {
  gtsam::LevenbergMarquardtParams parameters;
  parameters.setRelativeErrorTol(0.0);
  parameters.setAbsoluteErrorTol(0.5 * kDecrease);
  parameters.setMaxIterations(options.iterations);
  return parameters;
}

}  // namespace

// It optimises first and marginalises then, so that a lag of k has k + 2 cameras in it.
GtsamWindow::GtsamWindow(const Setup& setup, const WindowOptions& options)
    : setup_(setup),
      smoother_(options.frames - 2, parameters(options)),
      camera_(setup.initial.state) {}

void GtsamWindow::process(const Frame& frame) {
  News news;
  add_camera(frame.timestamp, news);
  for (const Observation& z : frame.observations) add_point(z, news);
  iterations_ += smoother_.update(news.factors, news.values, news.times).iterations;
  camera_ = smoother_.calculateEstimate<CameraState>(camera_key(frames_));
  timestamp_ = frame.timestamp;
  ++frames_;
}

void GtsamWindow::add_camera(double timestamp, News& news) {
  const Key key = camera_key(frames_);
  if (frames_ == 0) {
    news.factors.emplace_shared<InitialFactor>(key, setup_.initial);
  } else {
    const double dt = timestamp - timestamp_;
    const Matrix12d weight =
        square_root_information(camera_noise(setup_.camera_noise, camera_, dt));
    news.factors.emplace_shared<MotionFactor>(camera_key(frames_ - 1), key, weight, dt);
    camera_ = predict(camera_, dt);
  }
  news.values.insert(key, camera_);
  news.times[key] = frames_;
}

// A point that has been marginalised begins anew.
void GtsamWindow::add_point(const Observation& z, News& news) {
  auto found = points_.find(z.track);
  if (found != points_.end() && found->second.last_frame < frames_ - 1 - smoother_.smootherLag()) {
    points_.erase(found);
    found = points_.end();
  }
  if (found == points_.end()) found = points_.emplace(z.track, begin_point(z, news)).first;
  Point& point = found->second;
  point.last_frame = frames_;
  news.times[point.key] = frames_;
  const double sigma = std::sqrt(z.variance(setup_.pixel_sigma));
  news.factors.emplace_shared<PixelFactor>(camera_key(frames_), point.key,
                                           gtsam::noiseModel::Isotropic::Sigma(2, sigma),
                                           setup_.camera, z.pixel);
}

GtsamWindow::Point GtsamWindow::begin_point(const Observation& z, News& news) {
  const Key key = gtsam::Symbol('l', points_begun_++);
  const auto known = std::ranges::find(setup_.known, z.track, &KnownLandmark::track);
  if (known != setup_.known.end()) {
    news.values.insert(key, known->position);
    news.factors.addPrior(key, known->position,
                          gtsam::noiseModel::Isotropic::Sigma(3, known->sigma));
    setup_.known.erase(known);  // as ours: what was forgotten is not known any more
  } else {
    const Eigen::Vector3d ray = setup_.camera.unproject(z.pixel).value().ray.normalized();
    const double distance = 1.0 / setup_.prior.inverse_depth;
    news.values.insert(key,
                       Eigen::Vector3d(camera_.position + camera_.orientation * (distance * ray)));
    news.factors.emplace_shared<DepthFactor>(camera_key(frames_), key, setup_.prior);
  }
  return {key, frames_};
}

}  // namespace slammot::bench
