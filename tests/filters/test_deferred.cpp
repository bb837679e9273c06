// The EKF whose passive map is updated when it returns (passive_map.h) is the EKF.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "datasets/simulation/scenario.h"
#include "estimation/loop/frame_loop.h"
#include "eval/configuration/setup.h"
#include "filters/ekf_belief.h"

namespace slammot {
namespace {

constexpr double kSame = 1e-9;

// The largest entry of A - B in units of the standard deviations of B.
double difference(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  EXPECT_TRUE(A.allFinite() && B.allFinite());
  const Eigen::VectorXd s = B.diagonal().cwiseSqrt();
  return (A - B).cwiseQuotient(s * s.transpose()).cwiseAbs().maxCoeff();
}

double difference(const CameraEstimate& a, const CameraEstimate& b) {
  const Vector12d sigma = b.covariance.diagonal().cwiseSqrt();
  return std::max(boxminus(a.state, b.state).cwiseQuotient(sigma).cwiseAbs().maxCoeff(),
                  difference(a.covariance, b.covariance));
}

double difference(const std::vector<LandmarkEstimate>& a, const std::vector<LandmarkEstimate>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    EXPECT_EQ(a[i].track, b[i].track);
    EXPECT_EQ(a[i].label, b[i].label);
    if (!b[i].position.allFinite()) continue;
    const Eigen::Vector3d sigma = b[i].position_covariance.diagonal().cwiseSqrt();
    worst =
        std::max({worst, (a[i].position - b[i].position).cwiseQuotient(sigma).cwiseAbs().maxCoeff(),
                  difference(a[i].position_covariance, b[i].position_covariance)});
  }
  return worst;
}

// What the passive map did in a run.
struct Used {
  int returns = 0;     // frames in which some of it came back
  int retired = 0;     // landmarks pruned while passive
  int largest = 0;     // rows
  double share = 0.0;  // of the state's rows, then
};

class Observed {
 public:
  explicit Observed(const Ekf& ekf) : state_(ekf.state()) {}

  void before_frame() {
    passive_.clear();
    for (const auto& [track, l] : state_.landmarks) {
      if (l.is_passive()) passive_.insert(track);
    }
  }

  void after_frame(const FrameReport& report, Used& used) const {
    for (const LandmarkEstimate& l : report.retired) used.retired += passive_.contains(l.track);
    used.returns += std::ranges::any_of(passive_, [&](int track) {
      const auto l = state_.landmarks.find(track);
      return l != state_.landmarks.end() && !l->second.is_passive();
    });
    if (state_.passive.size() <= used.largest) return;
    used.largest = state_.passive.size();
    used.share = used.largest / static_cast<double>(state_.size());
  }

 private:
  const JointState& state_;
  std::set<int> passive_;  // tracks
};

struct Case {
  std::string landmark, collapse, linearisation;
  int iterations = 1;
  bool delayed = false;
  double mean_sigma = 0.0;
};

std::string name_of(const Case& c) {
  return c.landmark + "_" + c.collapse + "_" + c.linearisation +
         (c.iterations > 1 ? "_iterated" : "") + (c.delayed ? "_delayed" : "") +
         (c.mean_sigma > 0.0 ? "_scene" : "");
}

void PrintTo(const Case& c, std::ostream* out) { *out << name_of(c); }

// An EKF in its frame loop, with its state to look at.
struct Driven {
  Driven(const slammot::Setup& setup, const ModelOptions& models, const EkfOptions& options)
      : loop(
            setup, models,
            [=, this] {
              auto belief = std::make_unique<Ekf>(setup, models, options);
              ekf = belief.get();
              return belief;
            },
            options.linearisation == FilterLinearisation::kIdeal ? setup.truth : nullptr) {}

  // Of all landmarks, also passive ones.
  std::vector<Prediction> predictions() {
    std::vector<int> tracks;
    for (const auto& [track, landmark] : ekf->state().landmarks) tracks.push_back(track);
    std::vector<Prediction> result;
    ekf->predict_pixels(tracks, result);
    return result;
  }

  Ekf* ekf = nullptr;
  FrameLoop loop;
};

// The largest, of pixels [sigma] and of S.
double difference(const std::vector<Prediction>& a, const std::vector<Prediction>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    EXPECT_EQ(a[i].track, b[i].track);
    worst = std::max({worst, (a[i].pixel - b[i].pixel).norm() / std::sqrt(b[i].S.norm()),
                      (a[i].S - b[i].S).norm() / b[i].S.norm()});
  }
  return worst;
}

