// The life of landmarks in the window: birth, classification, collapse to static, death.
#include "estimation/label_policy.h"
#include "models/initialisation.h"
#include "models/observation.h"
#include "smoothers/graph/factors.h"
#include "smoothers/window/window_estimator.h"

namespace slammot {

std::optional<VariableId> add_scene(Graph& graph, const LandmarkPrior& prior) {
  if (!(prior.mean_sigma > 0.0)) return std::nullopt;
  const VariableId scene =
      graph.add_variable(Eigen::VectorXd::Constant(1, prior.inverse_depth), nullptr, -1);
  graph.add_factor({scene}, scene_prior_cost(prior));
  return scene;
}

WindowLandmark& Window::birth(const TrackRecord& record, const Eigen::Vector2d& pixel) {
  WindowLandmark& landmark = landmarks_[record.track];
  landmark.record = record;
  landmark.anchor = newest().position;
  landmark.base = newest().position;
  if (record_lives_) {
    landmark.life.birth = newest().number;
    if (record.observations > 0) landmark.life.pixels.emplace_back(newest().number, pixel);
  }
  return landmark;
}

void Window::admit_known(const Frame& frame, FrameReport& report) {
  for (const Observation& z : frame.observations) {
    const auto known = known_.find(z.track);
    if (known == known_.end() || landmarks_.contains(z.track)) continue;
    if (!known_used_.insert(z.track).second) continue;  // what was stated counts once
    TrackRecord record = born(z.track, frame.index, Label::kStatic, true, setup_.prior);
    record.known = true;
    record.observations = 0;
    WindowLandmark& landmark = birth(record, z.pixel);
    landmark.life.known = true;
    const Eigen::Vector3d y = initialise_known(known->second, graph_.value(landmark.anchor)).y;
    landmark.y = graph_.add_variable(y, nullptr, z.track);
    linearise_at_truth(landmark);
    newest().knowledge.insert(
        graph_.add_factor({landmark.anchor, landmark.y}, known_landmark_cost(known->second)));
    ++report.admitted;
  }
}

// Thesis 2.1.3, (2.7), as factors: the first pixel, and the priors of inverse depth and motion.
void Window::admit_new(const Frame& frame, FrameReport& report) {
  std::vector<Observation> candidates;
  for (const Observation& z : frame.observations) {
    if (!landmarks_.contains(z.track)) candidates.push_back(z);
  }
  const auto births =
      admit(candidates, static_cast<int>(landmarks_.size()), report.accepted, models_.policy);
  const bool first_frame = frame.index == first_frame_;
  const LandmarkPrior& prior = depth_prior_.born();
  for (const Observation& z : births) {
    const auto y = initialise(setup_.camera, state(newest()).orientation, z.pixel,
                              scene_ ? graph_.value(*scene_)(0) : prior.inverse_depth);
    if (!y) continue;
    const Label label = classifier_->at_birth(z.track, first_frame);
    WindowLandmark& l = birth(born(z.track, frame.index, label, first_frame, prior), z.pixel);
    l.y = graph_.add_variable(y->y, nullptr, z.track);
    linearise_at_truth(l);
    const WindowPixel first = measured(l, {newest().position, newest().motion, z.pixel, 0});
    newest().knowledge.insert(
        scene_ ? graph_.add_factor({l.y, *scene_}, shared_inverse_depth_cost(prior))
               : graph_.add_factor({l.y}, inverse_depth_prior_cost(prior)));
    ++report.admitted;
    if (label == Label::kStatic) continue;
    add_motion(l);
    l.pixels = {first};
  }
}

// w with its prior, and a chain without steps.
void Window::add_motion(WindowLandmark& l) {
  l.w = graph_.add_variable(Eigen::Vector3d::Zero(), nullptr, l.record.track);
  l.w_prior = graph_.add_factor({*l.w}, motion_prior_cost(functions_.prior_sigma(l.record.prior)));
  l.chain = std::make_shared<Chain>(Chain{&functions_, {}});
  linearise_at_truth(l);
}

// As the EKF: of those that were static before this frame's labels.
void Window::learn_depths(const std::vector<Observation>& accepted,
                          const NormalEquations& equations) {
  if (!depth_prior_.learns()) return;
  std::vector<SeenDepth> seen;
  std::vector<LinearForm> forms;
  for (const Observation& z : accepted) {
    const WindowLandmark& l = landmarks_.at(z.track);
    if (l.w) continue;
    seen.push_back({graph_.value(l.y)(2), 0.0});
    forms.push_back({{l.y}, Eigen::RowVector3d::UnitZ()});
  }
  const std::vector<Eigen::MatrixXd> variances = equations.covariances(forms);
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i].sigma = std::sqrt(variances[i](0, 0));
  depth_prior_.learn(seen);
}

