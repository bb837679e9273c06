#include "estimation/classification.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "models/find_row.h"

namespace slammot {

namespace {

// None if the covariance is not positive definite.
std::optional<double> log_density_at_zero(const MotionVector& mean,
                                          const MotionMatrix& covariance) {
  const Eigen::LLT<MotionMatrix> llt(covariance);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const double log_root_determinant = llt.matrixLLT().diagonal().array().log().sum();
  const double squared = llt.matrixL().solve(mean).squaredNorm();
  const double log_normalisation =
      0.5 * static_cast<double>(mean.size()) * std::log(2.0 * std::numbers::pi);
  return -0.5 * squared - log_normalisation - log_root_determinant;
}

// With c = cov(w, rho): to first order var(rho) w w' + rho (w c' + c w') + rho^2 P_w, and
// var(rho) P_w|rho beside it, so that where nothing was measured it is the prior's.
SeenMotion seen_motion(const LandmarkFunctions& landmark, const LandmarkVector& x,
                       const LandmarkMatrix& covariance) {
  const Eigen::Vector3d y = x.head<3>();
  const MotionVector w = x.tail(landmark.motion);
  const double rho = landmark.point.inverse_depth(y);
  const Eigen::RowVector3d J = landmark.point.inverse_depth_jacobian(y);
  const double variance = J * covariance.topLeftCorner(3, 3) * J.transpose();
  const MotionVector c = covariance.bottomLeftCorner(landmark.motion, 3) * J.transpose();
  const MotionMatrix P_w = covariance.bottomRightCorner(landmark.motion, landmark.motion);
  const double mean_square = rho * rho + variance;
  return {rho * w,
          mean_square * P_w + variance * w * w.transpose() +
              rho * (w * c.transpose() + c * w.transpose()) - c * c.transpose(),
          std::sqrt(mean_square)};
}

}  // namespace

MotionBelief motion_belief(int track, const LandmarkFunctions& landmark, const LandmarkVector& x,
                           const LandmarkMatrix& covariance) {
  MotionBelief motion;
  motion.track = track;
  motion.w = x.tail(landmark.motion);
  motion.covariance = covariance.bottomRightCorner(landmark.motion, landmark.motion);
  motion.density_scale = landmark.density_scale(x);
  if (landmark.motion_in_metres) motion.seen = seen_motion(landmark, x, covariance);
  return motion;
}

double density_at_zero(const MotionVector& mean, const MotionMatrix& covariance) {
  const auto log_density = log_density_at_zero(mean, covariance);
  return log_density ? std::exp(*log_density) : 0.0;
}

double mahalanobis_from_zero(const MotionVector& mean, const MotionMatrix& covariance) {
  const Eigen::LLT<MotionMatrix> llt(covariance);
  return llt.info() == Eigen::Success ? llt.matrixL().solve(mean).norm() : 0.0;
}

std::optional<double> log_odds_ratio_of_rest(const MotionBelief& belief) {
  const double rho = belief.seen ? belief.seen->rho : 1.0;
  const MotionMatrix prior = (rho * belief.prior_sigmas).cwiseAbs2().asDiagonal().toDenseMatrix();
  const auto now = belief.seen ? log_density_at_zero(belief.seen->rho_w, belief.seen->covariance)
                               : log_density_at_zero(belief.w, belief.covariance);
  const auto before = log_density_at_zero(MotionVector::Zero(belief.w.size()), prior);
  if (!now || !before) return std::nullopt;
  return *now - *before;
}

double static_score_at_birth(const LandmarkFunctions& landmark, const LandmarkPrior& prior) {
  const Eigen::Vector3d y(0.0, 0.0, prior.inverse_depth);
  const MotionVector rest = MotionVector::Zero(landmark.motion);
  const Eigen::Vector3d sigmas = landmark.prior_sigmas(prior).head<3>();
  return landmark.density_scale(landmark_state(y, rest)) *
         density_at_zero(Eigen::Vector3d::Zero(), sigmas.cwiseAbs2().asDiagonal().toDenseMatrix());
}

namespace {

// Thesis 3.1.3, of the velocity: static when C_s > t_s (3.1), else moving when C_m > t_m (3.2).
class ThesisClassifier final : public Classifier {
 public:
  explicit ThesisClassifier(const ClassifierOptions& options) : options_(options) {}

