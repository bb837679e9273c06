// Static or moving? (thesis chapter 3.) A classifier looks at the belief about a landmark's motion
// and says a label; one row of classifier_table() and one class adds one.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "estimation/options.h"
#include "models/label.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {

// rho w of a free landmark whose w is in metres. A pixel measures rho w, and w only as far as the
// depth is known: where it is not, the Gaussian of w reaches rest although the pixel has moved.
struct SeenMotion {
  MotionVector rho_w;
  MotionMatrix covariance;
  double rho = 1.0;  // root mean square of the inverse depth as believed [1/m]
};

// The marginal Gaussian of w (landmark.h), with w = 0 at rest.
struct MotionBelief {
  int track = 0;
  MotionVector w;
  MotionMatrix covariance;
  MotionVector prior_sigmas;   // of each number of w at first sight
  double density_scale = 1.0;  // density of v at rest = density_scale * density of w's first three
  double outside = 0.0;        // evidence of rest from outside (modules/outside_odds.h), a log
  std::optional<SeenMotion> seen = std::nullopt;

  // Of the first three, which say the velocity.
  Eigen::Vector3d velocity_part() const { return w.head<3>(); }
  Eigen::Matrix3d velocity_covariance() const { return covariance.topLeftCorner<3, 3>(); }
};

// Of a free landmark, from its state x = (y, w) and the covariance of x.
MotionBelief motion_belief(int track, const LandmarkFunctions& landmark, const LandmarkVector& x,
                           const LandmarkMatrix& covariance);

// Density of a Gaussian (mean, covariance) at zero; 0 if the covariance is not positive definite.
double density_at_zero(const MotionVector& mean, const MotionMatrix& covariance);

// sqrt(mean' covariance^-1 mean), thesis (3.2); 0 if the covariance is not positive definite.
double mahalanobis_from_zero(const MotionVector& mean, const MotionMatrix& covariance);

// The logarithm of the Savage-Dickey ratio (Dickey 1971), posterior over prior odds of rest: the
// density of w at rest now over that at first sight, by what is seen of w. None where a covariance
// is not positive definite.
std::optional<double> log_odds_ratio_of_rest(const MotionBelief& belief);

// C_s at first sight, (3.1) [(m/s)^-3].
double static_score_at_birth(const LandmarkFunctions& landmark, const LandmarkPrior& prior);

// What a classifier remembers of one landmark, in numbers of its choice: empty at first sight and
// after a label was reverted. It lives in the landmark's record, never in the classifier, so that a
// copied record carries its own past.
using ClassifierMemory = std::vector<double>;

class Classifier {
 public:
  virtual ~Classifier() = default;
  // A label that needs no measurement; unknown where there is none (thesis 3.1.3).
  virtual Label at_birth(int /*track*/) const { return Label::kUnknown; }
  // Whether it weighs MotionBelief::outside.
  virtual bool weighs_odds() const { return false; }
  // The label of a landmark that is unknown so far, or moving and possibly not any more; also of a
  // static one by the motion it would have (LabelOptions::memory): "moving" takes its label back.
  virtual Label decide(const MotionBelief& belief, ClassifierMemory& memory) const = 0;
};

struct ClassifierRow {
  std::string_view name;
  std::string_view description;
  std::unique_ptr<Classifier> (*make)(const ClassifierOptions&, const std::map<int, Label>& truth);
};
std::span<const ClassifierRow> classifier_table();

// Before anything is looked up; throws std::invalid_argument for a name that is taken.
void add_classifiers(std::span<const ClassifierRow> rows);

// The classifier options a landmark model leaves room for.
inline ClassifierOptions classifier_for(const LandmarkFunctions& landmark,
                                        ClassifierOptions options) {
  if (!landmark.can_move) options.name = "all_static";
  return options;
}

// Throws std::invalid_argument for an unknown name.
std::unique_ptr<Classifier> make_classifier(const ClassifierOptions& options,
                                            const std::map<int, Label>& true_labels);

}  // namespace slammot
