// The prior of a graph and the far map behind it.
#include <algorithm>

#include "smoothers/graph/graph.h"

namespace slammot {

namespace {

// R'R, by panels of columns; rows below the last that is not zero (R is a triangle) are left out.
Eigen::MatrixXd gram(const Eigen::MatrixXd& R) {
  constexpr Eigen::Index kPanel = 64;
  const Eigen::Index n = R.cols();
  Eigen::MatrixXd RtR(n, n);
  for (Eigen::Index c = 0; c < n; c += kPanel) {
    const Eigen::Index width = std::min(kPanel, n - c);
    Eigen::Index rows = R.rows();
    while (rows > 0 && (R.row(rows - 1).segment(c, width).array() == 0.0).all()) --rows;
    RtR.block(c, c, n - c, width).noalias() =
        R.topRightCorner(rows, n - c).transpose() * R.block(0, c, rows, width);
  }
  RtR.triangularView<Eigen::StrictlyUpper>() = RtR.transpose();
  return RtR;
}

}  // namespace

SmallVector Graph::value(VariableId id) const {
  const auto it = variables_.find(id);
  if (it != variables_.end()) return it->second.value;
  const int row = far_.offsets.at(id);
  return far_.mean.segment<FarMap::kDim>(row) +
         far_.K.middleRows<FarMap::kDim>(row) * prior_difference();
}

Graph::Values Graph::far_values() const {
  Values values;
  if (far_.empty()) return values;
  const Eigen::VectorXd x = far_.mean + far_.K * prior_difference();
  for (const auto& [id, row] : far_.offsets) values[id] = x.segment<FarMap::kDim>(row);
  return values;
}

void Graph::bring_back(const std::vector<VariableId>& ids) {
  if (ids.empty()) return;
  std::vector<SmallVector> values;
  for (const VariableId id : ids) values.push_back(value(id));
  const Returned back = take_back(far_, ids);
  const Eigen::Index n = back.mean.size(), m = prior_.cols();
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n + prior_.R.rows(), n + m);
  R.topLeftCorner(n, n) = back.U;
  R.topRightCorner(n, m) = -back.U * back.K;
  R.bottomRightCorner(prior_.R.rows(), m) = prior_.R;
  Eigen::MatrixXd RtR(n + m, n + m);
  RtR.leftCols(n) = R.transpose() * R.leftCols(n);
  RtR.topRightCorner(n, m) = RtR.bottomLeftCorner(m, n).transpose();
  const auto top = R.topRightCorner(n, m);
  RtR.bottomRightCorner(m, m) = prior_.RtR + top.transpose() * top;
  prior_.R = std::move(R);
  prior_.RtR = std::move(RtR);
  prior_.r =
      (Eigen::VectorXd(n + prior_.r.size()) << Eigen::VectorXd::Zero(n), prior_.r).finished();
  for (int& offset : prior_.offsets) offset += static_cast<int>(n);
  for (std::size_t i = ids.size(); i-- > 0;) {
    const auto at = static_cast<int>(i) * FarMap::kDim;
    Variable& v = variables_[ids[i]] = std::move(resting_.at(ids[i]));
    v.value = values[i];
    resting_.erase(ids[i]);
    prior_.variables.insert(prior_.variables.begin(), ids[i]);
    prior_.offsets.insert(prior_.offsets.begin(), at);
    prior_.x0.insert(prior_.x0.begin(), SmallVector(back.mean.segment<FarMap::kDim>(at)));
  }
}

void Graph::fix_at_zero(VariableId id) {
  const auto it = std::find(prior_.variables.begin(), prior_.variables.end(), id);
  if (it != prior_.variables.end()) {
    const auto k = static_cast<std::size_t>(it - prior_.variables.begin());
    const int offset = prior_.offsets[k];
    const int dim = variables_.at(id).dim();
    const int rest = prior_.cols() - offset - dim;
    prior_.r.noalias() -= prior_.R.middleCols(offset, dim) * prior_.x0[k];
    if (!far_.empty()) {
      far_.mean.noalias() -= far_.K.middleCols(offset, dim) * prior_.x0[k];
      Eigen::MatrixXd K(far_.rows(), prior_.cols() - dim);
      K << far_.K.leftCols(offset), far_.K.rightCols(rest);
      far_.K = std::move(K);
    }
    Eigen::MatrixXd R(prior_.R.rows(), prior_.cols() - dim);
    R << prior_.R.leftCols(offset), prior_.R.rightCols(rest);
    prior_.R = std::move(R);
    Eigen::MatrixXd RtR(prior_.cols(), prior_.cols());
    const auto& old = prior_.RtR;
    RtR << old.topLeftCorner(offset, offset), old.topRightCorner(offset, rest),
        old.bottomLeftCorner(rest, offset), old.bottomRightCorner(rest, rest);
    prior_.RtR = std::move(RtR);
    prior_.variables.erase(it);
    prior_.offsets.erase(prior_.offsets.begin() + static_cast<std::ptrdiff_t>(k));
    prior_.x0.erase(prior_.x0.begin() + static_cast<std::ptrdiff_t>(k));
    for (std::size_t i = k; i < prior_.offsets.size(); ++i) prior_.offsets[i] -= dim;
  }
  variables_.erase(id);
}

