// The EKF's joint state: shared anchors, births and deaths, and the update against textbook
// formulas.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <random>

#include "filters/second_order.h"
#include "tests/filters/small_scene.h"

namespace slammot {
namespace {

Devices standard = plain(find_landmark("scaled_velocity", "inverse_depth"));

TEST(SharedAnchor, GivesTheSameEstimatesAsOneForEachLandmark) {
  JointState shared = scene(1), single = scene(4);
  shared.camera.velocity = single.camera.velocity = {1.0, 0.0, 0.2};
  EXPECT_EQ(shared.covariance.size() + 9, single.covariance.size());
  for (unsigned k = 1; k <= 20; ++k) {
    const auto matches = pixels_of(shared, standard.point(), k);
    step(shared, standard, matches);
    step(single, standard, matches);
  }
  const auto P = shared.covariance.block(JointState::kCamera, JointState::kCamera);
  const auto Q = single.covariance.block(JointState::kCamera, JointState::kCamera);
  EXPECT_LT((P - Q).norm(), 1e-11 * Q.norm());
  EXPECT_LT(boxminus(shared.camera, single.camera).norm(), 1e-11);
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT((shared.landmarks.at(i).y - single.landmarks.at(i).y).norm(), 1e-11);
    EXPECT_LT((shared.anchors.at(0).position - single.anchors.at(i).position).norm(), 1e-11);
  }
}

Eigen::MatrixXd dense_H(const JointState& state, const Innovation& z) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(z.rows(), state.covariance.size());
  for (std::size_t i = 0; i < z.matches.size(); ++i) {
    const FilterLandmark& l = state.landmarks.at(z.matches[i].track);
    auto rows = H.middleRows<2>(static_cast<Eigen::Index>(2 * i));
    rows.leftCols<6>() = z.predicted[i].J_pose;
    rows.middleCols<3>(state.anchors.at(l.anchor).block.offset) = z.predicted[i].J_anchor;
    rows.middleCols<3>(l.y_block.offset) = z.predicted[i].J_y;
  }
  return H;
}

Eigen::VectorXd stacked(const std::vector<Eigen::Vector2d>& nu) {
  return Eigen::Map<const Eigen::VectorXd>(nu.front().data(), 2 * std::ssize(nu));
}

// By its definition: the innovation of some rows beside its prediction from the others, over the
// covariance of that difference.
double nis_of_leave_out(const Eigen::MatrixXd& S, const Eigen::VectorXd& nu, Eigen::Index first,
                        Eigen::Index count) {
  std::vector<Eigen::Index> own, others;
  for (Eigen::Index k = 0; k < nu.size(); ++k) {
    (k >= first && k < first + count ? own : others).push_back(k);
  }
  const Eigen::MatrixXd G = S(own, others) * S(others, others).inverse();
  const Eigen::VectorXd left = nu(own) - G * nu(others);
  const Eigen::MatrixXd C = S(own, own) - G * S(others, own);
  return left.dot(C.llt().solve(left));
}

class Update : public testing::TestWithParam<int> {};  // cameras

