#include "eval/trajectory/extrinsics.h"

#include "datasets/sequence/plausible.h"
#include "datasets/text/input_error.h"
#include "datasets/text/text_table.h"

namespace slammot {

Eigen::Isometry3d read_extrinsics(const std::filesystem::path& file) {
  const std::string text = read_text_file(file);
  TextTable row(file, text);
  if (!row.next_blank_row(7)) throw InputError(file, 0, "holds no row tx ty tz qx qy qz qw");
  const Eigen::Quaterniond q(row.real(6), row.real(3), row.real(4), row.real(5));
  row.refuse_if(quaternion_fault(q));
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = vector_at(row, 0);
  if (row.next_blank_row()) row.refuse("there is a second row");
  return T;
}

void to_camera(const Eigen::Isometry3d& T_body_camera, CameraEstimate& estimate) {
  const Eigen::Matrix3d R_world_body = estimate.state.orientation.toRotationMatrix();
  const Eigen::Vector3d t = T_body_camera.translation();
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = -R_world_body * hat<double>(t);
  J.bottomRightCorner<3, 3>() = T_body_camera.linear().transpose();
  auto P = estimate.covariance.topLeftCorner<6, 6>();
  P = (J * P * J.transpose()).eval();
  estimate.state.position += R_world_body * t;
  estimate.state.orientation =
      (estimate.state.orientation * Eigen::Quaterniond(T_body_camera.linear())).normalized();
}

}  // namespace slammot
