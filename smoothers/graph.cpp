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
  std::vector<VariableId> far;
  for (const VariableId id : ids) {
    variables_.erase(id);
    if (far_.contains(id)) far.push_back(id);
    resting_.erase(id);
  }
  far_.forget(far);
}

void Graph::forget_first_estimate(VariableId id) { variables_.at(id).first.reset(); }

double Graph::linearise() {
  double sum = prior_square(prior_difference());
  for (auto& [id, factor] : factors_) sum += linearise(factor);
  return 0.5 * sum;
}

double Graph::linearise(Factor& factor) const {
  const std::size_t n = factor.variables.size();
  const int rows = factor.cost->num_residuals();
  std::vector<const Variable*> variables(n);
  std::vector<const double*> here(n), there(n);
  std::vector<double*> jacobians(n);
  std::vector<RowMajorMatrix> ambient(n);
  bool at_first = false;
  for (std::size_t i = 0; i < n; ++i) {
    const Variable& v = *(variables[i] = &variables_.at(factor.variables[i]));
    here[i] = v.value.data();
    there[i] = v.first ? v.first->data() : here[i];
    at_first = at_first || v.first;
    ambient[i].resize(rows, v.value.size());
    jacobians[i] = ambient[i].data();
  }
  factor.r.resize(rows);
  factor.valid = factor.cost->Evaluate(there.data(), factor.r.data(), jacobians.data());
  if (at_first) {
    factor.valid = factor.cost->Evaluate(here.data(), factor.r.data(), nullptr) && factor.valid;
  }
  factor.J.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Variable& v = *variables[i];
    if (!factor.valid) {
      factor.J[i].setZero(rows, v.dim());
    } else if (v.manifold) {
      RowMajorMatrix P(v.value.size(), v.dim());
      v.manifold->PlusJacobian(there[i], P.data());
      factor.J[i].noalias() = ambient[i].lazyProduct(P);
    } else {
      factor.J[i] = ambient[i];
    }
  }
  if (!factor.valid) factor.r.setZero();
  const double square = factor.r.squaredNorm();
  if (!factor.valid || !factor.loss) return square;
  double rho[3];  // iteratively reweighted: the loss's slope scales the residual
  factor.loss->Evaluate(square, rho);
  const double weight = std::sqrt(rho[1]);
  factor.r *= weight;
  for (SmallMatrix& J : factor.J) J *= weight;
  return rho[0];
}

double Graph::prior_square(const Eigen::VectorXd& difference) const {
  return prior_.cols() == 0 ? 0.0 : (prior_.R * difference + prior_.r).squaredNorm();
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
  Eigen::VectorXd d(prior_.cols());
  for (std::size_t i = 0; i < prior_.variables.size(); ++i) {
    const Variable& v = variables_.at(prior_.variables[i]);
    d.segment(prior_.offsets[i], v.dim()) =
        minus(v.manifold, *at(prior_.variables[i]), prior_.x0[i]);
  }
  return 0.5 * (sum + prior_square(d));
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

}  // namespace slammot
