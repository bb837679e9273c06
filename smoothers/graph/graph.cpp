#include "smoothers/graph/graph.h"

#include <cmath>
#include <stdexcept>

namespace slammot {

namespace {

// What a measurement behind the camera costs: a candidate step that puts it there is refused.
constexpr double kImpossible = 1e6;

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMajorSmall =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxBlock, kMaxBlock>;

}  // namespace

VariableId Graph::add_variable(const Eigen::VectorXd& value, const ceres::Manifold* manifold,
                               int owner) {
  Variable& variable = variables_[next_variable_];
  variable.id = next_variable_;
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
  for (const VariableId id : ids) {
    if (prior_.active.find(id)) throw std::logic_error("the prior still touches this variable");
    const bool was_active = variables_.erase(id) > 0;
    if (!was_active && prior_.inactive.contains(id)) prior_.inactive.forget({id});
  }
}

void Graph::reactivate(const std::vector<VariableId>& ids) {
  if (ids.empty()) return;
  auto back = prior_.inactive.reactivate(ids, prior_.active.difference());
  std::vector<Variable*> variables;
  for (Variable& v : back.variables) variables.push_back(&(variables_[v.id] = std::move(v)));
  prior_.active.join(variables, back.mean, back.K, back.U);
}

SmallVector Graph::value(VariableId id) const {
  const auto active = variables_.find(id);
  return active != variables_.end() ? active->second.value
                                    : prior_.inactive.value(id, prior_.active.difference());
}

std::map<VariableId, SmallVector> values(const Graph& graph) {
  auto values = graph.prior().inactive.values(graph.prior().active.difference());
  for (const auto& [id, v] : graph.variables()) values[id] = v.value;
  return values;
}

double Graph::linearise() {
  double sum = prior_.active.square();
  for (auto& [id, factor] : factors_) sum += linearise(factor);
  return 0.5 * sum;
}

// The residual at the values, and the Jacobians at the linearisation points.
bool Graph::evaluate(Factor& factor) {
  const int rows = factor.cost->num_residuals();
  std::size_t size = 0;
  for (const Variable* v : factor.at) size += static_cast<std::size_t>(rows * v->value.size());
  ambient_.resize(size);
  values_.clear();
  points_.clear();
  jacobians_.clear();
  bool elsewhere = false;
  double* next = ambient_.data();
  for (const Variable* v : factor.at) {
    values_.push_back(v->value.data());
    points_.push_back(v->point().data());
    elsewhere = elsewhere || v->linearisation_point;
    jacobians_.push_back(next);
    next += rows * v->value.size();
  }
  factor.r.resize(rows);
  const bool valid = factor.cost->Evaluate(points_.data(), factor.r.data(), jacobians_.data());
  if (!elsewhere) return valid;
  return factor.cost->Evaluate(values_.data(), factor.r.data(), nullptr) && valid;
}

double Graph::linearise(Factor& factor) {
  factor.valid = evaluate(factor);
  const Eigen::Index rows = factor.r.size();
  factor.J.resize(rows, factor.offset.back());
  if (!factor.valid) {
    factor.J.setZero();
    factor.r.setZero();
    return 0.0;
  }
  for (std::size_t i = 0; i < factor.at.size(); ++i) {
    const Variable& v = *factor.at[i];
    const Eigen::Map<RowMajorMatrix> ambient(jacobians_[i], rows, v.value.size());
    if (v.manifold) {
      RowMajorSmall P(v.value.size(), v.dim());
      v.manifold->PlusJacobian(points_[i], P.data());
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
    values_.clear();
    for (const Variable* v : factor.at) values_.push_back(v->candidate.data());
    r.resize(factor.cost->num_residuals());
    if (!factor.cost->Evaluate(values_.data(), r.data(), nullptr)) {
      sum += kImpossible;
      continue;
    }
    double rho[3] = {r.squaredNorm(), 1.0, 0.0};
    if (factor.loss) factor.loss->Evaluate(r.squaredNorm(), rho);
    sum += rho[0];
  }
  return 0.5 * (sum + prior_.active.square(&Variable::candidate));
}

void Graph::retract(const Step& step) {
  for (auto& [id, v] : variables_) {
    v.correction.setZero(v.dim());
    v.turn.reset();
  }
  for (const auto& [id, d] : step) {
    Variable& v = variables_.at(id);
    const SmallVector before = v.value;
    v.value = plus(v.manifold, v.value, d);
    v.correction = d;
    if (v.manifold && !prior_.first_estimates()) {
      v.turn = transport(v, before).topLeftCorner<3, 3>();
    }
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