  Label decide(const MotionBelief& belief, ClassifierMemory& /*memory*/) const override {
    const Eigen::Vector3d v = belief.velocity_part();
    const Eigen::Matrix3d P = belief.velocity_covariance();
    const double C_s = belief.density_scale * density_at_zero(v, P);
    if (C_s > options_.static_threshold) return Label::kStatic;
    const double C_m = mahalanobis_from_zero(v, P);
    return C_m > options_.moving_threshold ? Label::kMoving : Label::kUnknown;
  }

 private:
  ClassifierOptions options_;
};

// Posterior odds of static to moving: the prior odds, a track's own where they come from outside,
// times the Savage-Dickey ratio. What was found to move is at rest again only against the evidence
// that it moved: its noise lets the belief forget that.
class OddsClassifier final : public Classifier {
 public:
  explicit OddsClassifier(const ClassifierOptions& options) : options_(options) {}
  bool weighs_odds() const override { return true; }

  Label decide(const MotionBelief& belief, ClassifierMemory& memory) const override {
    const auto log_ratio = log_odds_ratio_of_rest(belief);
    if (!log_ratio) return Label::kUnknown;
    const double log_odds = std::log(options_.prior_odds) + *log_ratio + belief.outside;
    const double decisive = std::log(options_.decisive_odds);
    if (log_odds < -decisive) {
      // What was said from outside is not forgotten, and no evidence that it moved.
      memory = {std::max(0.0, decisive + belief.outside)};
      return Label::kMoving;
    }
    const double against = memory.empty() ? 0.0 : memory.front();
    return log_odds - against > decisive ? Label::kStatic : Label::kUnknown;
  }

 private:
  ClassifierOptions options_;
};

// The whole world is static: monocular SLAM as it was before the thesis.
class AllStaticClassifier final : public Classifier {
 public:
  Label at_birth(int) const override { return Label::kStatic; }
  Label decide(const MotionBelief&, ClassifierMemory&) const override { return Label::kStatic; }
};

// The labels of the ground truth, at birth; without truth a landmark is never decided.
class TruthClassifier final : public Classifier {
 public:
  explicit TruthClassifier(const std::map<int, Label>& truth) : truth_(truth) {}
  Label at_birth(int track) const override {
    const auto it = truth_.find(track);
    return it == truth_.end() ? Label::kUnknown : it->second;
  }
  Label decide(const MotionBelief& belief, ClassifierMemory& /*memory*/) const override {
    return at_birth(belief.track);
  }

 private:
  std::map<int, Label> truth_;
};

using Options = ClassifierOptions;
using TrueLabels = std::map<int, Label>;
using Made = std::unique_ptr<Classifier>;

constexpr ClassifierRow kRows[] = {
    {"thesis", "density at v = 0 over t_s: static; Mahalanobis distance over t_m: moving",
     [](const Options& o, const TrueLabels&) -> Made {
       return std::make_unique<ThesisClassifier>(o);
     }},
    {"odds", "posterior odds of static to moving; no unit",
     [](const Options& o, const TrueLabels&) -> Made {
       return std::make_unique<OddsClassifier>(o);
     }},
    {"all_static", "every landmark is static",
     [](const Options&, const TrueLabels&) -> Made {
       return std::make_unique<AllStaticClassifier>();
     }},
    {"truth", "labels of the ground truth, from birth",
     [](const Options&, const TrueLabels& t) -> Made {
       return std::make_unique<TruthClassifier>(t);
     }},
};

std::vector<ClassifierRow>& table() {
  static std::vector<ClassifierRow> rows(std::begin(kRows), std::end(kRows));
  return rows;
}

}  // namespace

std::span<const ClassifierRow> classifier_table() { return table(); }

void add_classifiers(std::span<const ClassifierRow> rows) { add_rows(table(), rows, "classifier"); }

std::unique_ptr<Classifier> make_classifier(const ClassifierOptions& options,
                                            const std::map<int, Label>& true_labels) {
  return find_row(classifier_table(), options.name, "classifier").make(options, true_labels);
}

}  // namespace slammot
