// Free landmarks in the window: their chains grow with each frame, and their base moves on when the
// frame it stands in leaves.
#include <Eigen/LU>
#include <algorithm>

#include "models/landmarks/true_state.h"
#include "smoothers/graph/factors.h"
#include "smoothers/window/window_estimator.h"

namespace slammot {

// Thesis (2.5) with the acceleration noise of unknown and moving landmarks.
void Window::extend(WindowLandmark& landmark, double dt) {
  const Vector6d predicted = functions_.predict(chain_states(graph_, landmark).back(), dt);
  landmark.chain->steps.push_back(
      {dt, functions_.noise_root(predicted, setup_.prior.acceleration, dt)});
  const VariableId noise = graph_.add_variable(Vector6d::Zero(), nullptr, landmark.record.track);
  landmark.noises.push_back(noise);
  landmark.noise_priors.push_back(graph_.add_factor({noise}, noise_prior_cost()));
}

// From the base to the newest frame; where it is not known, predicted from the point before. What
// is labelled static stays where it was then.
std::vector<Vector6d> Window::true_chain(const WindowLandmark& l) const {
  const Eigen::Vector3d anchor = linearisation_point(graph_, l.anchor);
  Vector6d x;
  x << linearisation_point(graph_, l.y),
      l.w ? Eigen::Vector3d(linearisation_point(graph_, *l.w)) : Eigen::Vector3d::Zero();
  const auto base = std::find_if(frames_.begin(), frames_.end(),
                                 [&](const WindowFrame& f) { return f.position == l.base; });
  if (base == frames_.end()) return {x};
  std::vector<Vector6d> states;
  for (std::size_t i = 0; i <= l.noises.size(); ++i) {
    if (i > 0) x = functions_.predict(x, l.chain->steps[i - 1].dt);
    const int frame = (base + static_cast<std::ptrdiff_t>(i))->index;
    x = true_state(*truth_, functions_, l.record.track, frame, anchor).value_or(x);
    states.push_back(x);
  }
  return states;
}

void Window::linearise_at_truth(const WindowLandmark& l) {
  if (!truth_) return;
  const std::vector<Vector6d> states = true_chain(l);
  graph_.variable(l.y).linearisation_point = states.front().head<3>();
  if (!l.w) return;
  graph_.variable(*l.w).linearisation_point = states.front().tail<3>();
  const auto noises = lead_through(*l.chain, states, setup_.prior.acceleration);
  for (std::size_t i = 0; i < noises.size(); ++i)
    graph_.variable(l.noises[i]).linearisation_point = noises[i];
}

double Window::refresh_noises() {
  if (truth_) return 0.0;  // they are those of the true states
  const double sigma = setup_.prior.acceleration;
  double change = 0.0;
  for (auto& [track, l] : landmarks_)
    change = std::max(change, slammot::refresh_noises(graph_, l, sigma));
  for (WindowLandmark& l : dead_)
    change = std::max(change, slammot::refresh_noises(graph_, l, sigma));
  return change;
}

WindowPixel Window::measured(const WindowLandmark& landmark, const MeasuredPixel& z) {
  return {z, add_pixel(graph_, landmark, z, setup_.camera, setup_.pixel_sigma, loss_.get())};
}

// The substitution that takes the base, now at `from`, over one step.
Advance Window::advance(const WindowLandmark& landmark, const Vector6d& from,
                        std::size_t step) const {
  const ChainStep& s = landmark.chain->steps[step];
  const VariableId noise = landmark.noises[step];
  Advance a{landmark.y, *landmark.w, noise, {}, s.G, {}};
  const Vector6d at = truth_ ? true_chain(landmark)[step] : from;
  a.F_inverse = functions_.predict_jacobian(at, s.dt).inverse();
  a.next = functions_.predict(from, s.dt) + s.G * graph_.value(noise);
  return a;
}

// The frame of the base leaves: the base advances by one step, or leaves with it when the chain has
// ended. Measurements of later frames are taken out; enter_base puts them back.
std::vector<Advance> Window::leave_base(WindowLandmark& landmark, std::set<VariableId>& leaving) {
  if (landmark.noises.empty()) {
    leaving.insert(landmark.y);
    if (landmark.w) leaving.insert(*landmark.w);
    return {};
  }
  const Vector6d x = chain_states(graph_, landmark).front();
  if (record_lives_) landmark.life.states.push_back(x);
  leaving.insert(landmark.noises.front());
  for (const WindowPixel& z : landmark.pixels) {
    if (z.depth > 0) graph_.remove_factor(z.factor);
  }
  return {advance(landmark, x, 0)};
}

void Window::enter_base(WindowLandmark& landmark, VariableId base) {
  if (landmark.noises.empty()) return;  // it left
  landmark.base = base;
  landmark.noises.erase(landmark.noises.begin());
  landmark.noise_priors.erase(landmark.noise_priors.begin());
  landmark.chain->steps.erase(landmark.chain->steps.begin());
  linearise_at_truth(landmark);
  std::erase_if(landmark.pixels, [](const WindowPixel& z) { return z.depth == 0; });
  for (WindowPixel& z : landmark.pixels) {
    --z.depth;
    z = measured(landmark, z);
  }
}

void Window::remember_chain(WindowLandmark& l) const {
  std::vector<Vector6d> x = chain_states(graph_, l);
  x.pop_back();
  l.life.states.insert(l.life.states.end(), x.begin(), x.end());
}

void Window::remember_rest(WindowLandmark& l) const {
  const auto frames = static_cast<std::size_t>(frames_.back().number - l.life.birth);
  Vector6d at_rest = Vector6d::Zero();
  at_rest.head<3>() = graph_.value(l.y);
  while (l.life.states.size() < frames) l.life.states.push_back(at_rest);
}

LandmarkLife Window::life_so_far(const WindowLandmark& landmark) const {
  WindowLandmark l = landmark;
  l.life.record = l.record;
  if (!l.life.is_free()) {
    l.life.states = {newest_state(graph_, l).x};
    return l.life;
  }
  if (!l.w) {
    remember_rest(l);
    l.life.states.push_back(newest_state(graph_, l).x);
    return l.life;
  }
  for (const Vector6d& x : chain_states(graph_, l)) l.life.states.push_back(x);
  return l.life;
}

// Steps after the last measurement say nothing: they go at once.
void Window::end_chain(WindowLandmark& landmark) {
  int last = 0;
  for (const WindowPixel& z : landmark.pixels) last = std::max(last, z.depth);
  while (static_cast<int>(landmark.noises.size()) > last) {
    graph_.remove_factor(landmark.noise_priors.back());
    graph_.remove_variables({landmark.noises.back()});
    landmark.noises.pop_back();
    landmark.noise_priors.pop_back();
    landmark.chain->steps.pop_back();
  }
}

}  // namespace slammot
