// N of second order (second_order.h) of all measurements of a frame, from the joint covariance.
#include <algorithm>

#include "filters/second_order.h"
#include "filters/update.h"

namespace slammot {

namespace {

using Eigen::Index;

// Of the anchors of all matches, each once, less the camera's position: E[d_i d_j'].
void fill_P_d(const JointState& state, Innovation& innovation) {
  const StateBlock r{kPosition, 3};
  const JointCovariance& P = state.covariance;
  innovation.places.clear();
  innovation.place_of.clear();
  for (const Observation& match : innovation.matches) {
    const StateBlock anchor = state.anchors.at(state.landmarks.at(match.track).anchor).block;
    auto place = std::ranges::find(innovation.places, anchor.offset, &StateBlock::offset);
    if (place == innovation.places.end()) place = innovation.places.insert(place, anchor);
    innovation.place_of.push_back(place - innovation.places.begin());
  }
  const Index count = std::ssize(innovation.places);
  innovation.P_d.resize(3 * count, 3 * count);
  auto P_d = *innovation.P_d;
  const Eigen::Matrix3d P_r = P.block(r, r);
  for (Index i = 0; i < count; ++i) {
    const StateBlock a = innovation.places[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d P_ar = P.block(a, r);
    for (Index j = 0; j < count; ++j) {
      if (i != j && !innovation.has_common_second_order) continue;
      const StateBlock b = innovation.places[static_cast<std::size_t>(j)];
      P_d.block<3, 3>(3 * i, 3 * j) = P.block(a, b) - P_ar - P.block(r, b) + P_r;
    }
  }
}

// Of the rows of P_rho at the anchor of match i less those at the camera: E[d_i e_j].
Eigen::Vector3d moment(const Innovation& innovation, std::size_t i, std::size_t j) {
  const auto at = innovation.places[static_cast<std::size_t>(innovation.place_of[i])].offset;
  const auto column = (*innovation.P_rho).col(static_cast<Index>(j));
  return column.segment<3>(at) - column.segment<3>(kPosition);
}

}  // namespace

void fill_P_rho(const JointState& state, const Devices& devices, Innovation& innovation) {
  const bool has_any = devices.second_order != SecondOrder::kNone;
  const JointCovariance& P = state.covariance;
  innovation.has_common_second_order = devices.second_order == SecondOrder::kCommon;
  innovation.products.assign(innovation.matches.size(), {});
  innovation.P_rho.resize(P.size(), has_any ? std::ssize(innovation.matches) : 0);
  if (!has_any) return;
  innovation.columns.resize(P.size(), 3);
  auto P_rho = *innovation.P_rho;
  for (std::size_t i = 0; i < innovation.matches.size(); ++i) {
    const FilterLandmark& landmark = state.landmarks.at(innovation.matches[i].track);
    const auto column = static_cast<Index>(i);
    P_rho.col(column).setZero();
    if (landmark.is_free()) continue;
    innovation.products[i] = {devices.point().inverse_depth_jacobian(landmark.y),
                              innovation.predicted[i].J_world};
    if (innovation.is_again(i)) {
      P_rho.col(column) = P_rho.col(column - 1);  // of another camera
      continue;
    }
    P.columns(landmark.y_block, *innovation.columns);
    P_rho.col(column).noalias() = *innovation.columns * innovation.products[i].rho.transpose();
  }
}

void add_second_order(const JointState& state, Innovation& innovation, GrowingMatrix& result) {
  if (innovation.P_rho.cols() == 0) return;
  fill_P_d(state, innovation);
  const auto P_d = *innovation.P_d;
  auto S = *result;
  ProductMoments m;
  for (std::size_t i = 0; i < innovation.matches.size(); ++i) {
    if (innovation.products[i].rho.isZero(0.0)) continue;
    const int y = state.landmarks.at(innovation.matches[i].track).y_block.offset;
    for (std::size_t j = innovation.has_common_second_order ? 0 : i; j <= i; ++j) {
      if (innovation.products[j].rho.isZero(0.0)) continue;
      m.e_e = innovation.products[i].rho.dot(
          (*innovation.P_rho).col(static_cast<Index>(j)).segment<3>(y));
      m.d_d = P_d.block<3, 3>(3 * innovation.place_of[i], 3 * innovation.place_of[j]);
      m.d_e = moment(innovation, i, j);
      m.e_d = moment(innovation, j, i);
      S.block<2, 2>(static_cast<Index>(2 * i), static_cast<Index>(2 * j)) +=
          second_order_noise(innovation.products[i].pixel, innovation.products[j].pixel, m);
    }
  }
}

}  // namespace slammot