// With two cameras its rows are merged (merge_views.cpp), which changes nothing.
TEST_P(Update, IsTheTextbookUpdate) {
  JointState state = scene(1);
  std::vector<Observation> matches;
  const Eigen::AngleAxisd turned(0.05, Eigen::Vector3d::UnitY());
  std::vector<MountedCamera> others;
  for (int camera = 1; camera < GetParam(); ++camera) {
    others.emplace_back(pinhole(), Eigen::Quaterniond(turned),
                        Eigen::Vector3d(0.3 * camera, 0.02, 0.01));
  }
  const Rig rig(pinhole(), others);
  for (const Observation& z : pixels_of(state, standard.point(), 1)) {
    for (int camera = 0; camera < GetParam(); ++camera) {
      if (camera == 1 && z.track == 2) continue;  // seen by one only
      matches.push_back({z.track, z.pixel - camera * Eigen::Vector2d(10.0, -1.0), 1.0, camera});
      matches.back().relative_sigma = 0.5 + 0.5 * static_cast<double>(matches.size());
    }
  }
  Innovation z;
  linearise(state, standard, rig, matches, z);
  const int n = state.covariance.size();
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd P = state.covariance.dense();
  const bool is_mixed = GetParam() == 4;  // linearised elsewhere for one camera: not to be merged
  if (is_mixed) {
    const Eigen::Matrix<double, 2, 6> more = Eigen::Matrix<double, 2, 6>::Constant(3.0);
    z.predicted[1].J_pose += more;
    (*z.P_Ht).middleCols<2>(2) += P.leftCols<6>() * more.transpose();
  }
  const Eigen::MatrixXd H = dense_H(state, z);
  EXPECT_LT((*z.P_Ht - P * H.transpose()).norm(), 1e-12 * (*z.P_Ht).norm());
  constexpr double kPixelSigma = 1.2;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(z.rows(), z.rows());
  for (Eigen::Index i = 0; i < z.rows(); ++i) {
    R(i, i) = matches[static_cast<std::size_t>(i / 2)].variance(kPixelSigma);
  }
  const Eigen::MatrixXd S = H * P * H.transpose() + R;
  const Eigen::MatrixXd K = P * H.transpose() * S.inverse();
  Eigen::MatrixXd Joseph = (I - K * H) * P * (I - K * H).transpose() + K * R * K.transpose();
  const Eigen::VectorXd nu = stacked(z.nu), dx = K * nu;
  Eigen::MatrixXd reset = I;
  reset.block<3, 3>(3, 3) = right_jacobian_so3(dx.segment<3>(3));
  Joseph = (reset * Joseph * reset.transpose()).eval();
  const CameraState expected = boxplus(state.camera, Vector12d(dx.head<12>()));
  update(state, standard, rig, kPixelSigma, 1, z);
  EXPECT_LT((state.covariance.dense() - Joseph).norm(), 1e-10 * Joseph.norm());
  EXPECT_LT(boxminus(state.camera, expected).norm(), 1e-12);
  constexpr int kColumns[] = {0, 8, 3 * 3 + 2, 4 * 3, 3 * 3 + 8};
  EXPECT_EQ((*z.P_Ht).cols(), kColumns[GetParam()]);
  std::vector<LeaveOneOut> nis;
  nis_given_others(z, nis);
  ASSERT_EQ(nis.size(), 4);
  Eigen::Index row = 0;
  for (const LeaveOneOut& l : nis) {
    const double expected_nis = nis_of_leave_out(S, nu, row, 2 * l.pixels);
    EXPECT_NEAR(l.nis, expected_nis, 1e-8 * expected_nis) << l.track;
    row += 2 * l.pixels;
  }
}

INSTANTIATE_TEST_SUITE_P(Cameras, Update, testing::Values(1, 2, 3, 4));

// Pictures show the S that the gate asks.
TEST(SecondOrder, IsInTheCovarianceOfStaticLandmarksOnly) {
  Devices second = standard;
  second.second_order = SecondOrder::kOwn;
  JointState state = scene(1);
  state.free_motion(3, MotionVector::Constant(3, 0.5));
  step(state, standard, pixels_of(state, standard.point(), 1));
  Innovation z;
  linearise(state, second, pinhole(), pixels_of(state, standard.point(), 2), z);
  ASSERT_EQ(z.matches.size(), 4u);
  GrowingMatrix HPHt;
  fill_HPHt(state, z, HPHt);
  for (int i = 0; i < 4; ++i) {
    const bool is_static = i < 3;
    EXPECT_EQ(z.products[static_cast<std::size_t>(i)].rho.norm() > 0.0, is_static);
    const Eigen::Matrix2d S = (*HPHt).block<2, 2>(2 * i, 2 * i).selfadjointView<Eigen::Lower>();
    const auto shown = predict_pixel(state, second, pinhole(), i);
    const auto without = predict_pixel(state, standard, pinhole(), i);
    ASSERT_TRUE(shown && without);
    EXPECT_LT((shown->S - S).norm(), 1e-12 * S.norm());
    EXPECT_EQ((shown->S - without->S).norm() > 0.0, is_static);
  }
}

// A camera that has moved, two anchors that are not known alike, a free landmark; the first of the
// matches has been dropped.
struct SecondOrderScene {
  explicit SecondOrderScene(bool has_known) {
    Devices first = devices;
    devices.second_order = has_known ? SecondOrder::kCommon : SecondOrder::kOwn;
    state.camera.velocity = {1.0, 0.0, 0.2};  // at rest no depth is measured
    state.covariance.propagate({state.anchors.at(1).block}, Eigen::Matrix3d::Identity(),
                               1e-3 * Eigen::Matrix3d::Identity());
    state.free_motion(2, MotionVector::Constant(3, 0.5));
    step(state, first, pixels_of(state, model.point, 1));
    linearise(state, devices, pinhole(), pixels_of(state, model.point, 2), z);
    const std::vector<Observation> kept(z.matches.begin() + 1, z.matches.end());
    keep(kept, z);
    fill_HPHt(state, z, result);
  }

