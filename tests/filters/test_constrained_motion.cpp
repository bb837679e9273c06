// A static landmark's motion that is remembered (filters/covariance/constrained_motion.cpp).
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "tests/estimators/fixture/linearisation_fixture.h"
#include "tests/filters/small_scene.h"

namespace slammot {
namespace {

using test::relative_difference;

constexpr int kTrack = 7;
constexpr StateBlock kAnchor{12, 3}, kY{15, 3}, kW{18, 3};
constexpr int kDim = 21;

// A camera, an anchor and a free landmark, of any covariance.
JointState any_state() {
  JointState state;
  std::srand(1);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(kDim, kDim);
  state.covariance = joint_of(A * A.transpose() + Eigen::MatrixXd::Identity(kDim, kDim));
  state.anchors[0] = {Eigen::Vector3d::Zero(), kAnchor, 1};
  FilterLandmark& landmark = state.landmarks[kTrack];
  landmark.y = Eigen::Vector3d(0.1, 0.2, 0.3);
  landmark.w = Eigen::Vector3d(0.5, -0.4, 0.3);
  landmark.y_block = kY;
  landmark.w_block = kW;
  return state;
}

// Where w = 0 is used: y + F w is what H sees in place of y, F of all the time since then. The
// rotation's tangent space does not turn here, so that all is linear.
void measure(JointState& state, const Eigen::MatrixXd& H, const Eigen::Matrix3d& F,
             const Eigen::VectorXd& nu) {
  Eigen::MatrixXd P_Ht = state.covariance.dense() * H.transpose();
  if (state.landmarks.at(kTrack).is_constrained()) {
    P_Ht.middleRows<3>(kW.offset) += (H.middleCols<3>(kY.offset) * F).transpose();
  }
  const Eigen::LLT<Eigen::MatrixXd> S(H * P_Ht + Eigen::MatrixXd::Identity(H.rows(), H.rows()));
  Eigen::MatrixXd W = P_Ht;
  S.matrixU().solveInPlace<Eigen::OnTheRight>(W);
  state.covariance.subtract_outer(W);
  state.move(P_Ht * S.solve(nu));
}

// A step of the time, in which a free landmark moves with w; `F` is dy/dw.
void predict(JointState& state, const Eigen::Matrix3d& F) {
  FilterLandmark& landmark = state.landmarks.at(kTrack);
  if (landmark.is_constrained()) return;
  landmark.y += F * landmark.w;
  Matrix6d of_landmark = Matrix6d::Identity();
  of_landmark.topRightCorner<3, 3>() = F;
  state.covariance.propagate({landmark.y_block, landmark.w_block}, of_landmark, Matrix6d::Zero());
}

void constrain(JointState& state) {
  const Eigen::MatrixXd P = state.covariance.dense();
  const Eigen::Matrix3d J = P.block<3, 3>(kW.offset, kW.offset).inverse();
  const Eigen::MatrixXd P_w = P.middleCols<3>(kW.offset);
  const Eigen::Vector3d w = state.landmarks.at(kTrack).w;
  Eigen::VectorXd dx = -P_w * J * w;
  dx.segment<3>(kW.offset).setZero();
  state.covariance = joint_of(P - P_w * J * P_w.transpose());
  state.constrain_motion(kTrack, P_w * J, J, J * w);
  state.move(dx);
}

// A state that was constrained before three steps and measurements, and one that was not.
struct Both {
  JointState free = any_state(), constrained = any_state();
  Eigen::Matrix3d F = Eigen::Matrix3d::Zero();  // of the whole time

