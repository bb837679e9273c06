// The inactive part of the map: variables that no factor touches and that are known only through
// the prior's variables b. It is a Gaussian conditional on them,
//
//   z = mean + K d(b) + e,   e ~ N(0, Sigma),
//
// where d, b0 and the order of K's columns are those of the prior (marginal_prior.h), and z is x in
// the same coordinates as d: with x0 what x was when it was deactivated, gamma the log of the scale
// since, and S and n of scale_chart.h,
//
//   x = S(gamma) (z - n(x0) gamma),   z = x where the scale is not kept.
//
// So z changes linearly with d, and x grows with the world. The window
// solves for b only, so its cost does not grow with the map, and nothing is approximated: to
// deactivate is to factor the joint Gaussian as p(b) p(x | b), to reactivate is to multiply back.
// In a filter, Guivant and Nebot (2001) call the same idea a compressed update.
//
// b changes in every frame, and K and Sigma with it. So that a frame does not pay for the whole
// map, there are two levels: `near` holds what was deactivated lately, and the stem c, which is
// what b was when near was last emptied; `far` holds the rest, conditional on c. A frame changes
// near only. From time to time near is folded into far.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "smoothers/graph/marginal_prior.h"

namespace slammot {

class ConditionalMap {
 public:
  static constexpr int kDim = 3;  // of every variable: anchors and y alike, all Euclidean

  ConditionalMap() = default;
  explicit ConditionalMap(bool keeps_scale) : keeps_scale_(keeps_scale) {}

  bool empty() const { return places_.empty(); }
  int dim() const { return kDim * static_cast<int>(places_.size()); }
  bool contains(VariableId id) const { return places_.contains(id); }

  // The mean of x, given b.
  SmallVector value(VariableId id, const ScaleChart& b) const;
  // The same of every variable, to be asked for one by one.
  class Values {
   public:
    Eigen::Vector3d operator[](VariableId id) const;

   private:
    friend class ConditionalMap;
    const ConditionalMap* map_ = nullptr;
    Eigen::VectorXd near_, far_;
    double lambda_ = 0.0;
  };
  void values(const ScaleChart& b, Values& result) const;

  // dx/db, and the covariance of x given b, of these variables in their order.
  Eigen::MatrixXd gain(const std::vector<VariableId>& ids, const ScaleChart& b) const;
  Eigen::MatrixXd covariance(const std::vector<VariableId>& ids) const;

  // Adds a variable that is a copy of column `column` of K and the two after it: mean its value
  // there, K the identity, Sigma zero. eliminate() then takes those columns out.
  void deactivate(const Variable& variable, Eigen::Index column);

  // Marginalises the first columns of K, whose variables are R_ff d_f + R_fr d_r + r_f ~ N(0, I);
  // R = (R_ff R_fr), columns of K in the same order. Some columns of K first become combinations
  // of variables: d(columns) = T d. Though these are few, T may reach many variables that are
  // marginalised (a chain of noises), so every product here is kept as thin as they are few.
  void eliminate(const std::vector<int>& columns, const Eigen::MatrixXd& T,
                 const Eigen::MatrixXd& R, const Eigen::VectorXd& r);

  // The conditional U (d(x) - K d(b)) ~ N(0, I), about x0 := mean, of variables that become active
  // again, U upper triangular.
  struct Reactivated {
    Eigen::VectorXd mean;
    Eigen::MatrixXd K;
    Eigen::MatrixXd U;
  };
  // Takes `ids` out and conditions the others on them: they become the first columns of K. `b0` is
  // the chart there. Throws Diverged when their covariance is not positive definite.
  Reactivated reactivate(const std::vector<VariableId>& ids, const ScaleChart& b0);

  // Marginalises variables of the map, that is, removes them.
  void forget(const std::vector<VariableId>& ids);

  // Follows the prior that is about to be relinearised at b, the current estimate.
  void relinearise(const ScaleChart& b);
  // The same, and K gets `total` columns: those of each of the prior's variables from
  // Variable::column on, all others zero.
  void relinearise(const MarginalPrior& prior, int total);

  // The prior has so many more columns before all others, on which nothing here depends.
  void add_independent(Eigen::Index columns);

  // Conditions on b_i = 0 for a variable of the prior, and takes its columns out.
  void condition_on_zero(const MarginalPrior::Block& block);

 private:
  // Rows of a Gaussian, three for a variable; vacant ones are zero everywhere.
  struct Level {
    Eigen::VectorXd mean;
    Eigen::MatrixXd K;
    Eigen::MatrixXd Sigma;  // the lower triangle
    std::vector<int> vacant;

    int add(int rows);  // where they begin
    void clear(int row);
    Eigen::MatrixXd covariance(const std::vector<int>& rows, const std::vector<int>& columns) const;
  };
  struct Place {
    bool is_far = false;
    int row = 0;  // the first
    ScaleOrbit orbit;
    Eigen::Vector3d n0 = Eigen::Vector3d::Zero();  // n(x0)
    double scale = 0.0;                            // scale_ then
  };

  // x of z; M = dx/dz, and dx/dgamma.
  struct Grown {
    Eigen::Vector3d x;
    Eigen::Matrix3d M;
    Eigen::Vector3d of_scale;
  };
  Eigen::Vector3d grow(const Place& place, const Eigen::Vector3d& z, double lambda) const;
  Grown grown(const Place& place, const Eigen::Vector3d& z, double lambda) const;
  Eigen::Vector3d z_of(const Place& place, const Eigen::VectorXd& d) const;
  void turn(const std::vector<VariableId>& ids, Eigen::MatrixXd& P) const;

  std::vector<int> rows(const std::vector<VariableId>& ids, bool is_far) const;
  void forget_rows(const std::vector<VariableId>& ids);
  static std::vector<int> indices(Eigen::Index count);  // 0 .. count - 1
  // conditional_map_levels.cpp
  void fold();
  void start_stem();
  void lift(const std::vector<VariableId>& ids);
  void subtract_pending();

  bool keeps_scale_ = false;
  std::map<VariableId, Place> places_;
  double scale_ = 0.0;       // log of the scale of b0 over that at the beginning
  Level near_, far_;         // K of near over the prior's variables, of far over the stem
  std::vector<int> stem_;    // rows of near, by column of far_.K
  Eigen::MatrixXd pending_;  // far_.Sigma is less than it says by this times its transpose
  int pending_cols_ = 0;
};

}  // namespace slammot
