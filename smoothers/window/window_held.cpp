// A label that can be undone: the window still holds the pixels of a static landmark, and so what
// they say of its motion.
//
// A landmark that moves with w since the frame of its oldest pixel in the window is seen at
// y + F_yw(t) w in the others, F_yw of its model's prediction at rest. With A the Jacobian of all
// its pixels with respect to w, P and B = P J of given_others.h and r the residuals at the optimum,
//
//   J_w = A' P A - (B'A)' Sigma (B'A) + diag(sigmas)^-2,   w = -J_w^-1 A' r,
//
// that is, its marginal were w one variable more, by one Gauss-Newton step. What has left the
// window was used with the landmark at rest and stays so; the EKF keeps it (held_motion.cpp).
#include <Eigen/Cholesky>

#include "smoothers/window/window_belief.h"

namespace slammot {

bool Window::is_remembered(const WindowLandmark& landmark) const {
  return memory_ > 0 && !landmark.is_free && landmark.rests_since &&
         cameras_.newest().number - *landmark.rests_since <= memory_ &&
         !is_inactive(graph_[landmark.id].y);
}

void Window::motion_rows(const WindowLandmark& landmark, GrowingMatrix& A) const {
  const GraphLandmark& l = graph_[landmark.id];
  const int motion = functions_.motion;
  const LandmarkVector at = at_rest(landmark);
  const double begin = cameras_.find(l.pixels.front().position)->timestamp;
  A.resize(2 * std::ssize(l.pixels), motion);
  for (Eigen::Index i = 0; i < std::ssize(l.pixels); ++i) {
    const GraphPixel& pixel = l.pixels[static_cast<std::size_t>(i)];
    const double dt = cameras_.find(pixel.position)->timestamp - begin;
    const LandmarkMatrix F = functions_.predict_jacobian(at, dt);
    (*A).middleRows<2>(2 * i).noalias() = pixel.at.J_y * F.topRightCorner(3, motion);
  }
}

void Window::held_motions(std::span<const int> tracks, const TrackRecords& records,
                          std::vector<MotionBelief>& result) {
  result.clear();
  const NormalEquations& equations = optimiser_.equations();
  const Eigen::Index n = functions_.motion;
  motion_columns_.resize(equations.core_dim(), n * std::ssize(tracks));
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const GraphLandmark& l = graph_[landmark.id];
    if (!is_remembered(landmark) || l.pixels.size() < 2) continue;
    motion_rows(landmark, motion_rows_);
    Eigen::VectorXd r((*motion_rows_).rows());
    for (Eigen::Index i = 0; i < std::ssize(l.pixels); ++i) {
      r.segment<2>(2 * i) = l.pixels[static_cast<std::size_t>(i)].at.r;
    }
    MotionMatrix own;
    auto columns = (*motion_columns_).middleCols(n * std::ssize(result), n);
    equations.block(landmark.id).weigh(*motion_rows_, columns, own);
    MotionBelief& motion = result.emplace_back();
    motion.track = track;
    motion.covariance = own;  // an information, so far
    motion.w = -(*motion_rows_).transpose() * r;
  }
  auto columns = (*motion_columns_).leftCols(n * std::ssize(result));
  if (!result.empty()) equations.whiten(columns);
  std::size_t determined = 0;
  for (Eigen::Index i = 0; i < std::ssize(result); ++i) {
    MotionBelief& motion = result[static_cast<std::size_t>(i)];
    const MotionVector sigmas = functions_.prior_sigmas(records.at(motion.track).prior);
    const auto of_core = columns.middleCols(n * i, n);
    MotionMatrix J = motion.covariance - of_core.transpose() * of_core;
    J.diagonal() += sigmas.cwiseAbs2().cwiseInverse();
    const Eigen::LLT<MotionMatrix> llt(J);
    if (llt.info() != Eigen::Success) continue;
    motion.covariance = llt.solve(MotionMatrix::Identity(n, n));
    motion.w = llt.solve(motion.w).eval();
    LandmarkVector x = at_rest(landmarks_.at(motion.track));
    x.tail(n) = motion.w;
    motion.density_scale = functions_.density_scale(x);
    result[determined++] = motion;
  }
  result.resize(determined);
}

// It is free with its pixels of the window, and the window is solved once more. What was refused of
// it before it could move is not of that point.
void Window::release(int track, const LandmarkPrior& prior) {
  WindowLandmark& landmark = landmarks_.at(track);
  const WindowFrame& base = *cameras_.find(graph_[landmark.id].pixels.front().position);
  if (histories_) histories_->rested_until(track, base.number, at_rest(landmark));
  landmark.is_free = true;
  landmark.rests_since.reset();
  graph_.free_landmark(landmark.id, functions_.prior_sigmas(prior));
  move_since(landmark, base);
  std::erase_if(refused_, [&](const RefusedPixel& z) {
    return z.track == track && cameras_.find(z.position)->number < base.number;
  });
  truth_.apply(landmark);
  graph_.prior().relinearise();
  optimiser_.take_step(graph_, cameras_.newest().camera);
  estimate_camera();
}

// Its chain begins in this frame, and its pixels are measured along it.
void Window::move_since(WindowLandmark& landmark, const WindowFrame& base) {
  landmark.base = base.camera.position;
  double time = base.timestamp;
  for (const WindowFrame& frame : cameras_.frames()) {
    if (frame.number <= base.number) continue;
    extend(landmark, Label::kUnknown, frame.timestamp - time);
    time = frame.timestamp;
  }
  GraphLandmark& l = graph_[landmark.id];
  for (GraphPixel& pixel : l.pixels) {
    pixel.depth = cameras_.find(pixel.position)->number - base.number;
  }
  graph_.linearise(l);
}

}  // namespace slammot