  Both() {
    Eigen::MatrixXd H = Eigen::MatrixXd::Random(4, kDim);
    H.rightCols<3>().setZero();  // no pixel sees w
    H.middleCols<3>(kRotation).setZero();
    H.middleCols<3>(kAngularVelocity).setZero();
    constrain(constrained);
    for (int k = 0; k < 3; ++k) {
      const Eigen::VectorXd z = Eigen::VectorXd::Random(4);
      const auto innovation = [&](const JointState& state) -> Eigen::VectorXd {
        Eigen::VectorXd x = Eigen::VectorXd::Zero(kDim);
        x.segment<3>(kPosition) = state.camera.position;
        x.segment<3>(kVelocity) = state.camera.velocity;
        x.segment<3>(kAnchor.offset) = state.anchors.at(0).position;
        x.segment<3>(kY.offset) = state.landmarks.at(kTrack).y;
        return z - H * x;
      };
      const Eigen::Matrix3d step = Eigen::Matrix3d::Random();
      F += step;
      for (JointState* state : {&free, &constrained}) {
        predict(*state, step);
        measure(*state, H, F, innovation(*state));
      }
    }
  }
};

void expect_same(const JointState& a, const JointState& b) {
  EXPECT_LT((a.covariance.dense() - b.covariance.dense()).norm(), 1e-10);
  EXPECT_LT((a.landmarks.at(kTrack).y - b.landmarks.at(kTrack).y).norm(), 1e-10);
  EXPECT_LT((a.camera.position - b.camera.position).norm(), 1e-10);
  EXPECT_LT((a.camera.velocity - b.camera.velocity).norm(), 1e-10);
}

TEST(ConstrainedMotion, ReleasedAfterStepsAndMeasurementsIsAsIfNeverConstrained) {
  auto [free, constrained, F] = Both();
  EXPECT_FALSE(constrained.landmarks.at(kTrack).is_free());
  EXPECT_GT((constrained.covariance.dense() - free.covariance.dense()).norm(), 1.0);
  const std::vector<JointState::Released> released{{kTrack, F}};
  constrained.move(constrained.release_motions(released));
  EXPECT_LT((constrained.covariance.block(kW, kW) - free.covariance.block(kW, kW)).norm(), 1e-10);
  EXPECT_TRUE(constrained.landmarks.at(kTrack).is_free());
  EXPECT_LT((constrained.landmarks.at(kTrack).w - free.landmarks.at(kTrack).w).norm(), 1e-10);
  expect_same(constrained, free);
}

// It does not matter when w = 0 is used: y of a landmark at rest is the same at all times.
TEST(ConstrainedMotion, IsAsIfConstrainedOnlyInTheEnd) {
  auto [free, constrained, F] = Both();
  constrain(free);
  constrained.covariance.add(kY, kW, F);  // y's sensitivity at the end, not that at rest
  expect_same(constrained, free);
  EXPECT_LT((constrained.landmarks.at(kTrack).information_vector -
             free.landmarks.at(kTrack).information_vector)
                .norm(),
            1e-10);
}

TEST(ConstrainedMotion, ForgottenLeavesTheRestAsItIs) {
  JointState state = any_state();
  constrain(state);
  const Eigen::MatrixXd before = state.covariance.dense().topLeftCorner(kW.offset, kW.offset);
  state.forget_motion(kTrack);
  EXPECT_EQ(state.covariance.size(), kW.offset);
  EXPECT_EQ(state.covariance.dense(), before);
  EXPECT_FALSE(state.landmarks.at(kTrack).is_constrained());
}

// Five frames of `circle` with Jacobians at the truth, so that covariances depend on nothing else.
// Everything rests; of three landmarks w is free, or was constrained at their birth.
class EkfWithMemory : public testing::Test {
 protected:
  EkfWithMemory() {
    Configuration configuration;
    configuration.ekf = options_;
    setup_ = make_setup(sequence_, configuration);
    setup_.prior.acceleration = setup_.prior.jerk = 0.0;
    for (const Observation& z : sequence_.frames[0].observations) {
      records_[z.track].label = Label::kStatic;
      if (kept_.size() < 3) kept_.push_back(z.track);
    }
  }

  Ekf run(bool is_constrained) const {
    Ekf ekf(setup_, models_, options_);
    NoStages stages;
    ekf.predict(sequence_.frames[0], 0.0, setup_.camera_noise, records_);
    for (const Observation& z : sequence_.frames[0].observations) {
      EXPECT_TRUE(ekf.add(first_pixel(z, setup_.prior), setup_.prior,
                          std::ranges::count(kept_, z.track) > 0));
    }
    if (is_constrained) ekf.collapse(kept_);
    ekf.finish();
    for (std::size_t k = 1; k < 6; ++k) {
      const Frame& frame = sequence_.frames[k];
      const double dt = frame.timestamp - sequence_.frames[k - 1].timestamp;
      ekf.predict(frame, dt, setup_.camera_noise, records_);
      std::vector<Observation> measured;
      for (const Observation& z : frame.observations) {
        if (records_.contains(z.track)) measured.push_back(z);
      }
      FrameInnovation innovation;
      ekf.innovations(measured, innovation);
      ekf.update(innovation.z, {}, stages);
    }
    return ekf;
  }

  const Sequence sequence_ = simulate("circle", {{"moving", "0"}}, 3);
  const EkfOptions options_{.linearisation = FilterLinearisation::kIdeal};
  const ModelOptions models_ = [] {
    ModelOptions models;
    models.gauge = Gauge::kNone;
    return models;
  }();
  slammot::Setup setup_;
  TrackRecords records_;
  std::vector<int> kept_;
};

TEST_F(EkfWithMemory, ReleasedIsAnEkfThatNeverUsedRest) {
  Ekf constrained = run(true), free = run(false);
  RememberedMotions held;
  std::vector<MotionBelief> motions;
  constrained.constrained_motions(kept_, held);
  free.motions(kept_, motions);
  ASSERT_EQ(held.size(), 3u);
  const auto& functions = find_landmark(models_.landmark, models_.point);
  for (std::size_t i = 0; i < 3; ++i) {
    // The others rest here and may move there: more is known.
    const auto motion = held.motion(i, functions);
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->track, motions[i].track);
    EXPECT_GT((motions[i].covariance - motion->covariance).diagonal().minCoeff(), 0.0);
  }
  // Once the others may move it is the marginal of the filter in which they do.
  EXPECT_TRUE(held.release(0));
  EXPECT_TRUE(held.release(1));
  EXPECT_FALSE(held.motion(0, functions));
  const auto last = held.motion(2, functions);
  ASSERT_TRUE(last);
  EXPECT_LT(relative_difference(last->covariance, motions[2].covariance), 1e-8);
  // Its innovations were taken at other estimates.
  EXPECT_LT((last->w - motions[2].w).norm(), 0.1 * std::sqrt(motions[2].covariance.trace()));
  constrained.release(kept_, records_);
  EXPECT_LT(
      relative_difference(constrained.state().covariance.dense(), free.state().covariance.dense()),
      1e-8);
  for (const int track : kept_) EXPECT_TRUE(constrained.state().landmarks.at(track).is_free());
}

}  // namespace
}  // namespace slammot