Eigen::VectorXd Graph::prior_difference() const {
  Eigen::VectorXd d(prior_.cols());
  for (std::size_t i = 0; i < prior_.variables.size(); ++i) {
    const Variable& v = variables_.at(prior_.variables[i]);
    d.segment(prior_.offsets[i], v.dim()) = minus(v.manifold, v.value, prior_.x0[i]);
  }
  return d;
}

Eigen::MatrixXd Graph::prior_jacobian() const {
  Eigen::MatrixXd J = prior_.R;
  for (std::size_t i = 0; i < prior_.variables.size(); ++i) {
    const Variable& v = variables_.at(prior_.variables[i]);
    if (!v.manifold || first_estimates_) continue;
    auto columns = J.middleCols(prior_.offsets[i], v.dim());
    columns = (columns * transport(v, prior_.x0[i])).eval();
  }
  return J;
}

void Graph::rebase_prior() {
  if (prior_.cols() == 0) return;
  const Eigen::VectorXd d = prior_difference();
  prior_.r += prior_.R * d;
  if (!far_.empty()) far_.mean += far_.K * d;
  for (std::size_t i = 0; i < prior_.variables.size(); ++i) {
    const Variable& v = variables_.at(prior_.variables[i]);
    const int at = prior_.offsets[i];
    if (v.manifold && !first_estimates_) {
      const SmallMatrix T = transport(v, prior_.x0[i]);
      prior_.R.middleCols(at, v.dim()) = (prior_.R.middleCols(at, v.dim()) * T).eval();
      if (!far_.empty()) {
        far_.K.middleCols(at, v.dim()) = (far_.K.middleCols(at, v.dim()) * T).eval();
      }
      prior_.RtR.middleCols(at, v.dim()) = (prior_.RtR.middleCols(at, v.dim()) * T).eval();
      prior_.RtR.middleRows(at, v.dim()) =
          (T.transpose() * prior_.RtR.middleRows(at, v.dim())).eval();
    }
    prior_.x0[i] = v.value;
  }
}

void Graph::set_prior(std::vector<VariableId> variables, Eigen::MatrixXd R, Eigen::VectorXd r) {
  prior_ = {};
  if (variables.empty()) return;
  prior_.R = std::move(R);
  prior_.r = std::move(r);
  prior_.RtR = gram(prior_.R);
  int offset = 0;
  for (const VariableId id : variables) {
    Variable& v = variables_.at(id);
    if (first_estimates_ && !v.first) v.first = v.value;
    prior_.offsets.push_back(offset);
    prior_.x0.push_back(v.value);
    offset += v.dim();
  }
  prior_.variables = std::move(variables);
}

FarMap Graph::take_far(const std::map<VariableId, int>& columns, int total) {
  FarMap far = std::move(far_);
  far_ = {};
  const Eigen::MatrixXd K = std::move(far.K);
  far.K.setZero(far.rows(), total);
  if (far.empty()) return far;
  far.mean.noalias() += K * prior_difference();
  for (std::size_t i = 0; i < prior_.variables.size(); ++i) {
    const Variable& v = variables_.at(prior_.variables[i]);
    const auto from = K.middleCols(prior_.offsets[i], v.dim());
    auto to = far.K.middleCols(columns.at(prior_.variables[i]), v.dim());
    if (v.manifold) {
      to.noalias() = from * transport(v, prior_.x0[i]);
    } else {
      to = from;
    }
  }
  return far;
}

void Graph::set_far(FarMap far, const std::set<VariableId>& rested) {
  far_ = std::move(far);
  for (const VariableId id : rested) {
    resting_[id] = std::move(variables_.at(id));
    variables_.erase(id);
  }
}

}  // namespace slammot
