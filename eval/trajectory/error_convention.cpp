#include "eval/trajectory/error_convention.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <utility>

#include "models/so3.h"

namespace slammot {
namespace {

template <typename Value>
using Words = std::span<const std::pair<const char*, Value>>;

using Convention = ErrorConvention;
constexpr std::pair<const char*, Convention::Order> kOrders[] = {
    {"position-first", Convention::Order::kPositionFirst},
    {"rotation-first", Convention::Order::kRotationFirst}};
constexpr std::pair<const char*, Convention::Rotation> kRotations[] = {
    {"right", Convention::Rotation::kRight}, {"left", Convention::Rotation::kLeft}};
constexpr std::pair<const char*, Convention::Position> kPositions[] = {
    {"global", Convention::Position::kGlobal},
    {"local", Convention::Position::kLocal},
    {"spatial", Convention::Position::kSpatial}};

template <typename Value>
Value value_of_word(const std::string& word, Words<Value> words) {
  std::string known;
  for (const auto& [name, value] : words) {
    if (word == name) return value;
    known += known.empty() ? name : std::string(", ") + name;
  }
  throw std::invalid_argument("'" + word + "' in the error convention is none of " + known);
}

bool contradicts(const Convention& convention) {
  return convention.position == Convention::Position::kSpatial &&
         convention.rotation == Convention::Rotation::kRight;
}

}  // namespace

ErrorConvention parse_error_convention(const std::string& text) {
  const size_t first = text.find(','), second = text.find(',', first + 1);
  if (std::ranges::count(text, ',') != 2) {
    throw std::invalid_argument("the error convention '" + text +
                                "' is not of the form ORDER,ROTATION,POSITION");
  }
  const Convention convention{
      value_of_word(text.substr(0, first), Words<Convention::Order>(kOrders)),
      value_of_word(text.substr(first + 1, second - first - 1),
                    Words<Convention::Rotation>(kRotations)),
      value_of_word(text.substr(second + 1), Words<Convention::Position>(kPositions))};
  if (contradicts(convention)) {
    throw std::invalid_argument("a spatial position error goes with a left rotation error");
  }
  return convention;
}

std::vector<ErrorConvention> error_conventions() {
  std::vector<ErrorConvention> all;
  for (const auto& [order_word, order] : kOrders) {
    for (const auto& [rotation_word, rotation] : kRotations) {
      for (const auto& [position_word, position] : kPositions) {
        const ErrorConvention convention{order, rotation, position};
        if (!contradicts(convention)) all.push_back(convention);
      }
    }
  }
  return all;
}

std::string to_string(const ErrorConvention& convention) {
  const auto word = [](const auto& words, auto value) {
    return std::string(
        std::ranges::find(words, value, [](const auto& w) { return w.second; })->first);
  };
  return word(kOrders, convention.order) + ',' + word(kRotations, convention.rotation) + ',' +
         word(kPositions, convention.position);
}

Matrix6d to_our_error(const Matrix6d& P, const ErrorConvention& convention,
                      const CameraState& estimate) {
  if (convention == ErrorConvention{})
    return P;  // also of what is known in part, and NaN elsewhere
  const Eigen::Matrix3d R = estimate.orientation.toRotationMatrix();
  const bool rotation_first = convention.order == Convention::Order::kRotationFirst;
  const int position = rotation_first ? 3 : 0, rotation = rotation_first ? 0 : 3;
  Matrix6d J = Matrix6d::Zero();
  auto J_r_dr = J.block<3, 3>(kPosition, position);
  J_r_dr.setIdentity();
  if (convention.position == Convention::Position::kLocal) J_r_dr = R;
  if (convention.position == Convention::Position::kSpatial) {
    J.block<3, 3>(kPosition, rotation) = -hat<double>(estimate.position);
  }
  auto J_theta_theta = J.block<3, 3>(kRotation, rotation);
  J_theta_theta.setIdentity();
  if (convention.rotation == Convention::Rotation::kLeft) J_theta_theta = R.transpose();
  return J * P * J.transpose();
}

}  // namespace slammot
