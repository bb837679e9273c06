// The conditional map, which puts off most of its work, against one that does all of it at once:
// many variables fall asleep, wake, and are forgotten while those they depend on come and go.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <random>
#include <span>

#include "smoothers/graph/conditional_map.h"

namespace slammot {
namespace {

// x = mean + K (b [-] b0) + e, as it is written. Three rows for each of `ids`.
struct PlainMap {
  std::vector<VariableId> ids;
  Eigen::VectorXd mean;
  Eigen::MatrixXd K, Sigma;

  std::vector<int> rows(const std::vector<VariableId>& of) const {
    std::vector<int> rows;
    for (const VariableId id : of) {
      const auto at = static_cast<int>(std::ranges::find(ids, id) - ids.begin());
      for (int k = 0; k < 3; ++k) rows.push_back(3 * at + k);
    }
    return rows;
  }
  void keep(const std::vector<VariableId>& kept) {
    const std::vector<int> at = rows(kept);
    mean = mean(at).eval();
    K = K(at, Eigen::all).eval();
    Sigma = Sigma(at, at).eval();
    ids = kept;
  }
  std::vector<VariableId> without(const std::vector<VariableId>& gone) const {
    std::vector<VariableId> rest;
    for (const VariableId id : ids) {
      if (std::ranges::find(gone, id) == gone.end()) rest.push_back(id);
    }
    return rest;
  }
  void add(VariableId id, const Eigen::Vector3d& value, Eigen::Index column) {
    const Eigen::Index n = mean.size();
    ids.push_back(id);
    mean.conservativeResize(n + 3);
    mean.tail<3>() = value;
    K.conservativeResizeLike(Eigen::MatrixXd::Zero(n + 3, K.cols()));
    K.block<3, 3>(n, column).setIdentity();
    Sigma.conservativeResizeLike(Eigen::MatrixXd::Zero(n + 3, n + 3));
  }
  void eliminate(const std::vector<int>& columns, const Eigen::MatrixXd& T,
                 const Eigen::MatrixXd& R, const Eigen::VectorXd& r) {
    const Eigen::Index n = R.rows(), rest = R.cols() - n;
    const Eigen::MatrixXd K_s = K(Eigen::all, columns);
    K(Eigen::all, columns).setZero();
    K += K_s * T;
    const Eigen::MatrixXd A = K.leftCols(n) * R.leftCols(n).inverse();
    mean -= A * r;
    K = (K.rightCols(rest) - A * R.rightCols(rest)).eval();
    Sigma += A * A.transpose();
  }
  // The others given `of`, which become the first columns.
  void reactivate(const std::vector<VariableId>& of) {
    const std::vector<int> p = rows(of), i = rows(without(of));
    const Eigen::MatrixXd gain = Sigma(i, p) * Sigma(p, p).inverse();
    Eigen::MatrixXd K_i(std::ssize(i), std::ssize(p) + K.cols());
    K_i << gain, K(i, Eigen::all) - gain * K(p, Eigen::all);
    const Eigen::VectorXd mean_i = mean(i);  // given d = 0, that is, x_p at its mean
    const Eigen::MatrixXd Sigma_i = Sigma(i, i) - gain * Sigma(p, i);
    ids = without(of);
    mean = mean_i;
    K = K_i;
    Sigma = Sigma_i;
  }
};

struct MapLevels : testing::Test {
  static constexpr int kActive = 4;  // of the prior's variables, after each frame
  std::mt19937_64 engine{1};
  Variables variables;
  std::vector<Variable*> active;  // as the prior has them
  MarginalPrior prior{false};
  ConditionalMap map;
  PlainMap plain;

  Eigen::VectorXd normals(Eigen::Index size, double sigma) {
    std::normal_distribution<double> normal;
    return Eigen::VectorXd::NullaryExpr(size, [&] { return sigma * normal(engine); });
  }
  Eigen::MatrixXd normals(Eigen::Index rows, Eigen::Index cols, double sigma) {
    return normals(rows * cols, sigma).reshaped(rows, cols);
  }
  std::vector<VariableId> some(int count) {
    std::vector<VariableId> ids = plain.ids;
    std::ranges::shuffle(ids, engine);
    ids.resize(std::min(ids.size(), static_cast<std::size_t>(count)));
    return ids;
  }
  Variable& create() { return variables.add(normals(3, 1.0), false, false); }
  void set_prior() {
    const Eigen::Index n = 3 * std::ssize(active);
    prior.set(active, Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Zero(n));
  }
  void move() {
    for (Variable* v : active) v->value += normals(3, 0.1);
  }

