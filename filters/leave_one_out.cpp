#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "filters/update.h"
#include "models/lapack.h"

namespace slammot {

namespace {

// a' B^-1 a with B = X' X: two columns, or of a rig more.
double squared_by(const Eigen::Ref<const Eigen::MatrixXd>& X,
                  const Eigen::Ref<const Eigen::VectorXd>& a) {
  if (a.size() > 2) return a.dot((X.transpose() * X).llt().solve(a));
  const Eigen::Matrix2d B = X.leftCols<2>().transpose().lazyProduct(X.leftCols<2>());
  const Eigen::Vector2d a_i = a;
  return a_i.dot(B.inverse() * a_i);
}

}  // namespace

void nis_given_others(Innovation& innovation, std::vector<LeaveOneOut>& result) {
  result.clear();
  if (innovation.rows() == 0) return;
  const auto L = *innovation.S;
  innovation.L_inverse.resize(L.rows(), L.rows());
  auto L_inverse = *innovation.L_inverse;
  L_inverse = L.triangularView<Eigen::Lower>();
  invert_lower_in_place(L_inverse);
  auto a = (*innovation.r).col(0);  // L^-1 r
  L.triangularView<Eigen::Lower>().transpose().solveInPlace(a);
  for (const LandmarkRows& l : innovation.landmarks) {
    const auto X = L_inverse.block(l.first, l.first, L.rows() - l.first, l.count);
    const double nis = squared_by(X, a.segment(l.first, l.count)) + l.noise_nis;
    result.push_back({l.track, nis, l.pixels});
  }
}

}  // namespace slammot
