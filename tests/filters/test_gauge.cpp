// What the EKF knows of scale and heading is not changed by an estimate that moves. Over whole
// runs: eval/self_check/test_scale_check.cpp, test_linearisation.cpp, eval/studies/scale.yaml,
// devices.yaml.
#include "filters/gauge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "models/points/inverse_depth.h"
#include "tests/filters/small_scene.h"

namespace slammot {
namespace {

// The state in a world that is turned by `turn` and `factor` times as large, as one vector in the
// order of P's rows; rotations as the turn from those of `x`, and what neither changes at zero.
Eigen::VectorXd in_other_world(const JointState& x, const LandmarkFunctions& model, double factor,
                               const Eigen::Vector3d& turn) {
  const Eigen::Quaterniond R = exp_so3(turn);
  const auto moved = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return factor * (R * p); };
  const auto turned = [&](const Eigen::Quaterniond& q) { return log_so3(q.conjugate() * R * q); };
  Eigen::VectorXd result = Eigen::VectorXd::Zero(x.covariance.size());
  result.segment<3>(kPosition) = moved(x.camera.position);
  result.segment<3>(kRotation) = turned(x.camera.orientation);
  result.segment<3>(kVelocity) = moved(x.camera.velocity);
  if (x.scene) result(x.scene->block.offset) = x.scene->inverse_depth / factor;
  for (const FilterPose& c : x.clones) {
    result.segment<3>(c.block.offset) = moved(c.position);
    result.segment<3>(c.block.offset + kRotation) = turned(c.orientation);
  }
  for (const auto& [frame, a] : x.anchors) result.segment<3>(a.block.offset) = moved(a.position);
  for (const auto& [track, l] : x.landmarks) {
    const PointRay ray = model.point.ray(l.y);
    result.segment<3>(l.y_block.offset) =
        model.point.of(R * ray.direction, ray.inverse_depth / factor, l.y);
    if (!l.is_free()) continue;
    const Eigen::Vector3d velocity = moved(model.velocity(l.x()));
    const Eigen::Vector3d y = result.segment<3>(l.y_block.offset);
    result.segment<3>(l.w_block.offset) = model.motion_of(y, velocity).head<3>();
    if (model.motion > 3) {  // an acceleration in metres
      result.segment<3>(l.w_block.offset + 3) = moved(l.w.tail<3>());
    }
  }
  return result;
}

// N by differences.
Eigen::MatrixXd directions(const JointState& x, const LandmarkFunctions& model, Gauge gauge) {
  constexpr double kStep = 1e-5;
  const auto difference = [&](double step, const Eigen::Vector3d& turn) -> Eigen::VectorXd {
    return (in_other_world(x, model, std::exp(step), turn) -
            in_other_world(x, model, std::exp(-step), -turn)) /
           (2.0 * kStep);
  };
  if (gauge == Gauge::kScale) return difference(kStep, Eigen::Vector3d::Zero());
  Eigen::MatrixXd N(x.covariance.size(), 3);
  for (int k = 0; k < 3; ++k) N.col(k) = difference(0.0, kStep * Eigen::Vector3d::Unit(k));
  return N;
}

// L by its definition, of the scale: of the speed and the static landmarks used since `oldest`.
Eigen::MatrixXd weights(const JointState& x, const LandmarkFunctions& model, Gauge gauge,
                        int oldest = -1000) {
  const Eigen::MatrixXd P = x.covariance.dense();
  if (gauge == Gauge::kHeading) {
    Eigen::MatrixXd L = Eigen::MatrixXd::Zero(P.rows(), 3);
    L.middleRows<3>(kRotation) = x.camera.orientation.toRotationMatrix().transpose();
    return L;
  }
  Eigen::VectorXd l = Eigen::VectorXd::Zero(P.rows());
  double sum = 1.0;
  for (const auto& [track, landmark] : x.landmarks) {
    if (landmark.is_free() || landmark.last_used < oldest) continue;
    const PointRay ray = model.point.ray(landmark.y);
    const int at = landmark.y_block.offset;
    const double variance =
        (ray.J_inverse_depth * P.block<3, 3>(at, at) * ray.J_inverse_depth.transpose()).value() /
        std::pow(ray.inverse_depth, 2);
    sum += 1.0 / variance;
    l.segment<3>(at) -= ray.J_inverse_depth.transpose() / (ray.inverse_depth * variance);
  }
  const Eigen::Vector3d v = x.camera.velocity;
  const double variance =
      v.dot(P.block<3, 3>(kVelocity, kVelocity) * v) / std::pow(v.squaredNorm(), 2);
  sum += 1.0 / variance;
  l.segment<3>(kVelocity) += v / (v.squaredNorm() * variance);
  return l / sum;
}

using Tested = std::tuple<Gauge, const char*, const char*>;

class GaugeOf : public testing::TestWithParam<Tested> {
 protected:
  const Gauge gauge_ = std::get<0>(GetParam());
  const LandmarkFunctions& model_ = find_landmark(std::get<1>(GetParam()), std::get<2>(GetParam()));
  Devices without_ = plain(model_), with_ = keeping(false);

