// A third estimator family beside filters/ and smoothers/, as docs/extending.md adds one: what
// stands between the `example` and `end` lines is the whole of it.
#include "tests/extending/third_family.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "estimation/loop/frame_loop.h"
#include "models/points/initialisation.h"
#include "models/points/observation.h"

namespace slammot {
namespace {

// [example: third family]
// An unscented Kalman filter of camera and landmarks, with one dense covariance. Predictions and
// measurements go through sigma points; births are linearised, as in the EKF. Written for clarity:
// each landmark has an anchor of its own, and nothing is kept sparse.
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Rows = std::vector<int>;  // of the error state
using Function = std::function<VectorXd(const VectorXd&)>;

// y = f(d), d ~ N(0, P), as y = mean + A d + e: statistical linearisation.
struct Linearised {
  VectorXd mean;
  MatrixXd A, cov_e;
};

// Two sigma points on each principal axis of P, sqrt(3) sigma from the mean, as Julier & Uhlmann
// (2004) with n + kappa = 3; the covariance, which is never indefinite, as Norgaard et al. (2000).
Linearised through_sigma_points(const MatrixXd& P, const Function& f) {
  constexpr double kSpread = 3.0;           // squared, in variances
  constexpr double kLeastVariance = 1e-14;  // where there is none, A is a numerical derivative
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(P);
  const VectorXd centre = f(VectorXd::Zero(P.rows()));
  const Eigen::Index m = centre.size();
  Linearised y{centre, MatrixXd::Zero(m, P.rows()), MatrixXd::Zero(m, m)};
  for (Eigen::Index i = 0; i < P.rows(); ++i) {
    const double step = std::sqrt(kSpread * std::max(axes.eigenvalues()(i), kLeastVariance));
    const VectorXd axis = axes.eigenvectors().col(i);
    const VectorXd plus = f(step * axis), minus = f(-step * axis);
    const VectorXd bend = plus + minus - 2.0 * centre;
    y.mean += bend / (2.0 * kSpread);
    y.A += (plus - minus) * axis.transpose() / (2.0 * step);
    y.cov_e += (kSpread - 1.0) / (4.0 * kSpread * kSpread) * bend * bend.transpose();
  }
  return y;
}

class Unscented final : public Belief {
 public:
  Unscented(const Setup& setup, const ModelOptions& models)
      : setup_(setup),
        condition_(models.collapse == Collapse::kCondition),
        functions_(find_landmark(models.landmark, models.point)),
        camera_(setup.initial.state),
        x_(VectorXd::Zero(13)) {
    x_(kScene) = setup.prior.inverse_depth;
    VectorXd sigmas(13);
    sigmas << setup.initial.sigmas(), setup.prior.mean_sigma;
    P_ = sigmas.cwiseAbs2().asDiagonal();
  }

  void predict(const Frame& /*frame*/, double dt, const MotionNoise& noise,
               const TrackRecords& records) override {
    if (dt == 0.0) return;
    const CameraState before = camera_, after = slammot::predict(before, dt);
    camera_ = after;
    propagate(range(0, 12), camera_noise(noise, before, dt), [&](const VectorXd& d) {
      return VectorXd(boxminus(slammot::predict(boxplus(before, Vector12d(d)), dt), after));
    });
    for (const auto& [track, l] : landmarks_) {
      if (!l.w.empty()) predict_landmark(joined(l.y, l.w), records.at(track).label, dt);
    }
  }

  void add_known(const KnownLandmark& known) override {
    const NewKnownLandmark here = initialise_known(functions_.point, known, camera_.position);
    const MatrixXd root = here.J_y_position * known.sigma;
    insert(known.track, here.y, -here.J_y_position, root * root.transpose());
  }

  void innovations(std::span<const Observation> measured, FrameInnovation& result) override {
    result.z.clear();
    result.nu.clear();
    pixels_.clear();
    for (const Observation& z : measured) {
      const Landmark& l = landmarks_.at(z.track);
      const Rows rows = joined(joined(range(0, 6), l.anchor), l.y);
      const Linearised h = pixel(rows);
      if (!h.mean.allFinite()) continue;
      pixels_.push_back({z, z.pixel - h.mean, rows, h.A, h.cov_e});
      result.z.push_back(z);
      result.nu.push_back(pixels_.back().nu);
    }
    stack();
    result.HPHt.resize(S_.rows(), S_.cols());
    *result.HPHt = S_;
  }

