#include "filters/covariance/passive_map.h"

#include "estimation/estimator.h"

namespace slammot {

Eigen::VectorXd PassiveMap::take_correction() {
  Eigen::VectorXd dx = cross().transpose() * l_;
  l_.setZero();
  return dx;
}

Eigen::MatrixXd PassiveMap::columns(const JointCovariance& active, StateBlock b) const {
  return active.multiply(adjoint_, cross().middleCols(b.offset, b.dim));
}

JointCovariance::Block PassiveMap::block(StateBlock a, StateBlock b,
                                         const Eigen::MatrixXd& columns) const {
  return covariance_.block(a, b) + cross().middleCols(a.offset, a.dim).transpose() *
                                       columns.middleRows(adjoint_.offset, adjoint_.dim);
}

void PassiveMap::synchronise(JointCovariance& active, const std::vector<int>& kept,
                             const std::vector<int>& deactivated, int first) {
  const int passive = size(), idle = static_cast<int>(deactivated.size());
  const int keep = static_cast<int>(kept.size());
  Eigen::MatrixXd P_B(active.size(), 0);  // P_AB, with the rows of l among it
  if (passive > 0) P_B = active.multiply(adjoint_, cross());
  covariance_.add_product(cross(), P_B.middleRows(adjoint_.offset, adjoint_.dim));
  const Eigen::MatrixXd P = active.dense();
  covariance_.append_rows(P_B(deactivated, Eigen::all).transpose(), P(deactivated, deactivated));

  cross_.resize(keep + keep / 4, passive + idle);
  cross_.topLeftCorner(keep, passive) = P_B(kept, Eigen::all);
  cross_.topRightCorner(keep, idle) = P(kept, deactivated);
  adjoint_ = {first, size() > 0 ? keep : 0};
  l_.setZero(adjoint_.dim);

  std::vector<int> places(kept.size());
  for (int i = 0; i < keep; ++i)
    places[static_cast<std::size_t>(i)] = i < first ? i : i + adjoint_.dim;
  Eigen::MatrixXd renewed = Eigen::MatrixXd::Zero(keep + adjoint_.dim, keep + adjoint_.dim);
  renewed(places, places) = P(kept, kept);
  for (int i = 0; i < adjoint_.dim; ++i) {
    const int place = places[static_cast<std::size_t>(i)];
    renewed(place, first + i) = renewed(first + i, place) = 1.0;
  }
  active.assign(renewed);
  ++synchronisations_;
}

StateBlock PassiveMap::reactivate(JointCovariance& active, StateBlock b) {
  const StateBlock joining{adjoint_.end(), b.dim};
  active.clear(joining);
  Eigen::MatrixXd columns = this->columns(active, b);
  columns.middleRows(joining.offset, joining.dim).setIdentity();
  const Eigen::MatrixXd own = block(b, b, columns);
  const StateBlock back = active.append_rows(columns, own);

  if (joining.end() - adjoint_.offset > cross_.rows()) {
    cross_.conservativeResize(cross_.rows() + cross_.rows() / 4 + b.dim, Eigen::NoChange);
  }
  Eigen::MatrixXd P_b(size(), b.dim);
  covariance_.columns(b, P_b);
  cross_.block(adjoint_.dim, 0, b.dim, size()) = P_b.transpose();
  adjoint_.dim += b.dim;
  l_.conservativeResize(adjoint_.dim);
  l_.tail(b.dim).setZero();
  return back;
}

std::optional<StateBlock> PassiveMap::remove(StateBlock b) {
  auto moved = covariance_.remove(b);
  if (!moved) return moved;
  cross_.middleCols(b.offset, b.dim) = cross_.middleCols(moved->offset, moved->dim);
  moved->passive = true;
  return moved;
}

void PassiveMap::check() const {
  const auto diagonal = covariance_.diagonal();
  if (empty() || (diagonal.allFinite() && diagonal.minCoeff() >= 0.0)) return;
  throw Diverged("the covariance of the passive map has a negative or infinite variance");
}

}  // namespace slammot
