#include "frontend/odometry/two_view.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "models/so3.h"

namespace slammot {
namespace {

constexpr double kRansacCut = 1.0;        // [sigma] Sampson distance
constexpr double kCut = 2.5;              // the same of an inlier
constexpr double kLeastScale = 0.05;      // of the stated sigma; images without noise have none
constexpr double kNormalMedian = 1.4826;  // sigma over the median of |d|
constexpr double kConfidence = 0.999;     // of RANSAC
constexpr int kRounds = 4;                // of finding the inliers anew ...
constexpr int kSteps = 4;                 // ... and Gauss-Newton steps in each
constexpr std::size_t kMostPairs = 400;   // that are tried for a translation
constexpr double kLongestStep = 0.3;      // [rad] without translation t is not observable

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

double squared_gradient(const Eigen::Vector3d& Ex1, const Eigen::Vector3d& Etx2) {
  return Ex1.head<2>().squaredNorm() + Etx2.head<2>().squaredNorm();
}

double sampson_distance(const Eigen::Matrix3d& E, const Eigen::Vector3d& x1,
                        const Eigen::Vector3d& x2) {
  const Eigen::Vector3d Ex1 = E * x1, Etx2 = E.transpose() * x2;
  return std::abs(x2.dot(Ex1)) / std::sqrt(squared_gradient(Ex1, Etx2));
}

std::vector<double> distances(const RayMatches& m, const TwoView& pose) {
  const Eigen::Matrix3d E = hat(pose.t) * pose.R;
  std::vector<double> result;
  for (std::size_t i = 0; i < m.first.size(); ++i) {
    result.push_back(sampson_distance(E, m.first[i], m.second[i]));
  }
  return result;
}

void find_inliers(const RayMatches& m, double sigma, TwoView& pose) {
  const std::vector<double> d = distances(m, pose);
  pose.inliers.clear();
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (d[i] < kCut * sigma) pose.inliers.push_back(i);
  }
}

// What the inliers' distances show, at most the stated one: more is stated than there is where the
// images are good.
double shown_sigma(const RayMatches& m, const TwoView& pose, double stated) {
  const std::vector<double> all = distances(m, pose);
  std::vector<double> d;
  for (const std::size_t i : pose.inliers) d.push_back(all[i]);
  const auto middle = d.begin() + static_cast<std::ptrdiff_t>(d.size() / 2);
  std::ranges::nth_element(d, middle);
  return std::clamp(kNormalMedian * *middle, kLeastScale * stated, stated);
}

// R Exp(w), t + B b: with a = E' x2, d(x2' E x1) = w' (x1 x a) + b' B' (R x1 x x2). The gradient's
// length is held during a step.
void gauss_newton_step(const RayMatches& m, TwoView& pose) {
  const Eigen::Matrix3d E = hat(pose.t) * pose.R;
  Eigen::Matrix<double, 3, 2> B;
  B.col(0) = pose.t.unitOrthogonal();
  B.col(1) = pose.t.cross(B.col(0));
  Matrix5d H = Matrix5d::Zero();
  Vector5d g = Vector5d::Zero();
  for (const std::size_t i : pose.inliers) {
    const Eigen::Vector3d &x1 = m.first[i], &x2 = m.second[i];
    const Eigen::Vector3d Ex1 = E * x1, Etx2 = E.transpose() * x2;
    const double weight = 1.0 / squared_gradient(Ex1, Etx2);
    Vector5d J;
    J << x1.cross(Etx2), B.transpose() * (pose.R * x1).cross(x2);
    H += weight * J * J.transpose();
    g += weight * x2.dot(Ex1) * J;
  }
  H.diagonal().array() += 1e-12 * H.trace();
  Vector5d step = -H.ldlt().solve(g);
  if (!step.allFinite()) return;
  if (step.norm() > kLongestStep) step *= kLongestStep / step.norm();
  pose.R = pose.R * exp_so3(Eigen::Vector3d(step.head<3>())).toRotationMatrix();
  pose.t = (pose.t + B * step.tail<2>()).normalized();
}

double angle_of(const Eigen::Matrix3d& R) { return log_so3(Eigen::Quaterniond(R)).norm(); }

std::optional<TwoView> search_poses(const RayMatches& m, double sigma, Search search) {
  const auto plane = [](const std::vector<Eigen::Vector3d>& rays) {
    std::vector<cv::Point2d> points;
    for (const Eigen::Vector3d& x : rays) points.emplace_back(x.x(), x.y());
    return points;
  };
  // Its generator has a seed of its own in each call: the same matches give the same matrix.
  const int method = search == Search::kQuick ? cv::USAC_DEFAULT : cv::RANSAC;
  const cv::Mat E = cv::findEssentialMat(plane(m.first), plane(m.second), 1.0, {0.0, 0.0}, method,
                                         kConfidence, kRansacCut * sigma);
  if (E.rows != 3 || E.cols != 3) return std::nullopt;
  cv::Matx33d R1, R2;
  cv::Vec3d t;
  cv::decomposeEssentialMat(E, R1, R2, t);
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::Matrix3d first = Eigen::Map<const RowMajor>(R1.val);
  const Eigen::Matrix3d second = Eigen::Map<const RowMajor>(R2.val);
  TwoView pose;
  pose.R = angle_of(first) < angle_of(second) ? first : second;
  pose.t = Eigen::Map<const Eigen::Vector3d>(t.val);
  return pose;
}

// The translation of two matches that explains the most. Pairs are taken in equal steps of all
// there are: no inliers of another pose decide, which may be those of an object.
TwoView best_of_pairs(const RayMatches& m, double sigma, const Eigen::Matrix3d& R) {
  const std::size_t n = m.first.size();
  const std::size_t step = (n * (n - 1) / 2 + kMostPairs - 1) / kMostPairs;
  TwoView best;
  best.R = R;
  std::size_t pair = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d across_i = (R * m.first[i]).cross(m.second[i]);
    for (std::size_t j = i + 1; j < n; ++j) {
      if (pair++ % step != 0) continue;
      const Eigen::Vector3d t = across_i.cross((R * m.first[j]).cross(m.second[j]));
      if (!(t.norm() > 0.0)) continue;
      TwoView pose{R, t.normalized(), {}};
      find_inliers(m, sigma, pose);
      if (pose.inliers.size() > best.inliers.size()) best = pose;
    }
  }
  return best;
}