  void update(std::span<const Observation> accepted, std::span<const int> considered,
              StageListener& /*stages*/) override {
    std::erase_if(pixels_, [&](const Pixel& pixel) {
      return std::ranges::find(accepted, pixel.z.track, &Observation::track) == accepted.end();
    });
    const auto is_considered = [&](const Pixel& pixel) {
      return std::ranges::binary_search(considered, pixel.z.track);
    };
    std::vector<Pixel> aside;
    std::ranges::copy_if(pixels_, std::back_inserter(aside), is_considered);
    std::erase_if(pixels_, is_considered);
    correct_all();
    for (const Pixel& pixel : aside) correct_own(pixel.z, pixel.rows);
  }

  // With a = S^-1 nu and B = S^-1 it is a_i' B_ii^-1 a_i (docs/filter.md).
  void leave_one_out(std::vector<LeaveOneOut>& result) override {
    result.clear();
    const MatrixXd B = S_.inverse();
    const VectorXd a = B * nu_;
    for (std::size_t k = 0; k < pixels_.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(2 * k);
      const Eigen::Vector2d a_i = a.segment<2>(i);
      const Eigen::Matrix2d B_ii = B.block<2, 2>(i, i);
      result.push_back({pixels_[k].z.track, a_i.dot(B_ii.inverse() * a_i)});
    }
  }

  void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) override {
    result.clear();
    for (const int track : tracks) {
      const Rows& y = landmarks_.at(track).y;
      result.push_back(seen_depth(functions_.point, x_(y), P_(y, y)));
    }
  }

  void motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override {
    result.clear();
    for (const int track : tracks) {
      const Landmark& l = landmarks_.at(track);
      const Rows x = joined(l.y, l.w);
      result.push_back(motion_belief(track, functions_, x_(x), P_(x, x)));
    }
  }

  void collapse(std::span<const int> tracks) override {
    Rows gone;
    for (const int track : tracks) gone = joined(gone, std::exchange(landmarks_.at(track).w, {}));
    if (condition_) correct(P_(Eigen::all, gone), P_(gone, gone), -x_(gone));
    erase(gone);
  }

  void free(int track, const LandmarkPrior& prior) override {
    const VectorXd sigmas = functions_.prior_sigmas(prior), rest = 0.0 * sigmas;
    landmarks_.at(track).w =
        append(rest, MatrixXd(sigmas.size(), 0), sigmas.cwiseAbs2().asDiagonal());
  }

  void remove(std::span<const int> tracks, const TrackRecords& /*records*/) override {
    Rows gone;
    for (const int track : tracks) gone = joined(gone, landmarks_.extract(track).mapped().all());
    erase(gone);
  }

  bool add(const FirstSight& seen, const LandmarkPrior& prior, bool is_free) override {
    const Observation& z = seen.z;
    const bool shared = setup_.prior.mean_sigma > 0.0;  // the mean is in the state
    const double rho = shared ? x_(kScene) : seen.prior.inverse_depth;
    const auto born =
        initialise(setup_.camera, functions_.point, camera_.orientation, z.pixel, rho);
    if (!born) return false;
    MatrixXd J = MatrixXd::Zero(3, 13), root(3, 3);
    J.middleCols<3>(kRotation) = born->J_rotation;
    if (shared) J.col(kScene) = born->J_inverse_depth;
    root << std::sqrt(z.variance(setup_.pixel_sigma)) * born->J_pixel,
        seen.prior.sigma * born->J_inverse_depth;
    insert(z.track, born->y, J, root * root.transpose());
    if (is_free) free(z.track, prior);
    return true;
  }

  void finish() override {
    if (!P_.allFinite() || P_.diagonal().minCoeff() < 0.0) throw Diverged("a negative variance");
  }

  int state_size() const override { return static_cast<int>(x_.size()); }
  CameraEstimate camera() const override { return {0.0, camera_, P_.topLeftCorner<12, 12>()}; }
  void points(std::vector<LandmarkPoint>& result) override {
    result.clear();
    for (const auto& [track, l] : landmarks_) result.push_back({track, x_(l.anchor), x_(l.y)});
  }
  std::vector<LandmarkBelief> landmarks(std::span<const int> tracks) const override {
    std::vector<LandmarkBelief> result;
    for (const int track : tracks) {
      const Landmark& l = landmarks_.at(track);
      result.push_back({x_(l.anchor), x_(l.y), x_(l.w), P_(l.all(), l.all())});
    }
    return result;
  }