// Thesis 3.1.3, for every landmark measured in this frame whose label is open.
std::vector<int> Window::classify(const std::vector<Observation>& accepted,
                                  const NormalEquations& equations, int frame) {
  std::vector<int> asked, now_static;
  std::vector<LinearForm> forms;
  std::vector<Vector6d> states;
  for (const Observation& z : accepted) {
    const WindowLandmark& l = landmarks_.at(z.track);
    if (!is_asked(l.record, models_.labels)) continue;
    const ChainState state = newest_state(graph_, l);
    asked.push_back(z.track);
    states.push_back(state.x);
    forms.push_back({state_variables(l), state.J.bottomRows<3>()});
  }
  const std::vector<Eigen::MatrixXd> P_w = equations.covariances(forms);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    MotionBelief belief;
    belief.track = asked[i];
    belief.w = states[i].tail<3>();
    belief.covariance = P_w[i];
    TrackRecord& record = landmarks_.at(asked[i]).record;
    belief.prior_sigma = functions_.prior_sigma(record.prior);
    belief.density_scale = functions_.density_scale(states[i]);
    note_answer(record, classifier_->decide(belief), frame);
    if (record.label == Label::kStatic) now_static.push_back(asked[i]);
  }
  return now_static;
}

// (3.3). `drop` marginalises all that made the landmark move; `condition` states that it never
// moved.
void Window::collapse(const std::vector<int>& tracks) {
  if (tracks.empty()) return;
  for (const int track : tracks) {
    WindowLandmark& landmark = landmarks_.at(track);
    if (record_lives_) remember_chain(landmark);
    models_.collapse == Collapse::kCondition ? condition(landmark) : drop(landmark);
    landmark.noises.clear();
    landmark.noise_priors.clear();
    landmark.pixels.clear();
    landmark.chain.reset();
    landmark.w.reset();
    landmark.base = newest().position;
    linearise_at_truth(landmark);
  }
  if (models_.collapse != Collapse::kCondition) return;
  graph_.rebase_prior();
  const NormalEquations equations(graph_);
  const Step step = equations.step();
  graph_.move(step);
  estimate_camera(equations, step);
}

// From now on it is free: y stays what it is, at the newest frame, where a chain begins.
void Window::take_back(const Frame& frame) {
  for (const Observation& z : frame.observations) {
    const auto it = landmarks_.find(z.track);
    if (it == landmarks_.end() || !is_rejected(it->second.record, models_.labels)) continue;
    WindowLandmark& l = it->second;
    note_freed(l.record);
    if (record_lives_) remember_rest(l);
    l.base = newest().position;
    add_motion(l);
  }
}

// w and all noises are zero: the window's measurements are those of one point.
void Window::condition(WindowLandmark& landmark) {
  for (const WindowPixel& z : landmark.pixels) {
    if (z.depth > 0) graph_.remove_factor(z.factor);
  }
  for (const FactorId prior : landmark.noise_priors) graph_.remove_factor(prior);
  for (const VariableId noise : landmark.noises) graph_.remove_variables({noise});
  graph_.remove_factor(landmark.w_prior);
  graph_.fix_at_zero(*landmark.w);
  for (WindowPixel& z : landmark.pixels) {
    if (z.depth == 0) continue;
    z.depth = 0;
    measured(landmark, z);
  }
}

// The base advances to the newest frame; w and all noises are marginalised, and with them the
// window's measurements of the landmark.
void Window::drop(WindowLandmark& landmark) {
  std::set<VariableId> leaving{*landmark.w};
  std::vector<Advance> advances;
  Vector6d x;
  x << graph_.value(landmark.y), graph_.value(*landmark.w);
  for (std::size_t i = 0; i < landmark.noises.size(); ++i) {
    advances.push_back(advance(landmark, x, i));
    x = advances.back().next;
    leaving.insert(landmark.noises[i]);
  }
  marginalise(graph_, leaving, advances);
}

void Window::retire(FrameReport& report) {
  std::vector<int> lost;
  const CameraState c = state(newest());
  const Graph::Values far = graph_.far_values();
  const auto value = [&](VariableId id) {
    const auto it = far.find(id);
    return Eigen::Vector3d(it == far.end() ? graph_.value(id) : it->second);
  };
  for (auto& [track, landmark] : landmarks_) {
    const Eigen::Vector3d y = landmark.w
                                  ? Eigen::Vector3d(chain_states(graph_, landmark).back().head<3>())
                                  : value(landmark.y);
    report.negative_inverse_depth += y.z() < 0.0;
    if (landmark.record.unused_frames > 0) {
      note_unused(landmark.record,
                  in_view(setup_.camera, c.position, c.orientation, value(landmark.anchor), y));
    }
    if (is_lost(landmark.record, models_.policy)) lost.push_back(track);
  }
  if (lost.empty()) return;
  report.retired = estimate(lost);
  for (const int track : lost) {
    WindowLandmark& landmark = landmarks_.at(track);
    if (record_lives_) ended_lives_.push_back(life_so_far(landmark));
    if (graph_.far().contains(landmark.y)) {
      graph_.remove_variables({landmark.y});
      landmarks_.erase(track);
      continue;
    }
    if (landmark.w) {
      end_chain(landmark);
    } else {
      landmark.base = newest().position;  // the last frame that can have measured it
    }
    dead_.push_back(landmark);
    landmarks_.erase(track);
  }
}

}  // namespace slammot
