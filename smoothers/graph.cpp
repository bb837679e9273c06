#include "slammot/smoothers/graph.h"

#include <algorithm>
#include <cmath>

#include "slammot/models/so3.h"

namespace slammot {

namespace {

// What a measurement behind the camera costs: a candidate step that puts it there is refused.
constexpr double kImpossible = 1e6;

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<const double*> pointers(const std::vector<const SmallVector*>& values) {
  std::vector<const double*> result;
  for (const SmallVector* v : values) result.push_back(v->data());
  return result;
}

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

SmallVector plus(const ceres::Manifold* manifold, const SmallVector& x, const SmallVector& d) {
  if (!manifold) return x + d;
  SmallVector y(x.size());
  manifold->Plus(x.data(), d.data(), y.data());
  return y;
}

SmallVector minus(const ceres::Manifold* manifold, const SmallVector& y, const SmallVector& x) {
  if (!manifold) return y - x;
  SmallVector d(manifold->TangentSize());
  manifold->Minus(y.data(), x.data(), d.data());
  return d;
}

VariableId Graph::add_variable(const Eigen::VectorXd& value, const ceres::Manifold* manifold,
                               int owner) {
  variables_[next_variable_] = {value, manifold, owner, std::nullopt};
  return next_variable_++;
}

FactorId Graph::add_factor(std::vector<VariableId> variables,
                           std::unique_ptr<ceres::CostFunction> cost,
                           const ceres::LossFunction* loss) {
  Factor& factor = factors_[next_factor_];
  factor.variables = std::move(variables);
  factor.cost = std::move(cost);
  factor.loss = loss;
  linearise(factor);
  return next_factor_++;
}

void Graph::remove_variables(const std::set<VariableId>& ids) {
  std::set<VariableId> far;
  for (const VariableId id : ids) {
    variables_.erase(id);
    if (far_.contains(id)) far.insert(id);
    resting_.erase(id);
  }
  far_.forget(far);
}

SmallVector Graph::value(VariableId id) const {
  const auto it = variables_.find(id);
  if (it != variables_.end()) return it->second.value;
  const int row = far_.offsets.at(id);
  return far_.mean.segment<FarMap::kDim>(row) +
         far_.K.middleRows<FarMap::kDim>(row) * prior_difference();
}

void Graph::forget_first_estimate(VariableId id) { variables_.at(id).first.reset(); }

Graph::Values Graph::far_values() const {
  Values values;
  if (far_.dim() == 0) return values;
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

void Graph::linearise() {
  for (auto& [id, factor] : factors_) linearise(factor);
}

void Graph::linearise(Factor& factor) const {
  const std::size_t n = factor.variables.size();
  const int rows = factor.cost->num_residuals();
  std::vector<const SmallVector*> here, there;
  std::vector<RowMajorMatrix> ambient(n);
  std::vector<double*> jacobians(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Variable& v = variables_.at(factor.variables[i]);
    here.push_back(&v.value);
    there.push_back(v.first ? &*v.first : &v.value);
    ambient[i].resize(rows, v.value.size());
    jacobians[i] = ambient[i].data();
  }
  factor.r.resize(rows);
  SmallVector unused(rows);
  bool valid = factor.cost->Evaluate(pointers(there).data(), unused.data(), jacobians.data());
  valid = factor.cost->Evaluate(pointers(here).data(), factor.r.data(), nullptr) && valid;
  factor.valid = valid;
  factor.J.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Variable& v = variables_.at(factor.variables[i]);
    if (!valid) {
      factor.J[i].setZero(rows, v.dim());
    } else if (v.manifold) {
      RowMajorMatrix P(v.value.size(), v.dim());
      v.manifold->PlusJacobian(there[i]->data(), P.data());
      factor.J[i] = ambient[i] * P;
    } else {
      factor.J[i] = ambient[i];
    }
  }
  if (!valid) factor.r.setZero();
  if (valid && factor.loss) {  // iteratively reweighted: the loss's slope scales the residual
    double rho[3];
    factor.loss->Evaluate(factor.r.squaredNorm(), rho);
    const double weight = std::sqrt(rho[1]);
    factor.r *= weight;
    for (SmallMatrix& J : factor.J) J *= weight;
  }
}

double Graph::cost(const Step& step) const {
  std::map<VariableId, SmallVector> moved;
  for (const auto& [id, d] : step) {
    const Variable& v = variables_.at(id);
    moved[id] = plus(v.manifold, v.value, d);
  }
  const auto at = [&](VariableId id) {
    const auto it = moved.find(id);
    return it == moved.end() ? &variables_.at(id).value : &it->second;
  };
  double sum = 0.0;
  for (const auto& [id, factor] : factors_) {
    if (!factor.valid) continue;
    std::vector<const SmallVector*> values;
    for (const VariableId v : factor.variables) values.push_back(at(v));
    SmallVector r(factor.cost->num_residuals());
    if (!factor.cost->Evaluate(pointers(values).data(), r.data(), nullptr)) {
      sum += kImpossible;
      continue;
    }
    double rho[3] = {r.squaredNorm(), 1.0, 0.0};
    if (factor.loss) factor.loss->Evaluate(r.squaredNorm(), rho);
    sum += rho[0];
  }
  if (prior_.cols() == 0) return 0.5 * sum;
  Eigen::VectorXd d(prior_.cols());
  for (std::size_t i = 0; i < prior_.variables.size(); ++i) {
    const Variable& v = variables_.at(prior_.variables[i]);
    d.segment(prior_.offsets[i], v.dim()) =
        minus(v.manifold, *at(prior_.variables[i]), prior_.x0[i]);
  }
  return 0.5 * (sum + (prior_.R * d + prior_.r).squaredNorm());
}

SmallMatrix Graph::transport(const Variable& v, const SmallVector& x0) const {
  SmallMatrix T = SmallMatrix::Identity(v.dim(), v.dim());
  if (!v.manifold || first_estimates_) return T;
  const SmallVector d = minus(v.manifold, v.value, x0);
  T.topLeftCorner<3, 3>() = inverse_right_jacobian_so3(d.head<3>());
  return T;
}

void Graph::move(const Step& step) {
  std::map<VariableId, SmallMatrix> transports;
  for (const auto& [id, d] : step) {
    Variable& v = variables_.at(id);
    const SmallVector before = v.value;
    v.value = plus(v.manifold, v.value, d);
    if (v.manifold) transports[id] = transport(v, before);
  }
  for (auto& [id, factor] : factors_) {
    for (std::size_t i = 0; i < factor.variables.size(); ++i) {
      const auto d = step.find(factor.variables[i]);
      if (d == step.end()) continue;
      factor.r.noalias() += factor.J[i] * d->second;
      const auto T = transports.find(factor.variables[i]);
      if (T != transports.end()) factor.J[i] = (factor.J[i] * T->second).eval();
    }
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
    if (far_.dim() > 0) {
      far_.mean.noalias() -= far_.K.middleCols(offset, dim) * prior_.x0[k];
      Eigen::MatrixXd K(far_.dim(), prior_.cols() - dim);
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
  if (far_.dim() > 0) far_.mean += far_.K * d;
  for (std::size_t i = 0; i < prior_.variables.size(); ++i) {
    const Variable& v = variables_.at(prior_.variables[i]);
    const int at = prior_.offsets[i];
    if (v.manifold && !first_estimates_) {
      const SmallMatrix T = transport(v, prior_.x0[i]);
      prior_.R.middleCols(at, v.dim()) = (prior_.R.middleCols(at, v.dim()) * T).eval();
      if (far_.dim() > 0) {
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

FarMap Graph::far_at_estimate(const std::map<VariableId, int>& columns, int total) const {
  FarMap far = far_;
  far.K.setZero(far_.dim(), total);
  if (far.dim() == 0) return far;
  far.mean += far_.K * prior_difference();
  for (std::size_t i = 0; i < prior_.variables.size(); ++i) {
    const Variable& v = variables_.at(prior_.variables[i]);
    far.K.middleCols(columns.at(prior_.variables[i]), v.dim()) =
        far_.K.middleCols(prior_.offsets[i], v.dim()) * transport(v, prior_.x0[i]);
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