  // Of the state's error: e, and d below it.
  Eigen::MatrixXd errors_of(std::size_t i) const {
    const FilterLandmark& l = state.landmarks.at(z.matches[i].track);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(4, state.covariance.size());
    rows.block<1, 3>(0, l.y_block.offset) = model.point.inverse_depth_jacobian(l.y);
    rows.block<3, 3>(1, state.anchors.at(l.anchor).block.offset).setIdentity();
    rows.block<3, 3>(1, kPosition) -= Eigen::Matrix3d::Identity();
    return rows;
  }

  Eigen::Matrix2d N(std::size_t i, std::size_t j) const {
    const Eigen::MatrixXd P = state.covariance.dense();
    const Eigen::Matrix4d both = errors_of(i) * P * errors_of(j).transpose();
    const ProductMoments moments{both(0, 0), both.bottomRightCorner<3, 3>(),
                                 both.bottomLeftCorner<3, 1>(),
                                 both.topRightCorner<1, 3>().transpose()};
    return second_order_noise(z.predicted[i].J_world, z.predicted[j].J_world, moments);
  }

  const LandmarkFunctions& model = find_landmark("scaled_velocity", "log_inverse_depth");
  Devices devices = plain(model);
  JointState state = scene(2);
  Innovation z;
  GrowingMatrix result;
};

TEST(SecondOrder, IsInTheJointCovarianceOfAllPixels) {
  for (const bool has_known : {true, false}) {
    SCOPED_TRACE(has_known);
    const SecondOrderScene scene(has_known);
    const Eigen::MatrixXd H = dense_H(scene.state, scene.z);
    Eigen::MatrixXd expected = H * scene.state.covariance.dense() * H.transpose();
    ASSERT_EQ(scene.z.matches.size(), 3u);
    for (const std::size_t i : {0u, 2u}) {  // the other one is free
      for (const std::size_t j : {0u, 2u}) {
        if (i != j && !has_known) continue;
        const Eigen::Matrix2d N = scene.N(i, j);
        EXPECT_GT(N.norm(), 0.0);
        expected.block<2, 2>(static_cast<Eigen::Index>(2 * i), static_cast<Eigen::Index>(2 * j)) +=
            N;
      }
    }
    const Eigen::MatrixXd all = (*scene.result).selfadjointView<Eigen::Lower>();
    EXPECT_LT((all - expected).norm(), 1e-12 * expected.norm());
    EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(expected).info(), Eigen::Success);
  }
}

TEST(Keep, LeavesTheInnovationOfWhatWasAccepted) {
  JointState state = scene(1);
  const auto matches = pixels_of(state, standard.point(), 2);
  const std::vector<Observation> accepted{matches[0], matches[1], matches[3]};
  Innovation z, expected;
  linearise(state, standard, pinhole(), matches, z);
  keep(accepted, z);
  linearise(state, standard, pinhole(), accepted, expected);
  ASSERT_EQ(z.matches.size(), 3u);
  EXPECT_EQ(z.matches[2].track, 3);
  EXPECT_TRUE(z.nu == expected.nu);
  EXPECT_TRUE(*z.P_Ht == *expected.P_Ht);
}

// Deaths move other blocks into the gaps: each must be found where it now is, with all it has in
// common with the others.
TEST(RemoveLandmarks, LeavesTheMarginalOfTheRest) {
  JointState state = scene(4);
  state.free_motion(3, MotionVector::Constant(3, 0.5));
  for (unsigned k = 1; k <= 3; ++k) step(state, standard, pixels_of(state, standard.point(), k));
  const auto marginal = [&] {
    const FilterLandmark &a = state.landmarks.at(1), &b = state.landmarks.at(3);
    const std::vector<StateBlock> blocks{JointState::kCamera, state.anchors.at(1).block,
                                         a.y_block,           state.anchors.at(3).block,
                                         b.y_block,           b.w_block};
    Eigen::MatrixXd P(27, 27);
    int row = 0;
    for (const StateBlock& r : blocks) {
      int column = 0;
      for (const StateBlock& c : blocks) {
        P.block(row, column, r.dim, c.dim) = state.covariance.block(r, c);
        column += c.dim;
      }
      row += r.dim;
    }
    return P;
  };
  const Eigen::MatrixXd before = marginal();
  state.remove_landmarks(std::vector<int>{0, 2});
  EXPECT_EQ(state.covariance.size(), 12 + 2 * 6 + 3);
  EXPECT_EQ(state.anchors.size(), 2u);
  EXPECT_TRUE(marginal() == before);
}