  Devices keeping(bool any_known) const {
    Devices devices = plain(model_);
    devices.gauge.emplace(gauge_, model_, any_known);
    return devices;
  }

  // Static landmarks 0 and 3, movers 1 and 2, a scene and a clone, after three frames.
  JointState state() {
    JointState x = scene(2);
    for (auto& [track, l] : x.landmarks) {
      l.y = model_.point.of(direction(l.y.x(), l.y.y()), l.y.z(), Eigen::Vector3d::Zero());
    }
    x.camera.velocity = {0.8, -0.1, 0.3};
    x.scene = {0.2, x.covariance.append({}, Eigen::MatrixXd::Constant(1, 1, 0.01))};
    const Eigen::Vector3d of_scene = Eigen::Vector3d::UnitZ() * 1e-4;  // so that it is corrected
    x.covariance.add(x.scene->block, x.landmarks.at(0).y_block, of_scene.transpose());
    x.clones.emplace_back().block = x.covariance.append({}, Matrix6d::Zero());
    for (const int track : {1, 2}) x.free_motion(track, MotionVector::Constant(model_.motion, 0.1));
    for (unsigned k = 1; k <= 3; ++k) {
      step(x, without_, pixels_of(x, model_.point, k));
      for (const int track : {1, 2}) move(x, track);
    }
    x.clone_pose(x.clones.front());
    return x;
  }

  // Predicted, so that w is correlated with y.
  void move(JointState& state, int track) const {
    FilterLandmark& l = state.landmarks.at(track);
    const LandmarkMatrix F = model_.predict_jacobian(l.x(), 0.1);
    const LandmarkVector x = model_.predict(l.x(), 0.1);
    l.y = x.head<3>();
    l.w = x.tail(model_.motion);
    state.covariance.propagate({l.y_block, l.w_block}, F, LandmarkMatrix::Zero(F.rows(), F.cols()));
  }

  JointState updated(const JointState& before, Devices& devices) const {
    JointState x = before;
    Innovation z;
    linearise(x, devices, pinhole(), pixels_of(before, model_.point, 9), z);
    update(x, devices, pinhole(), 1.0, 1, z);
    return x;
  }

  // Without the coordinates of rotations at the new estimate: N has those of the heading.
  void undo_reset(const JointState& before, JointState& plain) const {
    if (gauge_ == Gauge::kScale) return;
    const auto undo = [&](int offset, const Eigen::Quaterniond& from,
                          const Eigen::Quaterniond& to) {
      const Eigen::Matrix3d J = right_jacobian_so3(log_so3(from.conjugate() * to));
      plain.covariance.transform({{offset + kRotation, 3}}, J.inverse().eval());
    };
    undo(0, before.camera.orientation, plain.camera.orientation);
    undo(before.clones.front().block.offset, before.clones.front().orientation,
         plain.clones.front().orientation);
  }

  // P of `plain`, got from `before` without the gauge, in the coordinates that keep it.
  Eigen::MatrixXd expected(const JointState& before, const JointState& plain,
                           const Eigen::MatrixXd& L) const {
    const Eigen::MatrixXd change =
        directions(plain, model_, gauge_) - directions(before, model_, gauge_);
    const Eigen::MatrixXd T =
        Eigen::MatrixXd::Identity(L.rows(), L.rows()) + change * L.transpose();
    return T * plain.covariance.dense() * T.transpose();
  }

