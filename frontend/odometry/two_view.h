// The relative pose of two images from rays that match: five-point RANSAC (OpenCV), then the least
// squares of the Sampson distances over all inliers.
//
// x2 ~ R x1 + t with |t| = 1, and x2' [t]x R x1 = 0. Of the two rotations of an essential matrix
// the smaller is taken: the other one is half a turn about the baseline away. The sign of t puts
// most points before the camera.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "models/camera.h"
#include "models/measurement.h"

namespace slammot {

// On the normalised plane, z = 1.
struct RayMatches {
  std::vector<Eigen::Vector3d> first, second;
};

using Rays = std::map<int, Eigen::Vector3d>;  // by track, z = 1
Rays rays_by_track(const Camera& camera, const Frame& frame);

// Tracks that both have, in increasing order.
struct TrackMatches {
  std::vector<int> tracks;
  RayMatches rays;
};
TrackMatches match_rays(const Rays& first, const Rays& second);

// Of a coordinate of a ray. One for all matches: OpenCV's search takes a single threshold.
double ray_sigma(const Camera& camera, double pixel_sigma);

struct TwoView {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // from the first camera to the second
  Eigen::Vector3d t = Eigen::Vector3d::UnitZ();     // in the second camera, of unit length
  std::vector<std::size_t> inliers;                 // places of the matches
};

// RANSAC, or OpenCV's USAC, which takes a quarter of the time and explains as many matches in the
// mean. On a plane it takes the wrong one of two solutions more often.
enum class Search { kThorough, kQuick };

// `sigma`: ray_sigma(). Nothing where too few agree.
std::optional<TwoView> relative_pose(const RayMatches& matches, double sigma,
                                     Search search = Search::kThorough);

// With the translation that suits this rotation best. Without inliers where none does.
TwoView with_rotation(const RayMatches& matches, double sigma, const Eigen::Matrix3d& R);

// How many matches are within what `sigma` allows of their epipolar lines.
int explained(const RayMatches& matches, double sigma, const TwoView& pose);

// The s for which `p + s * d` points along `ray`, in least squares of their cross product.
double along(const Eigen::Vector3d& p, const Eigen::Vector3d& d, const Eigen::Vector3d& ray);

// Of the match between the two cameras, without the rotation between them [rad].
double parallax(const TwoView& pose, const RayMatches& matches, std::size_t match);

// The least number of matches that must agree.
inline constexpr std::size_t kLeastMatches = 8;

}  // namespace slammot