// A free landmark among static ones, of which one's motion is remembered, a clone and a scene: P
// as of the textbook's (I - K H) P (I - K H)' + K R K', with the rows of the gain that are not the
// landmark's at zero.
TEST(UpdateConsidered, IsTheJosephFormWithTheLandmarksRowsOfTheGain) {
  constexpr int kTrack = 1, kConstrained = 2;
  constexpr double kSigma = 1.2;
  JointState state = scene(2);
  state.scene = {0.2, state.covariance.append({}, Eigen::MatrixXd::Constant(1, 1, 0.01))};
  state.clones.emplace_back().block = state.covariance.append({}, Matrix6d::Zero());
  state.free_motion(kTrack, MotionVector::Constant(3, 0.1));
  for (unsigned k = 1; k <= 3; ++k) step(state, standard, pixels_of(state, standard.point(), k));
  Matrix6d F = Matrix6d::Identity();  // so that w is correlated with y, and so with the pixel
  F.topRightCorner<3, 3>().diagonal().setConstant(0.1);
  state.covariance.propagate(
      {state.landmarks.at(kTrack).y_block, state.landmarks.at(kTrack).w_block}, F,
      Matrix6d::Zero());
  state.clone_pose(state.clones.front());
  state.free_motion(kConstrained, MotionVector::Constant(3, 0.1));
  const int n = state.covariance.size();
  state.constrain_motion(kConstrained, Eigen::MatrixXd::Constant(n, 3, 0.01),
                         Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.1, 0.2, 0.3));
  const JointState before = state;
  Observation z = pixels_of(state, standard.point(), 9)[kTrack];
  z.relative_sigma = 1.5;
  Innovation memory;
  update_considered(state, standard, pinhole(), {&z, 1}, kSigma, memory);

  Innovation plain;
  linearise(before, standard, pinhole(), {&z, 1}, plain);
  const FilterLandmark& landmark = before.landmarks.at(kTrack);
  const Eigen::MatrixXd P = before.covariance.dense();
  const int size = static_cast<int>(P.rows());
  const Eigen::MatrixXd H = dense_H(before, plain);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size, 2);
  const Eigen::Matrix2d R = 2.25 * kSigma * kSigma * Eigen::Matrix2d::Identity();
  const Eigen::MatrixXd full = P * H.transpose() * (H * P * H.transpose() + R).inverse();
  for (const StateBlock b : {landmark.y_block, landmark.w_block}) {
    K.middleRows(b.offset, b.dim) = full.middleRows(b.offset, b.dim);
  }
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(size, size) - K * H;
  const Eigen::MatrixXd expected = A * P * A.transpose() + K * R * K.transpose();
  EXPECT_LT((state.covariance.dense() - expected).norm(), 1e-13 * P.norm());
  EXPECT_GT((state.covariance.dense() - P).norm(), 1e-4 * P.norm());

  const Eigen::VectorXd dx = K * plain.nu[0];
  const FilterLandmark& after = state.landmarks.at(kTrack);
  EXPECT_LT((after.y - landmark.y - dx.segment<3>(landmark.y_block.offset)).norm(), 1e-14);
  EXPECT_LT((after.w - landmark.w - dx.segment<3>(landmark.w_block.offset)).norm(), 1e-14);
  EXPECT_GT(dx.segment<3>(landmark.w_block.offset).norm(), 1e-6);
  EXPECT_EQ(boxminus(state.camera, before.camera).norm(), 0.0);
  EXPECT_EQ(state.landmarks.at(kConstrained).information_vector,
            before.landmarks.at(kConstrained).information_vector);
  EXPECT_EQ(state.landmarks.at(0).y, before.landmarks.at(0).y);
  EXPECT_EQ(state.scene->inverse_depth, before.scene->inverse_depth);
  EXPECT_EQ(state.clones.front().position, before.clones.front().position);
}

