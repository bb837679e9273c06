#include "smoothers/solver/normal_equations.h"

#include "estimation/estimator.h"
#include "models/lapack.h"
#include "models/so3.h"
#include "smoothers/solver/camera_parts.h"

namespace slammot {

void NormalEquations::factorise(Graph& graph, const GraphCamera& camera, double damping) {
  camera_ = camera;
  turn_.setIdentity();
  place(graph);
  S_.resize(core_dim_, core_dim_);
  (*S_).setZero();
  g_.setZero(core_dim_);
  graph.prior().active.add_to(*S_, g_);
  add_cameras(graph);
  if (damping > 0.0) squares_ = (*S_).diagonal();
  add_blocks(graph, damping);
  if (damping > 0.0) (*S_).diagonal() += damping * squares_;
  factorise_core(graph);
  camera_columns_.resize(core_dim_, 0);
  for (Joint& joint : joints_) joint.is_new = false;
  forget_columns();
}

void NormalEquations::forget_columns() {
  columns_.resize(core_dim_, 0);
  cross_.resize(kCameraDim, 0);
  pieces_.clear();
  for (Joint& joint : joints_) joint.known = false;
}

// Rates that only motion factors tie, newest first; then poses, oldest first, each with position
// and orientation side by side; then the newest camera, the prior's variables in its order, and the
// rest. So the rates are eliminated cheaply (factorise_rates), and what is asked of the newest
// camera and the map lies in the last rows.
void NormalEquations::place(Graph& graph) {
  constexpr int kOfPrior = -2;
  core_dim_ = 0;
  const auto to_core = [&](Variable& v) {
    if (v.core >= 0 || v.is_constrained || v.is_considered) return;
    v.core = core_dim_;
    core_dim_ += v.dim();
  };
  graph.variables.for_each([](Variable& v) { v.core = -1; });
  for (const MarginalPrior::Block& block : graph.prior().active.blocks()) {
    const bool has_place = !block.variable->is_constrained && !block.variable->is_considered;
    if (has_place) graph.variables[block.variable->id].core = kOfPrior;
  }
  const auto& motions = graph.motions;
  for (std::size_t i = motions.size(); i-- > 1;) {
    Variable& rates = graph.variables[motions[i].from.rates];
    if (rates.core == kOfPrior) break;
    to_core(rates);
  }
  rates_dim_ = core_dim_;
  for (const CameraMotionFactor& f : motions) {
    to_core(graph.variables[f.from.position]);
    to_core(graph.variables[f.from.orientation]);
  }
  newest_core_ = core_dim_;
  for (const VariableId id : {camera_.position, camera_.orientation, camera_.rates}) {
    to_core(graph.variables[id]);
  }
  for (const MarginalPrior::Block& block : graph.prior().active.blocks()) {
    to_core(graph.variables[block.variable->id]);
  }
  graph.variables.for_each([&](Variable& v) {
    if (!v.is_private) to_core(v);
  });
  camera_core_[0] = graph.variables[camera_.position].core;
  camera_core_[1] = graph.variables[camera_.orientation].core;
  camera_core_[2] = graph.variables[camera_.rates].core;
}

// The rates of a few cameras at once. Those of one camera are tied to the poses of it and of its
// neighbours; once newer ones are eliminated also to all newer poses, which stand side by side, and
// to the next older rates.
void NormalEquations::factorise_core(const Graph& graph) {
  constexpr std::size_t kCameras = 4;
  auto S = *S_;
  bool is_definite = true;
  const auto& motions = graph.motions;
  const auto rates_core = [&](std::size_t i) {
    return graph.variables[motions[i].from.rates].core;
  };
  const int poses_end = newest_core_ + kCameraDim;
  for (std::size_t newest = motions.size() - 1, left = static_cast<std::size_t>(rates_dim_ / 6);
       left > 0 && is_definite;) {
    const std::size_t count = std::min(left, kCameras), next = newest - count;
    const int first = rates_core(newest), width = 6 * static_cast<int>(count);
    const int older = rates_core(next);
    const int poses = graph.variables[motions[next].from.position].core;
    auto L = S.block(first, first, width, width);
    auto rates = S.block(older, first, 6, width);
    auto pose = S.block(poses, first, poses_end - poses, width);
    is_definite = cholesky_in_place(L);
    L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(rates);
    L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(pose);
    S.block<6, 6>(older, older).noalias() -= rates * rates.transpose();
    if (older > poses) {
      S.block(older, poses, 6, pose.rows()).noalias() -= rates * pose.transpose();
    } else {
      S.block(poses, older, pose.rows(), 6).noalias() -= pose * rates.transpose();
    }
    S.block(poses, poses, pose.rows(), pose.rows())
        .selfadjointView<Eigen::Lower>()
        .rankUpdate(pose, -1.0);
    newest = next;
    left -= count;
  }
  const int rest = core_dim_ - rates_dim_;
  if (!is_definite || !cholesky_in_place(S.bottomRightCorner(rest, rest))) {
    throw Diverged("the information matrix of the window is not positive definite");
  }
}

namespace {

void add_product(const Graph& graph, const GraphCamera& camera_a, const Matrix12d& J_a,
                 const GraphCamera& camera_b, const Matrix12d& J_b, MatrixRef H) {
  const Matrix12d product = J_a.transpose() * J_b;
  for (const CameraPart& a : parts(camera_a)) {
    const int row = graph.variables[a.variable].core;
    for (const CameraPart& b : parts(camera_b)) {
      const int column = graph.variables[b.variable].core;
      if (row < column) continue;
      H.block(row, column, a.dim, b.dim) += product.block(a.column, b.column, a.dim, b.dim);
    }
  }
}

void add_gradient(const Graph& graph, const GraphCamera& camera, const Matrix12d& J,
                  const Vector12d& r, Eigen::VectorXd& g) {
  const Vector12d gradient = J.transpose() * r;
  for (const CameraPart& p : parts(camera)) {
    g.segment(graph.variables[p.variable].core, p.dim) += gradient.segment(p.column, p.dim);
  }
}

}  // namespace

void NormalEquations::add_cameras(const Graph& graph) {
  if (graph.initial) {
    const InitialCameraFactor& f = *graph.initial;
    add_product(graph, f.camera, f.J, f.camera, f.J, *S_);
    add_gradient(graph, f.camera, f.J, f.r, g_);
  }
  for (const CameraMotionFactor& f : graph.motions) {
    add_product(graph, f.from, f.J_from, f.from, f.J_from, *S_);
    add_product(graph, f.from, f.J_from, f.to, f.J_to, *S_);
    add_product(graph, f.to, f.J_to, f.from, f.J_from, *S_);
    add_product(graph, f.to, f.J_to, f.to, f.J_to, *S_);
    add_gradient(graph, f.from, f.J_from, f.r, g_);
    add_gradient(graph, f.to, f.J_to, f.r, g_);
  }
  if (graph.scene) {
    const int core = graph.variables[graph.scene->scene].core;
    (*S_)(core, core) += 1.0 / (graph.scene->sigma * graph.scene->sigma);
    g_(core) += graph.scene->r / graph.scene->sigma;
  }
}

void NormalEquations::add_blocks(const Graph& graph, double damping) {
  blocks_.resize(std::max(blocks_.size(), graph.landmarks.size()));
  joints_.resize(blocks_.size());
  for (std::size_t id = 0; id < graph.landmarks.size(); ++id) {
    const GraphLandmark& landmark = graph.landmarks[id];
    if (!graph.is_solved_jointly(landmark)) continue;
    blocks_[id].eliminate(graph, landmark, damping);
    blocks_[id].add_to(*S_, g_);
    if (damping > 0.0) blocks_[id].add_squares(squares_);
  }
}

void NormalEquations::add(const Graph& graph, LandmarkId id) {
  const auto i = static_cast<std::size_t>(id);
  blocks_.resize(std::max(blocks_.size(), i + 1));
  joints_.resize(blocks_.size());
  blocks_[i].eliminate(graph, graph[id], 0.0);
  joints_[i].known = false;
  joints_[i].is_new = true;
}

void NormalEquations::solve(Graph& graph) const {
  core_ = -g_;
  const auto L = (*S_).triangularView<Eigen::Lower>();
  L.solveInPlace(core_);
  L.transpose().solveInPlace(core_);
  if (!core_.allFinite()) throw Diverged("the step of the window is not finite");
  graph.variables.for_each([&](Variable& v) {
    if (v.core >= 0) v.step = core_.segment(v.core, v.dim());
    if (v.is_considered) v.step.setZero(v.dim());
  });
  for (std::size_t id = 0; id < graph.landmarks.size(); ++id) {
    GraphLandmark& landmark = graph.landmarks[id];
    if (graph.is_solved_jointly(landmark)) blocks_[id].step(core_, graph, landmark);
    if (!landmark.is_considered) continue;
    for (ChainStep& step : landmark.chain) step.step.setZero(step.noise.size());
  }
}

void NormalEquations::solve_considered(Graph& graph, LandmarkId id, double damping) {
  LandmarkBlock& block = blocks_[static_cast<std::size_t>(id)];
  block.eliminate(graph, graph[id], damping);
  core_.setZero(core_dim_);
  block.step(core_, graph, graph[id]);
}

void NormalEquations::follow_step(const Graph& graph) {
  if (graph.fixed_points()) return;
  turn_ = right_jacobian_so3(Eigen::Vector3d(graph.variables[camera_.orientation].step));
}

}  // namespace slammot
