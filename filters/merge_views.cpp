#include <Eigen/QR>
#include <cmath>

#include "filters/update.h"

namespace slammot {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// T of a landmark's rows, T' T = R^-1, and the rows of T that are nothing but noise, the last.
struct Merge {
  MatrixXd T;
  Index noise = 0;
};

Merge merge_of(const Innovation& innovation, const LandmarkRows& l, double pixel_sigma) {
  constexpr double kNone = 1e-9;  // of what a row knows of the camera, relative
  const auto at = static_cast<std::size_t>(l.first / 2);
  MatrixXd J_y(l.count, 3), J_others(l.count, 9);
  Merge merge{MatrixXd::Zero(l.count, l.count)};
  for (int k = 0; k < l.pixels; ++k) {
    const std::size_t i = at + static_cast<std::size_t>(k);
    const ObservedPixel& h = innovation.predicted[i];
    const double weight = 1.0 / std::sqrt(innovation.matches[i].variance(pixel_sigma));
    J_y.middleRows<2>(2 * k) = weight * h.J_y;
    J_others.middleRows<2>(2 * k) << weight * h.J_pose, weight * h.J_anchor;
    merge.T.diagonal().segment<2>(2 * k).setConstant(weight);
  }
  // J_pose and J_anchor have the column space of J_y, that of one point in C0, so that what is
  // orthogonal to J_y is noise; but not where J_y has no three directions.
  const Eigen::HouseholderQR<MatrixXd> qr(J_y);
  const MatrixXd Q = qr.householderQ();
  const MatrixXd left = Q.rightCols(l.count - 3).transpose() * J_others;
  if (left.norm() > kNone * J_others.norm()) return merge;
  merge.T = Q.transpose() * merge.T;
  merge.noise = l.count - 3;
  return merge;
}

}  // namespace

void merge_views(double pixel_sigma, Innovation& innovation) {
  auto P_Ht = *innovation.P_Ht, r = *innovation.r, S = *innovation.S;
  S.triangularView<Eigen::StrictlyUpper>() = S.transpose();
  Index rows = 0;
  for (LandmarkRows& l : innovation.landmarks) {
    const Index from = l.first, before = l.count;
    l.first = rows;
    MatrixXd T = MatrixXd::Identity(before, before);
    if (l.pixels > 1) {
      LandmarkRows as_it_was = l;
      as_it_was.first = from;
      const Merge merge = merge_of(innovation, as_it_was, pixel_sigma);
      T = merge.T;
      l.noise_nis = (T.bottomRows(merge.noise) * r.middleRows(from, before)).squaredNorm();
      l.count -= merge.noise;
      T.conservativeResize(l.count, before);
    }
    const auto move = [&](auto x, Index width) {
      x.middleCols(rows, width) = (x.middleCols(from, before) * T.transpose()).eval();
    };
    move(P_Ht, l.count);
    move(S, l.count);
    r.middleRows(rows, l.count) = (T * r.middleRows(from, before)).eval();
    S.middleRows(rows, l.count) = (T * S.middleRows(from, before)).eval();
    rows += l.count;
  }
  innovation.P_Ht.keep_columns(rows);
  innovation.merged.resize(rows, rows);
  *innovation.merged = S.topLeftCorner(rows, rows);
  innovation.S.swap(innovation.merged);
  innovation.merged.resize(rows, 1);
  *innovation.merged = r.topRows(rows);
  innovation.r.swap(innovation.merged);
}

}  // namespace slammot