  void expect_update(Devices& with, const JointState& before, int oldest) {
    const JointState here = updated(before, with);
    JointState plain = updated(before, without_);
    const Eigen::MatrixXd P = here.covariance.dense(), Q = plain.covariance.dense();
    EXPECT_EQ(boxminus(here.camera, plain.camera).norm(), 0.0);
    undo_reset(before, plain);
    JointState weighed = before;  // the weights are those of the covariance after the update
    weighed.covariance = plain.covariance;
    const Eigen::MatrixXd L = weights(weighed, model_, gauge_, oldest);
    EXPECT_LT((P - expected(before, plain, L)).norm(), 1e-7 * (P - Q).norm());
    EXPECT_GT((P - Q).norm(), 1e-4 * Q.norm());
  }
};

// Where landmarks are known those seen of late tell the scale: landmark 0 was used 100 frames
// before the others, then 101.
TEST_P(GaugeOf, AnUpdateOnlyMovesTheEstimateAlongIt) {
  Devices with_known = keeping(true);
  JointState before = state();
  for (auto& [track, l] : before.landmarks) l.last_used = track == 0 ? 50 : 150;
  expect_update(with_known, before, 50);
  before.landmarks.at(0).last_used = 49;
  expect_update(with_known, before, 50);
  expect_update(with_, before, 49);
}

// One after the other, so that the second sees what the first has left.
TEST_P(GaugeOf, AndSoDoUpdatesOfWhatIsConsidered) {
  JointState here = state();
  const Eigen::MatrixXd L = weights(here, model_, gauge_);
  const auto all = pixels_of(here, model_.point, 5);
  const std::vector<Observation> movers{all[1], all[2]};
  JointState wanted = here, never = here;
  Innovation memory;
  for (const Observation& z : movers) {
    JointState plain = wanted;
    update_considered(plain, without_, pinhole(), {&z, 1}, 1.0, memory);
    const Eigen::MatrixXd P = expected(wanted, plain, L);
    wanted = plain;
    wanted.covariance = joint_of(P);
  }
  update_considered(here, with_, pinhole(), movers, 1.0, memory);
  update_considered(never, without_, pinhole(), movers, 1.0, memory);
  const Eigen::MatrixXd P = here.covariance.dense(), Q = never.covariance.dense();
  EXPECT_LT((P - wanted.covariance.dense()).norm(), 1e-7 * (P - Q).norm());
  EXPECT_GT((P - Q).norm(), 1e-7 * Q.norm());
}

// w = 0 is used of a landmark: the errors of w are then those in a world of any scale or heading.
TEST_P(GaugeOf, RestIsRestInAnyWorld) {
  JointState here = state();
  const JointState before = here;
  const Eigen::MatrixXd L = weights(here, model_, gauge_);
  with_.gauge->collapse(here, std::vector{1, 2});
  JointState at_rest = before;
  for (const int track : {1, 2}) at_rest.landmarks.at(track).w.setZero();
  const Eigen::MatrixXd now = directions(at_rest, model_, gauge_);
  const Eigen::MatrixXd then = directions(before, model_, gauge_);
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(now.rows(), now.cols());
  for (const int track : {1, 2}) {
    const StateBlock w = before.landmarks.at(track).w_block;
    change.middleRows(w.offset, w.dim) = (now - then).middleRows(w.offset, w.dim);
    EXPECT_LT(now.middleRows(w.offset, w.dim).norm(), 1e-9);
  }
  const Eigen::MatrixXd T = Eigen::MatrixXd::Identity(L.rows(), L.rows()) + change * L.transpose();
  const Eigen::MatrixXd P = here.covariance.dense(), Q = before.covariance.dense();
  EXPECT_LT((P - T * Q * T.transpose()).norm(), 1e-9 * Q.norm());
}

const auto model_names = [](const testing::TestParamInfo<Tested>& tested) {
  return std::string(std::get<1>(tested.param)) + "_" + std::get<2>(tested.param);
};

INSTANTIATE_TEST_SUITE_P(
    Scale, GaugeOf,
    testing::Values(Tested{Gauge::kScale, "scaled_velocity", "inverse_depth"},
                    Tested{Gauge::kScale, "dynamic_inverse_depth", "inverse_depth"},
                    Tested{Gauge::kScale, "scaled_velocity", "homogeneous"},
                    Tested{Gauge::kScale, "dynamic_inverse_depth", "xyz"},
                    Tested{Gauge::kScale, "constant_acceleration", "inverse_depth"}),
    model_names);

const auto headings =
    testing::Values(Tested{Gauge::kHeading, "scaled_velocity", "inverse_depth"},
                    Tested{Gauge::kHeading, "dynamic_inverse_depth", "homogeneous"},
                    Tested{Gauge::kHeading, "constant_acceleration", "xyz"});
INSTANTIATE_TEST_SUITE_P(Heading, GaugeOf, headings, model_names);

// The weights of the scale depend on what is known of it; those of the heading do not.
class HeadingOf : public GaugeOf {};

// A doubt along N before is the same doubt along the new N afterwards, and changes nothing else.
TEST_P(HeadingOf, AnUpdateLearnsNothingAlongIt) {
  constexpr double kVariance = 0.01;
  const JointState before = state();
  JointState doubted = before;
  const Eigen::MatrixXd N = std::sqrt(kVariance) * directions(before, model_, gauge_).transpose();
  doubted.covariance.add_product(N, N);
  const auto difference = [&](Devices& devices) -> Eigen::MatrixXd {
    const JointState a = updated(before, devices), b = updated(doubted, devices);
    EXPECT_LT(boxminus(a.camera, b.camera).norm(), 1e-9);
    const Eigen::MatrixXd M = directions(a, model_, gauge_);
    return b.covariance.dense() - a.covariance.dense() - kVariance * M * M.transpose();
  };
  EXPECT_LT(difference(with_).norm(), 1e-8);
  EXPECT_GT(difference(without_).norm(), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Heading, HeadingOf, headings, model_names);

// At rest and where a depth is known exactly the weights are finite.
TEST(ScaleOfTheMap, IsFiniteWhereNothingMoves) {
  Devices with = plain(find_landmark("scaled_velocity", "inverse_depth"));
  with.gauge.emplace(Gauge::kScale, with.functions, false);
  JointState state = scene(1);
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(state.size(), 3);
  for (const StateBlock b : {state.landmarks.at(0).y_block, StateBlock{kVelocity, 3}}) {
    state.covariance.assign(b, none, Eigen::Matrix3d::Zero());
  }
  for (unsigned k = 1; k <= 3; ++k) step(state, with, pixels_of(state, with.point(), k));
  EXPECT_TRUE(state.covariance.dense().allFinite());
}

CameraEstimate last_of(const Sequence& sequence, Configuration configuration, bool keeps_scale) {
  configuration.model.gauge = keeps_scale ? Gauge::kScale : Gauge::kNone;
  const auto ekf =
      make_ekf(make_setup(sequence, configuration), configuration.model, configuration.ekf);
  NoStages stages;
  for (const Frame& frame : sequence.frames) ekf->process(frame, stages);
  return ekf->camera();
}

// Where Jacobians do not follow the estimate, or do so within an update.
TEST(ScaleOfTheMap, IsKeptWithOneIterationOfTheStandardLinearisationOnly) {
  const Sequence sequence = simulate("circle", {{"frames", "10"}}, 1);
  const std::pair<const char*, const char*> others[] = {
      {"ekf.linearisation", "fej"}, {"ekf.linearisation", "ideal"}, {"ekf.iterations", "3"}};
  const auto acts = [&](Configuration configuration) {
    assign(configuration, {"classifier", "truth"});
    return last_of(sequence, configuration, true).covariance !=
           last_of(sequence, configuration, false).covariance;
  };
  EXPECT_TRUE(acts({}));
  for (const auto& [key, value] : others) {
    Configuration configuration;
    assign(configuration, {key, value});
    EXPECT_FALSE(acts(configuration)) << value;
  }
}

}  // namespace
}  // namespace slammot
