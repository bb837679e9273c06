#include "smoothers/graph/graph.h"

#include "smoothers/graph/chain_step.h"
#include "smoothers/graph/least_noise.h"

namespace slammot {

GraphCamera Graph::add_camera(const CameraState& x) {
  GraphCamera camera;
  Vector6d rates;
  rates << x.velocity, x.angular_velocity;
  Variable& position = variables.add(x.position, false, false);
  position.orbit = {ScaleOrbit::Kind::kPosition, models_.centre};
  camera.position = position.id;
  camera.orientation = variables.add(x.orientation.coeffs(), true, false).id;
  Variable& of_motion = variables.add(rates, false, false);
  of_motion.orbit.kind = ScaleOrbit::Kind::kRates;
  camera.rates = of_motion.id;
  return camera;
}

namespace {

CameraState camera_state(const SmallVector& position, const SmallVector& orientation,
                         const SmallVector& rates) {
  CameraState x;
  x.position = position;
  x.orientation.coeffs() = orientation;
  x.velocity = rates.head<3>();
  x.angular_velocity = rates.tail<3>();
  return x;
}

}  // namespace

CameraState Graph::camera(const GraphCamera& c) const {
  return camera_state(variables[c.position].value, variables[c.orientation].value,
                      variables[c.rates].value);
}

CameraState Graph::linearisation_point(const GraphCamera& c) const {
  return camera_state(variables[c.position].point(), variables[c.orientation].point(),
                      variables[c.rates].point());
}

void Graph::add_initial(const GraphCamera& camera, const InitialCamera& prior) {
  initial.emplace();
  initial->camera = camera;
  initial->initial = prior;
  linearise(*initial);
}

void Graph::add_motion(const GraphCamera& from, const GraphCamera& to, const Matrix12d& Q,
                       double dt) {
  const Matrix12d weight = square_root_information(Q);
  CameraMotionFactor& factor = motions.emplace_back();
  factor.from = from;
  factor.to = to;
  factor.weight = weight;
  factor.dt = dt;
  linearise(factor);
}

void Graph::widen_newest_motion(double factor) {
  CameraMotionFactor& motion = motions.back();
  motion.weight /= std::sqrt(factor);
  linearise(motion);
}

void Graph::add_scene(const LandmarkPrior& prior) {
  Variable& mean = variables.add(SmallVector::Constant(1, prior.inverse_depth), false, false);
  mean.orbit.kind = ScaleOrbit::Kind::kInverse;
  scene = {mean.id, prior.inverse_depth, prior.mean_sigma, 0.0};
}

LandmarkId Graph::add_landmark(VariableId anchor, const Eigen::Vector3d& y) {
  auto id = static_cast<LandmarkId>(landmarks.size());
  if (vacant_.empty()) {
    landmarks.emplace_back();
  } else {
    id = vacant_.back();
    vacant_.pop_back();
  }
  GraphLandmark& landmark = (*this)[id];
  landmark.is_alive = true;
  landmark.anchor = anchor;
  Variable& of_point = variables.add(y, false, true);
  of_point.orbit = {ScaleOrbit::Kind::kPoint, Eigen::Vector3d::Zero(), &models_.point()};
  landmark.y = of_point.id;
  return id;
}

// The slot's lists keep their memory.
void Graph::remove_landmark(LandmarkId id) {
  GraphLandmark& landmark = (*this)[id];
  landmark.is_alive = landmark.is_considered = false;
  landmark.w = -1;
  landmark.w_prior = {};
  landmark.constrained.reset();
  landmark.chain.clear();
  landmark.pixels.clear();
  landmark.birth = {};
  vacant_.push_back(id);
}

void Graph::free_landmark(LandmarkId id, const MotionVector& sigmas) {
  GraphLandmark& landmark = (*this)[id];
  Variable& w = variables.add(SmallVector::Zero(sigmas.size()), false, true);
  if (models_.landmark->motion_in_metres) w.orbit.kind = ScaleOrbit::Kind::kLength;
  landmark.w = w.id;
  const Eigen::Vector3d y = variables[landmark.y].value;
  landmark.w_prior.sigmas = sigmas;
  landmark.w_prior.unit = unit_of_motion(models_, y);
  linearise_motion_prior(models_, y, w.value, landmark.w_prior);
}

void Graph::constrain_to_rest(LandmarkId id, double rest_time) {
  GraphLandmark& l = (*this)[id];
  Variable& w = variables[l.w];
  w.value.setZero();
  w.step.setZero(w.dim());
  w.is_constrained = true;
  linearise_motion_prior(models_, variables[l.y].value, w.value, l.w_prior);
  l.constrained = ConstrainedMotion{l.w, l.w_prior, rest_time};
  l.w = -1;
  l.w_prior = {};
  l.chain.clear();
  const Variable& y = variables[l.y];
  for (GraphPixel& pixel : l.pixels) {
    if (pixel.depth > 0) {
      pixel.depth = 0;
      linearise_pixel(pixel, l, y.value, y.point());
    } else {
      linearise_motion(pixel, l,
                       y.point());  // at the base, where it says nothing of w
    }
  }
}

void Graph::release_motion(LandmarkId id) {
  GraphLandmark& l = (*this)[id];
  l.w = l.constrained->w;
  l.w_prior = l.constrained->prior;
  l.constrained.reset();
  variables[l.w].is_constrained = false;
}

void Graph::forget_motion(LandmarkId id) {
  GraphLandmark& l = (*this)[id];
  if (!l.constrained) return;
  prior_.condition_on_zero(l.constrained->w);
  variables.remove(l.constrained->w);
  l.constrained.reset();
  for (GraphPixel& pixel : l.pixels) pixel.J_w.resize(2, 0);
}

void Graph::consider(LandmarkId id, bool is_considered) {
  GraphLandmark& l = (*this)[id];
  if (l.is_considered == is_considered) return;
  l.is_considered = is_considered;
  variables[l.y].is_considered = is_considered;
  if (l.is_free()) variables[l.w].is_considered = is_considered;
  prior_.active.own_variables_changed();
}

void Graph::add_pixel(LandmarkId id, const GraphCamera& camera, const Observation& z, int depth) {
  GraphLandmark& landmark = (*this)[id];
  GraphPixel& added = landmark.pixels.emplace_back();
  added.position = camera.position;
  added.orientation = camera.orientation;
  added.depth = depth;
  added.time = camera.time;
  added.z = {z.pixel, camera.position == landmark.anchor, z.relative_sigma, z.camera};
}

void Graph::reactivate(const std::vector<VariableId>& ids) {
  if (ids.empty()) return;
  const ScaleChart& b = prior_.active.chart();
  for (const VariableId id : ids) variables[id].value = prior_.inactive.value(id, b);
  const auto back = prior_.inactive.reactivate(ids, prior_.active.chart_at_origin());
  std::vector<Variable*> returning;
  for (const VariableId id : ids) {
    variables[id].is_active = true;
    returning.push_back(&variables[id]);
  }
  prior_.active.join(returning, back.mean, back.K, back.U);
}

SmallVector Graph::value(VariableId id) const {
  const Variable& v = variables[id];
  return v.is_active ? v.value : prior_.inactive.value(id, prior_.active.chart());
}

LandmarkVector Graph::newest_state(const GraphLandmark& l) const {
  if (!l.is_free()) return value(l.y);
  LandmarkVector x = landmark_state(variables[l.y].value, variables[l.w].value);
  for (const ChainStep& step : l.chain) {
    x = advance(models_, step, x, step.noise);
  }
  return x;
}

std::vector<LandmarkVector> Graph::states(const GraphLandmark& l) const {
  if (!l.is_free()) return {LandmarkVector(value(l.y))};
  std::vector<LandmarkVector> x{landmark_state(variables[l.y].value, variables[l.w].value)};
  for (const ChainStep& step : l.chain) {
    x.push_back(advance(models_, step, x.back(), step.noise));
  }
  return x;
}

double Graph::refresh_noises(GraphLandmark& l) {
  if (!l.is_free()) return 0.0;
  double change = 0.0;
  LandmarkVector before = landmark_state(variables[l.y].value, variables[l.w].value);
  LandmarkVector x = before;
  for (ChainStep& step : l.chain) {
    before = advance(models_, step, before, step.noise);
    x = models_.landmark->predict(x, step.dt);
    step.G = models_.landmark->noise_root(x, models_.prior.noise(step.is_moving), step.dt);
    step.unit = unit_of_motion(models_, x.head<3>());
    const LandmarkVector noise = least_noise(step.G, before - x);
    x += step.G.lazyProduct(noise);
    change = std::max(change, (noise - step.noise).cwiseAbs().maxCoeff());
    step.noise = noise;
  }
  return change;
}

}  // namespace slammot
