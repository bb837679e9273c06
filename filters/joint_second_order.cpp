// N of second order (second_order.h) of all measurements of a frame, from the joint covariance.
#include <algorithm>

#include "filters/second_order.h"
#include "filters/update.h"

namespace slammot {

namespace {

using Eigen::Index;

// Of the anchors of all matches, each once, less the camera's position: E[d_i d_j'].
void fill_P_d(const JointState& state, Innovation& z) {
  const StateBlock r{kPosition, 3};
  const JointCovariance& P = state.covariance;
  z.places.clear();
  z.place_of.clear();
  for (const Observation& match : z.matches) {
    const StateBlock anchor = state.anchors.at(state.landmarks.at(match.track).anchor).block;
    auto place = std::ranges::find(z.places, anchor.offset, &StateBlock::offset);
    if (place == z.places.end()) place = z.places.insert(place, anchor);
    z.place_of.push_back(place - z.places.begin());
  }
  const Index count = std::ssize(z.places);
  z.P_d.resize(3 * count, 3 * count);
  auto P_d = *z.P_d;
  const Eigen::Matrix3d P_r = P.block(r, r);
  for (Index i = 0; i < count; ++i) {
    const StateBlock a = z.places[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d P_ar = P.block(a, r);
    for (Index j = 0; j < count; ++j) {
      if (i != j && !z.has_common_second_order) continue;
      const StateBlock b = z.places[static_cast<std::size_t>(j)];
      P_d.block<3, 3>(3 * i, 3 * j) = P.block(a, b) - P_ar - P.block(r, b) + P_r;
    }
  }
}

// Of the rows of P_rho at the anchor of match i less those at the camera: E[d_i e_j].
Eigen::Vector3d moment(const Innovation& z, std::size_t i, std::size_t j) {
  const auto at = z.places[static_cast<std::size_t>(z.place_of[i])].offset;
  const auto column = (*z.P_rho).col(static_cast<Index>(j));
  return column.segment<3>(at) - column.segment<3>(kPosition);
}

}  // namespace

void fill_P_rho(const JointState& state, const Devices& devices, Innovation& z) {
  const bool has_any = devices.second_order != SecondOrder::kNone;
  const JointCovariance& P = state.covariance;
  z.has_common_second_order = devices.second_order == SecondOrder::kCommon;
  z.products.assign(z.matches.size(), {});
  z.P_rho.resize(P.size(), has_any ? std::ssize(z.matches) : 0);
  if (!has_any) return;
  z.columns.resize(P.size(), 3);
  auto P_rho = *z.P_rho;
  for (std::size_t i = 0; i < z.matches.size(); ++i) {
    const FilterLandmark& landmark = state.landmarks.at(z.matches[i].track);
    const auto column = static_cast<Index>(i);
    P_rho.col(column).setZero();
    if (landmark.is_free()) continue;
    z.products[i] = {devices.point().inverse_depth_jacobian(landmark.y), z.predicted[i].J_world};
    P.columns(landmark.y_block, *z.columns);
    P_rho.col(column).noalias() = *z.columns * z.products[i].rho.transpose();
  }
}

void add_second_order(const JointState& state, Innovation& z, GrowingMatrix& result) {
  if (z.P_rho.cols() == 0) return;
  fill_P_d(state, z);
  const auto P_d = *z.P_d;
  auto S = *result;
  ProductMoments m;
  for (std::size_t i = 0; i < z.matches.size(); ++i) {
    if (z.products[i].rho.isZero(0.0)) continue;
    const int y = state.landmarks.at(z.matches[i].track).y_block.offset;
    for (std::size_t j = z.has_common_second_order ? 0 : i; j <= i; ++j) {
      if (z.products[j].rho.isZero(0.0)) continue;
      m.e_e = z.products[i].rho.dot((*z.P_rho).col(static_cast<Index>(j)).segment<3>(y));
      m.d_d = P_d.block<3, 3>(3 * z.place_of[i], 3 * z.place_of[j]);
      m.d_e = moment(z, i, j);
      m.e_d = moment(z, j, i);
      S.block<2, 2>(static_cast<Index>(2 * i), static_cast<Index>(2 * j)) +=
          second_order_noise(z.products[i].pixel, z.products[j].pixel, m);
    }
  }
}

}  // namespace slammot