  // Columns: what leaves of the prior, what falls asleep, and the rest of the prior. One of the
  // latter has moved on meanwhile: it was a combination of all.
  void frame(int asleep) {
    int column = 0;
    const auto place = [&](Variable& v) {
      v.column = column;
      column += 3;
    };
    const auto leaving = std::max<std::ptrdiff_t>(0, std::ssize(active) - kActive);
    for (Variable* v : std::span(active).first(static_cast<std::size_t>(leaving))) place(*v);
    std::vector<Variable*> sleepers;
    for (int i = 0; i < asleep; ++i) place(*sleepers.emplace_back(&create()));
    const int gone = column;
    active.erase(active.begin(), active.begin() + leaving);
    while (std::ssize(active) < kActive) active.push_back(&create());  // nothing depends on it yet
    for (Variable* v : active) place(*v);
    const int total = column;

    const Eigen::VectorXd d = prior.difference();
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(plain.mean.size(), total);
    if (plain.mean.size() > 0) {
      plain.mean += plain.K * d;
      for (const auto& b : prior.blocks()) {
        K.middleCols<3>(b.variable->column) = plain.K.middleCols<3>(b.offset);
      }
    }
    plain.K = K;
    map.relinearise(prior, total);
    for (const Variable* v : sleepers) {
      plain.add(v->id, Eigen::Vector3d(v->value), v->column);
      map.deactivate(*v, v->column);
    }
    std::vector<int> changed(static_cast<std::size_t>(gone + 3));
    for (std::size_t i = 0; i < changed.size(); ++i) changed[i] = static_cast<int>(i);
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(gone + 3, total);
    T.bottomRows<3>() += normals(3, total, 0.1);
    Eigen::MatrixXd R = normals(gone, total, 0.3).triangularView<Eigen::Upper>();
    R.diagonal().array() += 2.0;
    const Eigen::VectorXd r = normals(gone, 1.0);
    map.eliminate(changed, T, R, r);
    plain.eliminate(changed, T, R, r);
    set_prior();
  }

  void reactivate(const std::vector<VariableId>& ids) {
    const std::vector<int> at = plain.rows(ids);
    const auto back = map.reactivate(ids, prior.chart_at_origin());
    EXPECT_LT((back.mean - plain.mean(at)).norm(), 1e-9);
    EXPECT_LT((back.K - plain.K(at, Eigen::all)).norm(), 1e-9 * back.K.norm());
    const Eigen::MatrixXd P = (back.U.transpose() * back.U).inverse();
    EXPECT_LT((P - plain.Sigma(at, at)).norm(), 1e-9 * P.norm());
    plain.reactivate(ids);
    std::vector<Variable*> returning;
    for (const VariableId id : ids) {
      returning.push_back(&variables[id]);
      variables[id].value = back.mean.segment<3>(3 * std::ssize(returning) - 3);
    }
    prior.join(returning, back.mean, back.K, back.U);
    active.insert(active.begin(), returning.begin(), returning.end());
  }

  void expect_same() {
    ASSERT_EQ(map.dim(), plain.mean.size());
    std::vector<SmallVector> kept;
    for (Variable* v : active) {
      kept.push_back(v->value);
      v->value += normals(3, 1.0);
    }
    const ScaleChart b = prior.chart();
    for (std::size_t i = 0; i < active.size(); ++i) active[i]->value = kept[i];
    const Eigen::VectorXd x = plain.mean + plain.K * b.difference();
    std::vector<VariableId> ids = some(10000);
    for (const VariableId id : ids) {
      EXPECT_LT((map.value(id, b) - x(plain.rows({id}))).norm(), 1e-9 * x.norm());
    }
    const std::vector<int> at = plain.rows(ids);
    EXPECT_LT((map.gain(ids, b) - plain.K(at, Eigen::all)).norm(), 1e-9 * plain.K.norm());
    EXPECT_LT((map.covariance(ids) - plain.Sigma(at, at)).norm(), 1e-9 * plain.Sigma.norm());
  }
};

TEST_F(MapLevels, AreOneMap) {
  for (int i = 0; i < kActive; ++i) active.push_back(&create());
  set_prior();
  for (int k = 0; k < 40; ++k) {
    SCOPED_TRACE(k);
    frame(k % 4 == 3 ? 1 : 13);
    expect_same();
    if (k % 2 == 1) reactivate(some(k % 3 + 3));
    expect_same();
    move();
    if (k % 3 == 0) {
      map.relinearise(prior.chart());
      plain.mean += plain.K * prior.difference();
      prior.relinearise();
      expect_same();
    }
    if (k % 5 == 4) {
      const std::vector<VariableId> ids = some(4);
      map.forget(ids);
      plain.keep(plain.without(ids));
      for (const VariableId id : ids) EXPECT_FALSE(map.contains(id));
      expect_same();
    }
    if (k % 7 == 6) {  // all at once, of whatever level
      reactivate(some(15));
      expect_same();
    }
    if (k % 8 == 7) {
      const auto& block = *prior.find(active.back()->id);
      plain.mean -= plain.K.middleCols<3>(block.offset) * block.x0;
      Eigen::MatrixXd K(plain.K.rows(), plain.K.cols() - 3);
      K << plain.K.leftCols(block.offset), plain.K.rightCols(K.cols() - block.offset);
      plain.K = K;
      map.condition_on_zero(block);
      prior.condition_on_zero(active.back()->id);
      active.pop_back();
      expect_same();
    }
  }
  EXPECT_GT(map.dim(), 300);
  reactivate(plain.ids);
  EXPECT_TRUE(map.empty());
}

}  // namespace
}  // namespace slammot
