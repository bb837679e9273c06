// The normal equations of a graph's stored linearisation, factorised once: the Gauss-Newton step
// and every marginal covariance are read from the same factorisation, until the graph is solved
// anew.
//
// The private variables of each landmark are eliminated first (landmark_block.h), and the core that
// is left (cameras, anchors, everything in the prior) by one dense Cholesky factor:
//   S = U + sum of the blocks' information,   Sigma_core = S^-1.
#pragma once

#include <span>

#include "smoothers/solver/landmark_block.h"

namespace slammot {

inline constexpr int kMaxJoint = kCameraDim + 3 + kMaxLandmark;
using JointMatrix = BoundedMatrix<Eigen::Dynamic, Eigen::Dynamic, kMaxJoint, kMaxJoint>;

class NormalEquations {
 public:
  // `camera`: whose marginal will be asked for. `damping` multiplies the diagonal of H by
  // 1 + damping (Marquardt 1963); covariances want none. Throws Diverged when H is not positive
  // definite. Considered landmarks have no part in it, and wait for add().
  void factorise(Graph& graph, const GraphCamera& camera, double damping = 0.0);

  // dx = -H^-1 J'r, as Variable::step and ChainStep::step, of all but considered landmarks. Throws
  // Diverged when it is not finite.
  void solve(Graph& graph) const;

  // After solve() and Graph::retract(): marginals are asked for in the tangent spaces there.
  // (Before, or when no step was taken, in those of the linearisation.)
  void follow_step(const Graph& graph);

  // The step of a considered landmark given the core, which stays where it is.
  void solve_considered(Graph& graph, LandmarkId id, double damping);

  // Eliminates one landmark while the core stays as it is: one that has been added since, which
  // says nothing about the core yet, or a considered one, which never does.
  void add(const Graph& graph, LandmarkId id);

  // Covariance of the camera; and of any other of the graph, at the linearisation.
  Matrix12d camera_covariance();
  Matrix12d camera_covariance(const Graph& graph, const GraphCamera& camera) const;

  // Joint covariance of the camera (12), a landmark's anchor (3) and its newest state as it was
  // when these equations were built (y alone when static). Landmarks are to be announced together,
  // which is faster. Their columns are kept until the next factorise(), unless they are forgotten.
  void prepare(const Graph& graph, std::span<const LandmarkId> landmarks);
  void forget_columns();
  const JointMatrix& joint(LandmarkId id) const {
    return joints_[static_cast<std::size_t>(id)].covariance;
  }
  // Chain steps that this newest state lies after the base.
  int steps(LandmarkId id) const { return blocks_[static_cast<std::size_t>(id)].steps(); }
  int state_dim(const Graph& graph, LandmarkId id) const;

  // C := L^-1 d(camera, anchor, newest state)' / d(core) H', for H 2 x (as joint(), or camera
  // alone), so that C_i' C_j is what two pixels share. After prepare(), and of one that was in it.
  void project(LandmarkId id, const Eigen::Ref<const Eigen::MatrixXd>& H,
               Eigen::Ref<Eigen::MatrixXd> C) const;

  // For questions of other kinds: C := L^-1 C, so that C'C is the covariance of C' core.
  int core_dim() const { return core_dim_; }
  void whiten(Eigen::Ref<Eigen::MatrixXd> C) const;
  const LandmarkBlock& block(LandmarkId id) const { return blocks_[static_cast<std::size_t>(id)]; }

 private:
  struct Joint {
    bool known = false;
    bool is_new = false;        // add()
    int anchor = 0, state = 0;  // pieces
    JointMatrix covariance;
  };

  // Columns that have been asked for: of an anchor, or of a newest state. Rows of the core before
  // `first` do not concern them.
  struct Piece {
    VariableId anchor = -1;
    int first = 0, dim = 0;
    Eigen::Index column = 0;
  };

  void place(Graph& graph);
  void factorise_core(const Graph& graph);
  void compute_camera();
  void ask(const Graph& graph, LandmarkId id);
  void place_pieces(std::size_t first);
  void fill_columns(const Graph& graph, LandmarkId id);
  void solve_pieces();
  void fill_joint(LandmarkId id);
  const Piece& piece(int i) const { return pieces_[static_cast<std::size_t>(i)]; }
  void add_cameras(const Graph& graph);
  void add_blocks(const Graph& graph, double damping);
  void columns_of(const Graph& graph, VariableId id, Eigen::Ref<Eigen::MatrixXd> E) const;
  void state_columns(const Graph& graph, LandmarkId id, Eigen::Ref<Eigen::MatrixXd> E,
                     LandmarkMatrix& own) const;
  void inactive_covariance(const Graph& graph, const GraphLandmark& landmark,
                           JointMatrix& covariance) const;

  GraphCamera camera_;
  int camera_core_[3] = {0, 0, 0};
  int core_dim_ = 0, rates_dim_ = 0, newest_core_ = 0;  // the rates' rows come first
  GrowingMatrix S_;                                     // lower triangle; its Cholesky factor
  Eigen::VectorXd g_, squares_;
  mutable Eigen::VectorXd core_;
  std::vector<LandmarkBlock> blocks_;  // by LandmarkId
  std::vector<Joint> joints_;          // by LandmarkId
  GrowingMatrix camera_columns_;       // L^-1 of the camera's, 12 of them
  Matrix12d camera_covariance_;
  Eigen::Matrix3d turn_;       // right Jacobian of the camera's last step
  std::vector<Piece> pieces_;  // since factorise()
  GrowingMatrix columns_;      // theirs, L^-1 E
  GrowingMatrix cross_;        // the camera's columns' times them

  // Of one prepare(), kept for their memory.
  std::vector<LandmarkId> asked_;
  std::vector<Piece*> sorted_;  // new ones, by first row
};

}  // namespace slammot