Eigen::MatrixXd some_covariance(int n) {
  std::srand(1);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(n, n);
  const Eigen::MatrixXd C = A * A.transpose();  // symmetric but for rounding
  return 0.5 * (C + C.transpose());
}

TEST(JointCovariance, HasTheProductsOfADenseMatrix) {
  const int n = 300;  // more than one run of columns
  const Eigen::MatrixXd P = some_covariance(n), A = some_covariance(n).topRows(7);
  const Eigen::MatrixXd S = some_covariance(7), L = Eigen::MatrixXd::Random(n, 3);
  const Eigen::MatrixXd M = Eigen::MatrixXd::Random(n, 3);
  JointCovariance joint = joint_of(P);
  EXPECT_TRUE(joint.dense() == P);
  Eigen::MatrixXd P_L(n, 3);
  joint.multiply(L, P_L);
  EXPECT_LT((P_L - P * L).norm(), 1e-12 * P_L.norm());
  joint.add_product(A, S * A);
  EXPECT_LT((joint.dense() - P - A.transpose() * S * A).norm(), 1e-12 * joint.dense().norm());
  joint = joint_of(P);
  joint.add_dependence(L, M);
  const Eigen::MatrixXd T = Eigen::MatrixXd::Identity(n, n) + M * L.transpose();
  EXPECT_LT((joint.dense() - T * P * T.transpose()).norm(), 1e-12 * joint.dense().norm());
  joint = joint_of(P);
  joint.assign({30, 3}, Eigen::MatrixXd::Zero(n, 3), Eigen::Matrix3d::Identity());
  EXPECT_EQ(joint.block({30, 3}, {0, 12}).norm(), 0.0);
  EXPECT_TRUE(joint.block({30, 3}, {30, 3}) == Eigen::Matrix3d::Identity());
  EXPECT_TRUE(joint.block({0, 3}, {33, 3}) == P.block(0, 33, 3, 3));
}

TEST(NisGivenOthers, IsThatOfTheInnovationBesideItsPredictionFromTheOthers) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  constexpr int kMatches = 7, kRows = 2 * kMatches;
  const Eigen::MatrixXd A =
      Eigen::MatrixXd::NullaryExpr(kRows, kRows, [&] { return normal(engine); });
  const Eigen::MatrixXd S = A * A.transpose() + 0.1 * Eigen::MatrixXd::Identity(kRows, kRows);
  const Eigen::MatrixXd L = S.llt().matrixL();
  const Eigen::VectorXd nu = Eigen::VectorXd::NullaryExpr(kRows, [&] { return normal(engine); });
  Innovation solved;  // as update() leaves it
  solved.matches.resize(kMatches);
  solved.nu.resize(kMatches);
  solved.S.resize(kRows, kRows);
  *solved.S = L;
  for (int i = 0; i < kMatches; ++i) solved.matches[static_cast<std::size_t>(i)].track = i;
  const auto set_rows = [&](Innovation& z) {
    stack_rows(z);
    *z.r = L.triangularView<Eigen::Lower>().solve(nu);
  };
  set_rows(solved);
  Innovation of_rig = solved;
  std::vector<LeaveOneOut> nis;
  nis_given_others(solved, nis);
  ASSERT_EQ(nis.size(), kMatches);
  for (Eigen::Index i = 0; i < kMatches; ++i) {
    const double expected = nis_of_leave_out(S, nu, 2 * i, 2);
    EXPECT_NEAR(nis[static_cast<std::size_t>(i)].nis, expected, 1e-9 * expected);
    EXPECT_EQ(nis[static_cast<std::size_t>(i)].pixels, 1);
  }
  // The last two are of one landmark: what remains of them given the first five.
  of_rig.matches.back() = of_rig.matches[kMatches - 2];
  set_rows(of_rig);
  nis_given_others(of_rig, nis);
  ASSERT_EQ(nis.size(), kMatches - 1);
  const double expected = nis_of_leave_out(S, nu, kRows - 4, 4);
  EXPECT_NEAR(nis.back().nis, expected, 1e-8 * expected);
  EXPECT_EQ(nis.back().pixels, 2);
}

}  // namespace
}  // namespace slammot
