#include "filters/covariance/far_part.h"

#include "estimation/estimator.h"

namespace slammot {

Eigen::VectorXd FarPart::take_correction() {
  Eigen::VectorXd dx = cross().transpose() * l_;
  l_.setZero();
  return dx;
}

Eigen::MatrixXd FarPart::columns(const JointCovariance& near, StateBlock b) const {
  return near.multiply(adjoint_, cross().middleCols(b.offset, b.dim));
}

JointCovariance::Block FarPart::block(StateBlock a, StateBlock b,
                                      const Eigen::MatrixXd& columns) const {
  return covariance_.block(a, b) + cross().middleCols(a.offset, a.dim).transpose() *
                                       columns.middleRows(adjoint_.offset, adjoint_.dim);
}

void FarPart::fold(JointCovariance& near, const std::vector<int>& kept,
                   const std::vector<int>& resting, int first) {
  const int far = size(), rest = static_cast<int>(resting.size());
  const int keep = static_cast<int>(kept.size());
  Eigen::MatrixXd P_B(near.size(), 0);  // P_AB, with the rows of l among it
  if (far > 0) P_B = near.multiply(adjoint_, cross());
  covariance_.add_product(cross(), P_B.middleRows(adjoint_.offset, adjoint_.dim));
  const Eigen::MatrixXd P = near.dense();
  covariance_.append_rows(P_B(resting, Eigen::all).transpose(), P(resting, resting));

  cross_.resize(keep + keep / 4, far + rest);
  cross_.topLeftCorner(keep, far) = P_B(kept, Eigen::all);
  cross_.topRightCorner(keep, rest) = P(kept, resting);
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
  near.assign(renewed);
  ++folds_;
}

StateBlock FarPart::bring_back(JointCovariance& near, StateBlock b) {
  const StateBlock joining{adjoint_.end(), b.dim};
  near.clear(joining);
  Eigen::MatrixXd columns = this->columns(near, b);
  columns.middleRows(joining.offset, joining.dim).setIdentity();
  const Eigen::MatrixXd own = block(b, b, columns);
  const StateBlock back = near.append_rows(columns, own);

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

std::optional<StateBlock> FarPart::remove(StateBlock b) {
  auto moved = covariance_.remove(b);
  if (!moved) return moved;
  cross_.middleCols(b.offset, b.dim) = cross_.middleCols(moved->offset, moved->dim);
  moved->far = true;
  return moved;
}

void FarPart::check() const {
  const auto diagonal = covariance_.diagonal();
  if (empty() || (diagonal.allFinite() && diagonal.minCoeff() >= 0.0)) return;
  throw Diverged("the covariance of the far part has a negative or infinite variance");
}

}  // namespace slammot