// With -t all depths change their signs.
void put_points_in_front(const RayMatches& m, TwoView& pose) {
  const auto in_front = std::ranges::count_if(pose.inliers, [&](std::size_t i) {
    return along(pose.t, pose.R * m.first[i], m.second[i]) > 0.0;
  });
  if (2 * static_cast<std::size_t>(in_front) < pose.inliers.size()) pose.t = -pose.t;
}

}  // namespace

Rays rays_by_track(const Camera& camera, const Frame& frame) {
  Rays rays;
  for (const Observation& z : frame.observations) {
    if (const auto bearing = camera.unproject(z.pixel)) rays[z.track] = bearing->ray;
  }
  return rays;
}

TrackMatches match_rays(const Rays& first, const Rays& second) {
  TrackMatches matches;
  for (const auto& [track, ray] : first) {
    const auto other = second.find(track);
    if (other == second.end()) continue;
    matches.tracks.push_back(track);
    matches.rays.first.push_back(ray);
    matches.rays.second.push_back(other->second);
  }
  return matches;
}

double ray_sigma(const Camera& camera, double pixel_sigma) {
  return 2.0 * pixel_sigma / (camera.fx + camera.fy);
}

double along(const Eigen::Vector3d& p, const Eigen::Vector3d& d, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d across = ray.cross(d);
  return -ray.cross(p).dot(across) / across.squaredNorm();
}

double parallax(const TwoView& pose, const RayMatches& m, std::size_t match) {
  const Eigen::Vector3d x1 = pose.R * m.first[match];
  const Eigen::Vector3d& x2 = m.second[match];
  return std::atan2(x1.cross(x2).norm(), x1.dot(x2));
}

std::optional<TwoView> relative_pose(const RayMatches& matches, double sigma, Search search) {
  if (matches.first.size() < kLeastMatches) return std::nullopt;
  std::optional<TwoView> pose = search_poses(matches, sigma, search);
  if (!pose) return std::nullopt;
  double shown = sigma;
  for (int round = 0; round < kRounds; ++round) {
    find_inliers(matches, shown, *pose);
    if (pose->inliers.size() < kLeastMatches) return std::nullopt;
    for (int step = 0; step < kSteps; ++step) gauss_newton_step(matches, *pose);
    shown = shown_sigma(matches, *pose, sigma);
  }
  put_points_in_front(matches, *pose);
  return pose;
}

// Where R is held, x2' [t]x R x1 is linear in t, and two matches determine it.
TwoView with_rotation(const RayMatches& matches, double sigma, const Eigen::Matrix3d& R) {
  TwoView held = best_of_pairs(matches, sigma, R);
  for (int round = 0; round < kRounds && held.inliers.size() >= kLeastMatches; ++round) {
    const Eigen::Matrix3d E = hat(held.t) * R;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const std::size_t i : held.inliers) {
      const Eigen::Vector3d &x1 = matches.first[i], &x2 = matches.second[i];
      const Eigen::Vector3d c = (R * x1).cross(x2);
      sum += c * c.transpose() / squared_gradient(E * x1, E.transpose() * x2);
    }
    if (!sum.allFinite()) break;
    TwoView next = held;
    // The eigenvector of the least eigenvalue.
    next.t = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(0);
    find_inliers(matches, sigma, next);
    if (next.inliers.size() < held.inliers.size()) break;
    held = next;
  }
  return held;
}

int explained(const RayMatches& matches, double sigma, const TwoView& pose) {
  TwoView counted = pose;
  find_inliers(matches, sigma, counted);
  return static_cast<int>(counted.inliers.size());
}

}  // namespace slammot
