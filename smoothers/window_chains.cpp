// Free landmarks in the window: their chains grow with each frame, and their base moves on when the
// frame it stands in leaves.
#include <Eigen/LU>

#include "slammot/smoothers/factors.h"
#include "slammot/smoothers/window_estimator.h"

namespace slammot {

namespace {

Vector6d base_state(const Graph& graph, const WindowLandmark& landmark) {
  Vector6d x;
  x << graph.value(landmark.y), graph.value(*landmark.w);
  return x;
}

std::vector<Vector6d> noise_values(const Graph& graph, const WindowLandmark& landmark) {
  std::vector<Vector6d> noises;
  for (const ChainNoise& n : landmark.noises) noises.emplace_back(graph.value(n.id));
  return noises;
}

}  // namespace

ChainState Window::newest_state(const WindowLandmark& landmark) const {
  if (!landmark.w) return static_state(graph_.value(landmark.y));
  return propagate(*landmark.chain, base_state(graph_, landmark), noise_values(graph_, landmark));
}

std::vector<Vector6d> Window::chain_states(const WindowLandmark& landmark) const {
  return states(*landmark.chain, base_state(graph_, landmark), noise_values(graph_, landmark));
}

// The variables that newest_state's Jacobian stands for.
std::vector<VariableId> Window::state_variables(const WindowLandmark& landmark) const {
  std::vector<VariableId> variables{landmark.y};
  if (landmark.w) variables.push_back(*landmark.w);
  for (const ChainNoise& n : landmark.noises) variables.push_back(n.id);
  return variables;
}

// Thesis (2.5) with the acceleration noise of unknown and moving landmarks.
void Window::extend(WindowLandmark& landmark, double dt) {
  const Vector6d predicted = functions_.predict(newest_state(landmark).x, dt);
  landmark.chain->steps.push_back(
      {dt, functions_.noise_root(predicted, setup_.prior.acceleration, dt)});
  const VariableId noise = graph_.add_variable(Vector6d::Zero(), nullptr, landmark.record.track);
  landmark.noises.push_back({noise, graph_.add_factor({noise}, noise_prior_cost())});
}

double Window::refresh_noise(WindowLandmark& landmark) {
  const std::vector<Vector6d> noises =
      lead_through(*landmark.chain, chain_states(landmark), setup_.prior.acceleration);
  double change = 0.0;
  for (std::size_t i = 0; i < noises.size(); ++i) {
    const VariableId id = landmark.noises[i].id;
    change = std::max(change, (noises[i] - graph_.value(id)).cwiseAbs().maxCoeff());
    graph_.set_value(id, noises[i]);
  }
  return change;
}

double Window::refresh_noises() {
  double change = 0.0;
  for (auto& [track, landmark] : landmarks_) {
    if (landmark.w) change = std::max(change, refresh_noise(landmark));
  }
  for (WindowLandmark& landmark : dead_) {
    if (landmark.w) change = std::max(change, refresh_noise(landmark));
  }
  return change;
}

FactorId Window::add_pixel(const WindowLandmark& landmark, const WindowPixel& z) {
  const double sigma = setup_.pixel_sigma;
  if (z.position == landmark.anchor) {
    return graph_.add_factor({z.motion, landmark.y},
                             first_pixel_cost(setup_.camera, z.pixel, sigma), loss_.get());
  }
  std::vector<VariableId> variables{z.position, z.motion, landmark.anchor, landmark.y};
  if (z.depth == 0) {
    return graph_.add_factor(variables, pixel_cost(setup_.camera, z.pixel, sigma), loss_.get());
  }
  variables.push_back(*landmark.w);
  for (int i = 0; i < z.depth; ++i) {
    variables.push_back(landmark.noises[static_cast<std::size_t>(i)].id);
  }
  return graph_.add_factor(
      variables,
      std::make_unique<ChainPixelCost>(setup_.camera, z.pixel, sigma, landmark.chain, z.depth),
      loss_.get());
}

// The substitution that takes the base, now at `from`, over one step.
Advance Window::advance(const WindowLandmark& landmark, const Vector6d& from,
                        std::size_t step) const {
  const ChainStep& s = landmark.chain->steps[step];
  const VariableId noise = landmark.noises[step].id;
  Advance a{landmark.y, *landmark.w, noise, {}, s.G, {}};
  a.F_inverse = functions_.predict_jacobian(from, s.dt).inverse();
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
  const Vector6d x = base_state(graph_, landmark);
  if (record_lives_) landmark.life.states.push_back(x);
  leaving.insert(landmark.noises.front().id);
  for (const WindowPixel& z : landmark.pixels) {
    if (z.depth > 0) graph_.remove_factor(z.factor);
  }
  return {advance(landmark, x, 0)};
}

void Window::enter_base(WindowLandmark& landmark, VariableId base) {
  if (landmark.noises.empty()) return;  // it left
  landmark.base = base;
  landmark.noises.erase(landmark.noises.begin());
  landmark.chain->steps.erase(landmark.chain->steps.begin());
  std::erase_if(landmark.pixels, [](const WindowPixel& z) { return z.depth == 0; });
  for (WindowPixel& z : landmark.pixels) {
    --z.depth;
    z.factor = add_pixel(landmark, z);
  }
}

LandmarkLife Window::life_so_far(const WindowLandmark& landmark) const {
  LandmarkLife life = landmark.life;
  life.record = landmark.record;
  if (!landmark.w) {
    life.states = {newest_state(landmark).x};
    return life;
  }
  for (const Vector6d& x : chain_states(landmark)) life.states.push_back(x);
  return life;
}

// Steps after the last measurement say nothing: they go at once.
void Window::end_chain(WindowLandmark& landmark) {
  int last = 0;
  for (const WindowPixel& z : landmark.pixels) last = std::max(last, z.depth);
  while (static_cast<int>(landmark.noises.size()) > last) {
    graph_.remove_factor(landmark.noises.back().prior);
    graph_.remove_variables({landmark.noises.back().id});
    landmark.noises.pop_back();
    landmark.chain->steps.pop_back();
  }
}

}  // namespace slammot
