#include "smoothers/graph/graph.h"

#include <algorithm>
#include <cmath>

#include "models/so3.h"

namespace slammot {

namespace {

// What a measurement behind the camera costs: a candidate step that puts it there is refused.
constexpr double kImpossible = 1e6;

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMajorSmall =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxBlock, kMaxBlock>;

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
  Variable& variable = variables_[next_variable_];
  variable.value = value;
  variable.manifold = manifold;
  variable.owner = owner;
  return next_variable_++;
}

FactorId Graph::add_factor(std::vector<VariableId> variables,
                           std::unique_ptr<ceres::CostFunction> cost,
                           const ceres::LossFunction* loss) {
  Factor& factor = factors_[next_factor_];
  factor.variables = std::move(variables);
  factor.offset = {0};
  for (const VariableId id : factor.variables) {
    factor.at.push_back(&variables_.at(id));
    factor.offset.push_back(factor.offset.back() + factor.at.back()->dim());
  }
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

double Graph::linearise(Factor& factor) {
  const std::size_t n = factor.at.size();
  const int rows = factor.cost->num_residuals();
  std::size_t size = 0;
  for (const Variable* v : factor.at) size += static_cast<std::size_t>(rows * v->value.size());
  ambient_.resize(size);
  here_.clear();
  there_.clear();
  jacobians_.clear();
  bool at_first = false;
  double* next = ambient_.data();
  for (const Variable* v : factor.at) {
    here_.push_back(v->value.data());
    there_.push_back(v->first ? v->first->data() : here_.back());
    at_first = at_first || v->first;
    jacobians_.push_back(next);
    next += rows * v->value.size();
  }
  factor.r.resize(rows);
  factor.valid = factor.cost->Evaluate(there_.data(), factor.r.data(), jacobians_.data());
  if (at_first) {
    factor.valid = factor.cost->Evaluate(here_.data(), factor.r.data(), nullptr) && factor.valid;
  }
  factor.J.resize(rows, factor.offset.back());
  if (!factor.valid) {
    factor.J.setZero();
    factor.r.setZero();
    return 0.0;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Variable& v = *factor.at[i];
    const Eigen::Map<RowMajorMatrix> ambient(jacobians_[i], rows, v.value.size());
    if (v.manifold) {
      RowMajorSmall P(v.value.size(), v.dim());
      v.manifold->PlusJacobian(there_[i], P.data());
      factor.jacobian(i) = ambient.lazyProduct(P);
    } else {
      factor.jacobian(i) = ambient;
    }
  }
  const double square = factor.r.squaredNorm();
  if (!factor.loss) return square;
  double rho[3];  // iteratively reweighted: the loss's slope scales the residual
  factor.loss->Evaluate(square, rho);
  const double weight = std::sqrt(rho[1]);
  factor.r *= weight;
  factor.J *= weight;
  return rho[0];
}

double Graph::prior_square(const Eigen::VectorXd& difference) const {
  return prior_.cols() == 0 ? 0.0 : (prior_.R * difference + prior_.r).squaredNorm();
}

double Graph::cost(const Step& step) {
  for (auto& [id, v] : variables_) v.candidate = v.value;
  for (const auto& [id, d] : step) {
    Variable& v = variables_.at(id);
    v.candidate = plus(v.manifold, v.value, d);
  }
  double sum = 0.0;
  SmallVector r;
  for (const auto& [id, factor] : factors_) {
    if (!factor.valid) continue;
    here_.clear();
    for (const Variable* v : factor.at) here_.push_back(v->candidate.data());
    r.resize(factor.cost->num_residuals());
    if (!factor.cost->Evaluate(here_.data(), r.data(), nullptr)) {
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
    d.segment(prior_.offsets[i], v.dim()) = minus(v.manifold, v.candidate, prior_.x0[i]);
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
  for (auto& [id, v] : variables_) {
    v.correction.setZero(v.dim());
    v.turn.reset();
  }
  for (const auto& [id, d] : step) {
    Variable& v = variables_.at(id);
    const SmallVector before = v.value;
    v.value = plus(v.manifold, v.value, d);
    v.correction = d;
    if (v.manifold) v.turn = transport(v, before).topLeftCorner<3, 3>();
  }
  for (auto& [id, factor] : factors_) {
    for (std::size_t i = 0; i < factor.at.size(); ++i) {
      const Variable& v = *factor.at[i];
      factor.r += factor.jacobian(i).lazyProduct(v.correction);
      if (!v.turn) continue;
      auto rotation = factor.J.middleCols<3>(factor.offset[i]);
      rotation = (rotation.lazyProduct(*v.turn)).eval();
    }
  }
}

}  // namespace slammot
