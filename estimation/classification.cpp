#include "estimation/classification.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "models/find_row.h"

namespace slammot {

namespace {

// (2 pi)^(n/2), of a Gaussian of n numbers.
double normalisation(Eigen::Index n) {
  return std::pow(2.0 * std::numbers::pi, 0.5 * static_cast<double>(n));
}

}  // namespace

double density_at_zero(const MotionVector& mean, const MotionMatrix& covariance) {
  const Eigen::LLT<MotionMatrix> llt(covariance);
  if (llt.info() != Eigen::Success) return 0.0;
  const double root_determinant = llt.matrixLLT().diagonal().prod();
  const double squared = llt.matrixL().solve(mean).squaredNorm();
  return std::exp(-0.5 * squared) / (normalisation(mean.size()) * root_determinant);
}

double mahalanobis_from_zero(const MotionVector& mean, const MotionMatrix& covariance) {
  const Eigen::LLT<MotionMatrix> llt(covariance);
  return llt.info() == Eigen::Success ? llt.matrixL().solve(mean).norm() : 0.0;
}

namespace {

// Thesis 3.1.3, of the velocity: static when C_s > t_s (3.1), else moving when C_m > t_m (3.2).
class ThesisClassifier final : public Classifier {
 public:
  explicit ThesisClassifier(const ClassifierOptions& options) : options_(options) {}

  Label decide(const MotionBelief& belief) const override {
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

// The Savage-Dickey ratio: posterior over prior density at rest is the Bayes factor of "static"
// against "free" (Dickey 1971). It has no unit, so neither t_s nor the scale enters.
class BayesFactorClassifier final : public Classifier {
 public:
  explicit BayesFactorClassifier(const ClassifierOptions& options) : options_(options) {}

  Label decide(const MotionBelief& belief) const override {
    const double posterior = density_at_zero(belief.w, belief.covariance);
    double inverse_prior = normalisation(belief.w.size());
    for (const double s : belief.prior_sigmas) inverse_prior *= s;
    const double prior = 1.0 / inverse_prior;
    const double factor = posterior / prior;
    if (factor > options_.static_factor) return Label::kStatic;
    return factor < options_.moving_factor ? Label::kMoving : Label::kUnknown;
  }

 private:
  ClassifierOptions options_;
};

// The whole world is static: monocular SLAM as it was before the thesis.
class AllStaticClassifier final : public Classifier {
 public:
  Label at_birth(int) const override { return Label::kStatic; }
  Label decide(const MotionBelief&) const override { return Label::kStatic; }
};

// The labels of the ground truth, at birth; without truth a landmark is never decided.
class TruthClassifier final : public Classifier {
 public:
  explicit TruthClassifier(const std::map<int, Label>& truth) : truth_(truth) {}
  Label at_birth(int track) const override {
    const auto it = truth_.find(track);
    return it == truth_.end() ? Label::kUnknown : it->second;
  }
  Label decide(const MotionBelief& belief) const override { return at_birth(belief.track); }

 private:
  std::map<int, Label> truth_;
};

using Options = ClassifierOptions;
using TrueLabels = std::map<int, Label>;
using Made = std::unique_ptr<Classifier>;

constexpr ClassifierRow kTable[] = {
    {"thesis", "density at v = 0 over t_s: static; Mahalanobis distance over t_m: moving",
     [](const Options& o, const TrueLabels&) -> Made {
       return std::make_unique<ThesisClassifier>(o);
     }},
    {"bayes_factor", "Savage-Dickey ratio of static to free; no unit, no scale",
     [](const Options& o, const TrueLabels&) -> Made {
       return std::make_unique<BayesFactorClassifier>(o);
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

}  // namespace

std::span<const ClassifierRow> classifier_table() { return kTable; }

std::unique_ptr<Classifier> make_classifier(const ClassifierOptions& options,
                                            const std::map<int, Label>& true_labels) {
  return find_row(classifier_table(), options.name, "classifier").make(options, true_labels);
}

}  // namespace slammot
