#include "estimation/labels/pooled_motion.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace slammot {

namespace {

bool move_alike(const MotionBelief& a, const MotionBelief& b) {
  const Eigen::LLT<MotionMatrix> llt(a.covariance + b.covariance);
  const MotionVector d = a.w - b.w;
  return llt.info() == Eigen::Success &&
         llt.matrixL().solve(d).squaredNorm() <= 2.0 * static_cast<double>(d.size());
}

// In information form; without neighbours and unchanged where P is not positive definite.
struct Learnt {
  bool is_valid = false;
  Eigen::Vector2d pixel;
  MotionMatrix information, gain;  // P^-1, P^-1 - P_0^-1
  MotionVector vector;             // P^-1 w
};

Learnt informed(const MotionBelief& motion, const Eigen::Vector2d& pixel) {
  const Eigen::Index n = motion.w.size();
  Learnt b;
  const Eigen::LLT<MotionMatrix> llt(motion.covariance);
  b.is_valid = llt.info() == Eigen::Success;
  b.pixel = pixel;
  b.information = llt.solve(MotionMatrix::Identity(n, n));
  b.gain = b.information;
  b.gain.diagonal() -= motion.prior_sigmas.cwiseAbs2().cwiseInverse();
  b.vector = b.information * motion.w;
  return b;
}

}  // namespace

void pool_motions(std::span<const Observation> z, double radius,
                  std::vector<MotionBelief>& motions) {
  const std::vector<MotionBelief> alone = motions;
  std::vector<Learnt> beliefs;
  for (const MotionBelief& motion : alone) {
    const auto at = std::ranges::lower_bound(z, motion.track, {}, &Observation::track);
    beliefs.push_back(informed(motion, at->pixel));
  }
  for (std::size_t i = 0; i < alone.size(); ++i) {
    if (!beliefs[i].is_valid) continue;
    MotionMatrix information = beliefs[i].information;
    MotionVector vector = beliefs[i].vector;
    for (std::size_t j = 0; j < alone.size(); ++j) {
      const bool is_near = (beliefs[i].pixel - beliefs[j].pixel).norm() <= radius;
      if (j == i || !is_near || !beliefs[j].is_valid) continue;
      if (!move_alike(alone[i], alone[j])) continue;
      information += beliefs[j].gain;
      vector += beliefs[j].vector;
    }
    const Eigen::LLT<MotionMatrix> llt(information);
    if (llt.info() != Eigen::Success || !information.allFinite()) continue;
    motions[i].w = llt.solve(vector);
    motions[i].covariance = llt.solve(MotionMatrix::Identity(vector.size(), vector.size()));
  }
}

}  // namespace slammot
