#include "smoothers/window/free_landmarks.h"

#include <Eigen/LU>
#include <algorithm>

#include "smoothers/factors/factors.h"

namespace slammot {

WindowPixel FreeLandmarks::measure(const WindowLandmark& l, const MeasuredPixel& z) {
  return {z, add_pixel(graph_, l, z, setup_.camera, setup_.pixel_sigma, loss_)};
}

void FreeLandmarks::start(WindowLandmark& l, const LandmarkPrior& prior) {
  l.w = graph_.add_variable(Eigen::VectorXd::Zero(functions_.motion), nullptr, l.track);
  l.w_prior = graph_.add_factor({*l.w}, motion_prior_cost(functions_.prior_sigmas(prior)));
  l.chain = std::make_shared<Chain>(Chain{&functions_, {}});
  truth_.apply(l);
}

void FreeLandmarks::extend(WindowLandmark& l, double dt) {
  const LandmarkVector predicted = functions_.predict(chain_states(graph_, l).back(), dt);
  l.chain->steps.push_back({dt, functions_.noise_root(predicted, setup_.prior, dt)});
  const VariableId noise =
      graph_.add_variable(Eigen::VectorXd::Zero(functions_.dim()), nullptr, l.track);
  l.noises.push_back(noise);
  l.noise_priors.push_back(graph_.add_factor({noise}, noise_prior_cost(functions_.dim())));
  truth_.apply(l);
}

double FreeLandmarks::refresh_noises(WindowLandmark& l) {
  if (truth_) return 0.0;  // they are those of the true states
  return slammot::refresh_noises(graph_, l, setup_.prior);
}

// The substitution that takes the base, now at `from`, over one step.
Advance FreeLandmarks::advance(const WindowLandmark& l, const LandmarkVector& from,
                               std::size_t step) const {
  const ChainStep& s = l.chain->steps[step];
  const VariableId noise = l.noises[step];
  Advance a{l.y, *l.w, noise, {}, s.G, {}};
  const LandmarkVector at = truth_ ? truth_.states(l)[step] : from;
  a.F_inverse = functions_.predict_jacobian(at, s.dt).inverse();
  a.next = functions_.predict(from, s.dt) + s.G * graph_.value(noise);
  return a;
}

std::vector<Advance> FreeLandmarks::release_base(WindowLandmark& l, std::set<VariableId>& leaving) {
  if (l.noises.empty()) {
    leaving.insert(l.y);
    if (l.w) leaving.insert(*l.w);
    return {};
  }
  leaving.insert(l.noises.front());
  for (const WindowPixel& z : l.pixels) {
    if (z.depth > 0) graph_.remove_factor(z.factor);
  }
  return {advance(l, chain_states(graph_, l).front(), 0)};
}

void FreeLandmarks::shift_base(WindowLandmark& l, VariableId base) {
  if (l.noises.empty()) return;  // it left
  l.base = base;
  l.noises.erase(l.noises.begin());
  l.noise_priors.erase(l.noise_priors.begin());
  l.chain->steps.erase(l.chain->steps.begin());
  truth_.apply(l);
  std::erase_if(l.pixels, [](const WindowPixel& z) { return z.depth == 0; });
  for (WindowPixel& z : l.pixels) {
    --z.depth;
    z = measure(l, z);
  }
}

void FreeLandmarks::end(WindowLandmark& l) {
  int last = 0;
  for (const WindowPixel& z : l.pixels) last = std::max(last, z.depth);
  while (static_cast<int>(l.noises.size()) > last) {
    graph_.remove_factor(l.noise_priors.back());
    graph_.remove_variables({l.noises.back()});
    l.noises.pop_back();
    l.noise_priors.pop_back();
    l.chain->steps.pop_back();
  }
}

void FreeLandmarks::condition(WindowLandmark& l) {
  for (const WindowPixel& z : l.pixels) {
    if (z.depth > 0) graph_.remove_factor(z.factor);
  }
  for (const FactorId prior : l.noise_priors) graph_.remove_factor(prior);
  for (const VariableId noise : l.noises) graph_.remove_variables({noise});
  graph_.remove_factor(l.w_prior);
  graph_.prior().condition_on_zero(*l.w);
  graph_.remove_variables({*l.w});
  for (WindowPixel& z : l.pixels) {
    if (z.depth == 0) continue;
    z.depth = 0;
    measure(l, z);
  }
  forget_chain(l);
}

void FreeLandmarks::drop(WindowLandmark& l) {
  std::set<VariableId> leaving{*l.w};
  std::vector<Advance> advances;
  LandmarkVector x = chain_states(graph_, l).front();
  for (std::size_t i = 0; i < l.noises.size(); ++i) {
    advances.push_back(advance(l, x, i));
    x = advances.back().next;
    leaving.insert(l.noises[i]);
  }
  marginalise(graph_, leaving, advances);
  forget_chain(l);
}

void FreeLandmarks::forget_chain(WindowLandmark& l) {
  l.noises.clear();
  l.noise_priors.clear();
  l.pixels.clear();
  l.chain.reset();
  l.w.reset();
}

}  // namespace slammot