 private:
  static Rows range(Eigen::Index from, Eigen::Index size) {
    Rows rows(static_cast<std::size_t>(size));
    std::iota(rows.begin(), rows.end(), static_cast<int>(from));
    return rows;
  }
  static Rows joined(Rows a, const Rows& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }

  struct Landmark {
    Rows anchor, y, w;  // w empty: static
    Rows all() const { return joined(joined(anchor, y), w); }
  };
  struct Pixel {
    Observation z;
    Eigen::Vector2d nu;
    Rows rows;
    MatrixXd H;  // with respect to these rows
    Eigen::Matrix2d cov_e;
  };

  // nu, P H' and S without the pixels' noise, of all that is in pixels_.
  void stack() {
    const Eigen::Index m = 2 * std::ssize(pixels_);
    MatrixXd H = MatrixXd::Zero(m, x_.size());
    S_ = MatrixXd::Zero(m, m);
    nu_.resize(m);
    for (Eigen::Index i = 0; i < m; i += 2) {
      const Pixel& pixel = pixels_[static_cast<std::size_t>(i / 2)];
      H(Eigen::seqN(i, 2), pixel.rows) = pixel.H;
      S_.block<2, 2>(i, i) += pixel.cov_e;
      nu_.segment<2>(i) = pixel.nu;
    }
    P_Ht_ = P_ * H.transpose();
    S_ += H * P_Ht_;
  }

  void predict_landmark(const Rows& rows, Label label, double dt) {
    const LandmarkVector before = x_(rows), after = functions_.predict(before, dt);
    const MatrixXd G =
        functions_.noise_root(after, setup_.prior.noise(label == Label::kMoving), dt);
    x_(rows) = after;
    propagate(rows, G * G.transpose(), [&](const VectorXd& d) {
      return VectorXd(functions_.predict(before + d, dt) - after);
    });
  }

  // The error of these rows becomes f of itself, plus noise.
  void propagate(const Rows& rows, const MatrixXd& Q, const Function& f) {
    const Linearised y = through_sigma_points(P_(rows, rows), f);
    P_(rows, Eigen::all) = (y.A * P_(rows, Eigen::all)).eval();
    P_(Eigen::all, rows) = (P_(Eigen::all, rows) * y.A.transpose()).eval();
    P_(rows, rows) += y.cov_e + Q;
    VectorXd dx = VectorXd::Zero(x_.size());
    dx(rows) = y.mean;
    move(dx);
  }

  // Of pose, anchor and y. It depends on nine numbers only, u = (rotation, anchor - position, y):
  // of where the world's origin is, nothing is learnt. Not finite when not expected in view.
  Linearised pixel(const Rows& rows) const {
    const VectorXd x = x_(rows);
    const Eigen::Vector3d r = camera_.position, anchor = x.segment<3>(6), y = x.tail<3>();
    const Eigen::Quaterniond R = camera_.orientation;
    if (!expect(setup_.camera, functions_.point, r, R, anchor, y))
      return {VectorXd::Constant(2, kUndefined), {}, {}};
    MatrixXd J = MatrixXd::Zero(9, 12);
    J.rightCols<9>().setIdentity();
    J.block<3, 3>(3, 0) = -Eigen::Matrix3d::Identity();
    Linearised h = through_sigma_points(
        J * P_(rows, rows) * J.transpose(), [&](const VectorXd& u) -> VectorXd {
          const Eigen::Quaterniond turned = R * exp_so3<double>(u.head<3>());
          const auto seen = observe(setup_.camera, functions_.point, r, turned,
                                    anchor + u.segment<3>(3), y + u.tail<3>());
          return seen ? seen->pixel : Eigen::Vector2d::Constant(kUndefined);
        });
    h.A *= J;
    return h;
  }

  // By all that is in pixels_.
  void correct_all() {
    stack();
    for (std::size_t k = 0; k < pixels_.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(2 * k);
      S_.diagonal().segment<2>(i).array() += pixels_[k].z.variance(setup_.pixel_sigma);
    }
    if (!pixels_.empty()) correct(P_Ht_, S_, nu_);
  }