class DeferredCase : public testing::TestWithParam<Case> {};

// On a circle driven more than once: what has left the view returns.
TEST_P(DeferredCase, IsTheEkf) {
  const Sequence sequence = simulate("circle", {}, 1);
  Configuration configuration;
  assign(configuration, {"ekf.linearisation", GetParam().linearisation});
  slammot::Setup setup = make_setup(sequence, configuration);
  setup.prior.mean_sigma = GetParam().mean_sigma;
  ModelOptions models;
  models.landmark = GetParam().landmark;
  models.labels.first_frame = FirstFrameLabels::kStatic;  // `ekf` stays the one looked at
  models.collapse = GetParam().collapse == "drop" ? Collapse::kDrop : Collapse::kCondition;
  EkfOptions options;
  options.linearisation = configuration.ekf.linearisation;
  options.iterations = GetParam().iterations;
  options.delayed = GetParam().delayed;
  options.equivariant_scale = false;
  Driven plain(setup, models, options);
  options.deferred = true;
  Driven deferred(setup, models, options);
  NoStages stages;
  double worst = 0.0, worst_landmark = 0.0, worst_prediction = 0.0;
  Observed observed(*deferred.ekf);
  Used used;
  for (const Frame& frame : sequence.frames) {
    observed.before_frame();
    const FrameReport a = deferred.loop.process(frame, stages),
                      b = plain.loop.process(frame, stages);
    observed.after_frame(a, used);
    ASSERT_EQ(a.accepted, b.accepted) << "frame " << frame.index;
    ASSERT_EQ(a.rejected, b.rejected);
    ASSERT_EQ(a.admitted, b.admitted);
    ASSERT_EQ(a.state_size, b.state_size);
    ASSERT_EQ(a.negative_inverse_depth, b.negative_inverse_depth);
    worst = std::max(worst, difference(deferred.loop.camera(), plain.loop.camera()));
    worst_landmark = std::max(worst_landmark, difference(a.retired, b.retired));
    if (frame.index % 50 == 0) {
      worst_landmark =
          std::max(worst_landmark, difference(deferred.loop.landmarks(), plain.loop.landmarks()));
    }
    if (frame.index % 10 == 9) {
      worst_prediction =
          std::max(worst_prediction, difference(deferred.predictions(), plain.predictions()));
    }
  }
  worst_landmark =
      std::max(worst_landmark, difference(deferred.loop.landmarks(), plain.loop.landmarks()));
  const int synchronisations = deferred.ekf->state().passive.synchronisations();
  std::printf("largest difference: camera %.1e, landmarks %.1e, predictions %.1e [sigma]\n", worst,
              worst_landmark, worst_prediction);
  std::printf(
      "%d synchronisations, %d frames with returns, %d pruned while passive, at most %d rows "
      "passive, %.0f%%\n",
      synchronisations, used.returns, used.retired, used.largest, 100.0 * used.share);
  EXPECT_LT(worst, kSame);
  EXPECT_LT(worst_landmark, kSame);
  EXPECT_LT(worst_prediction, kSame);
  EXPECT_GE(synchronisations, 4);
  EXPECT_GE(used.returns, 20);
  EXPECT_GE(used.retired, 1);
  EXPECT_GT(used.share, 0.6);
}

INSTANTIATE_TEST_SUITE_P(Filters, DeferredCase,
                         testing::Values(Case{"scaled_velocity", "drop", "standard"},
                                         Case{"scaled_velocity", "condition", "standard"},
                                         Case{"scaled_velocity", "condition", "fej"},
                                         Case{"dynamic_inverse_depth", "drop", "fej"},
                                         Case{"dynamic_inverse_depth", "condition", "standard"},
                                         Case{"scaled_velocity", "drop", "ideal"},
                                         Case{"scaled_velocity", "drop", "standard", 3},
                                         Case{"scaled_velocity", "drop", "standard", 1, true},
                                         Case{"scaled_velocity", "drop", "standard", 1, false,
                                              0.02}),
                         [](const auto& tested) { return name_of(tested.param); });

TEST(Deferred, IsRefusedWhereFarRowsChangeOtherwise) {
  const Sequence sequence = simulate("circle", {{"frames", "3"}}, 1);
  EkfOptions options;
  options.deferred = true;
  options.linearisation = FilterLinearisation::kInvariant;
  EXPECT_THROW(make_ekf(make_setup(sequence, Configuration{}), {}, options), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
