// Frames of measurements whose predictions share a camera's error, drawn as they are stated.
#pragma once

#include <Eigen/Cholesky>
#include <random>

#include "estimation/gate.h"

namespace slammot::test {

// n pixels whose predictions share a camera's error of `common` [px] and have `own` each.
class World {
 public:
  World(std::size_t n, double common, double own, unsigned seed) : engine_(seed) {
    const auto size = static_cast<Eigen::Index>(2 * n);
    S_ = own * own * Eigen::MatrixXd::Identity(size, size);
    for (Eigen::Index i = 0; i < size; ++i) {
      for (Eigen::Index j = i % 2; j < size; j += 2) S_(i, j) += common * common;
    }
    frame.HPHt.resize(size, size);
    *frame.HPHt = S_;
    S_.diagonal().array() += 1.0;  // the pixels' noise
    L_ = S_.llt().matrixL();
    draw();
  }

  void draw() {
    std::normal_distribution<double> normal;
    Eigen::VectorXd unit(S_.rows());
    for (double& x : unit) x = normal(engine_);
    nu_ = L_ * unit;
    frame.z.clear();
    frame.nu.clear();
    for (Eigen::Index i = 0; i < S_.rows(); i += 2) {
      frame.z.push_back({static_cast<int>(i / 2), Eigen::Vector2d::Zero()});
      frame.nu.emplace_back(nu_.segment<2>(i));
    }
  }

  const Eigen::MatrixXd& S() const { return S_; }
  Eigen::VectorXd nu() const { return nu_; }

  FrameInnovation frame;

 private:
  std::mt19937 engine_;
  Eigen::MatrixXd S_, L_;
  Eigen::VectorXd nu_;
};

inline FrameGate judged(const FrameInnovation& frame, const GateOptions& options) {
  FrameGate gate(options, 1.0);
  gate.judge(frame);
  return gate;
}

}  // namespace slammot::test