  // Schmidt's update: the gain of everything but the landmark itself is zero.
  void correct_own(const Observation& z, const Rows& rows) {
    const Linearised h = pixel(rows);
    if (!h.mean.allFinite()) return;
    const Landmark& l = landmarks_.at(z.track);
    const Rows own = joined(l.y, l.w);
    const MatrixXd P_Ht = P_(Eigen::all, rows) * h.A.transpose();
    MatrixXd S = h.A * P_Ht(rows, Eigen::all) + h.cov_e;
    S.diagonal().array() += z.variance(setup_.pixel_sigma);
    const MatrixXd K = S.llt().solve(P_Ht(own, Eigen::all).transpose()).transpose();
    P_(own, Eigen::all) -= (K * P_Ht.transpose()).eval();
    P_(Eigen::all, own) = P_(own, Eigen::all).transpose().eval();
    x_(own) += K * (z.pixel - h.mean);
  }

  // By what was measured: nu from the mean, with covariance S, and P_Ht with the state.
  void correct(const MatrixXd& P_Ht, const MatrixXd& S, const VectorXd& nu) {
    const Eigen::LLT<MatrixXd> llt(S);
    if (llt.info() != Eigen::Success) throw Diverged("a covariance is not positive definite");
    const MatrixXd Wt = llt.matrixL().solve(P_Ht.transpose());
    P_.noalias() -= Wt.transpose() * Wt;
    move(Wt.transpose() * llt.matrixL().solve(nu));
  }

  // x := x [+] dx; the rotation's error is from now on one of the new rotation.
  void move(const VectorXd& dx) {
    camera_ = boxplus(camera_, Vector12d(dx.head<12>()));
    x_ += dx;
    x_.head<12>().setZero();
    const Eigen::Matrix3d J = right_jacobian_so3(dx.segment<3>(kRotation));
    P_.middleRows<3>(kRotation) = (J * P_.middleRows<3>(kRotation)).eval();
    P_.middleCols<3>(kRotation) = (P_.middleCols<3>(kRotation) * J.transpose()).eval();
  }

  // Its anchor is where the camera is, with the same error for ever.
  void insert(int track, const Eigen::Vector3d& y, const MatrixXd& J, const MatrixXd& R) {
    Landmark& l = landmarks_[track];
    l.anchor = append(camera_.position, MatrixXd::Identity(3, 3), MatrixXd::Zero(3, 3));
    l.y = append(y, J, R);
  }

  // New rows whose error is J times that of the first rows, plus one of covariance R.
  Rows append(const VectorXd& x, const MatrixXd& J, const MatrixXd& R) {
    const Eigen::Index n = x_.size(), m = x.size();
    const MatrixXd JP = J * P_.topRows(J.cols());
    x_.conservativeResize(n + m);
    P_.conservativeResize(n + m, n + m);
    x_.tail(m) = x;
    P_.bottomLeftCorner(m, n) = JP;
    P_.topRightCorner(n, m) = JP.transpose();
    P_.bottomRightCorner(m, m) = JP.leftCols(J.cols()) * J.transpose() + R;
    return range(n, m);
  }

  void erase(const Rows& gone) {
    Rows kept, place;  // `place`: the new one of each row
    for (int i = 0; i < x_.size(); ++i) {
      place.push_back(static_cast<int>(kept.size()));
      if (std::ranges::find(gone, i) == gone.end()) kept.push_back(i);
    }
    x_ = x_(kept).eval();
    P_ = P_(kept, kept).eval();
    for (auto& [track, l] : landmarks_) {
      for (Rows* rows : {&l.anchor, &l.y, &l.w}) {
        for (int& row : *rows) row = place[static_cast<std::size_t>(row)];
      }
    }
  }

  static constexpr int kScene = kCameraDim;  // the row of the scene's mean inverse depth

  Setup setup_;
  bool condition_;  // on collapse, w = 0 is used
  const LandmarkFunctions& functions_;
  CameraState camera_;
  VectorXd x_;  // rows of the camera (zero), the scene, then of the landmarks
  MatrixXd P_;
  std::map<int, Landmark> landmarks_;  // by track
  std::vector<Pixel> pixels_;          // of this frame; used by the update, once there was one
  MatrixXd P_Ht_, S_;
  VectorXd nu_;
};

}  // namespace

const EstimatorRow kUnscented{
    "ukf",
    "unscented Kalman filter, undelayed",
    EstimatorKind::kFilter,
    false,
    [](Configuration&) {},
    [](const Setup& setup, const Configuration& c) -> std::unique_ptr<Estimator> {
      return std::make_unique<FrameLoop>(setup, c.model,
                                         std::make_unique<Unscented>(setup, c.model));
    }};
// [end]

}  // namespace slammot
