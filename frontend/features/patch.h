// The patch of a point's first image, and its alignment in later images: what keeps a track from
// drifting from one thing to the next.
//
// Warp: image position = A x + t, x in the patch [-kHalf, kHalf]^2, A a 2x2 matrix; gain and bias
// of the brightness are taken out. Inverse compositional Gauss-Newton (Baker & Matthews, IJCV
// 2004): the gradients and the Hessian are those of the patch, computed once. Tracking frame to
// frame and then against the first frame under an affine warp is Shi & Tomasi's scheme (CVPR 1994).
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

namespace slammot {

struct Warp {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Eigen::Vector2d t = Eigen::Vector2d::Zero();  // [px], centre of the top-left pixel is (0, 0)
};

class Patch {
 public:
  static constexpr int kHalf = 6;
  static constexpr int kSide = 2 * kHalf + 1;
  static constexpr int kArea = kSide * kSide;

  // Of an 8-bit grey image around `centre`. Nothing if it reaches over the border, or if it holds
  // too little texture to say where it is.
  static std::optional<Patch> cut(const cv::Mat& image, const Eigen::Vector2d& centre);

  struct Fit {
    Warp warp;
    double correlation = 0.0;  // zero-mean normalised, of patch and warped image: at most 1
    double sigma = 0.0;        // of each coordinate, by what the warp leaves unexplained [px]
  };
  // From a first guess. Nothing if it leaves the image, does not converge, or is flattened or
  // magnified beyond what the patch can tell.
  std::optional<Fit> align(const cv::Mat& image, const Warp& guess) const;

  // Of its own place, each coordinate, under the noise of a camera's grey levels [px].
  double sigma() const { return sigma_; }

 private:
  using Values = Eigen::Matrix<double, kArea, 1>;

  double sigma_of(const Warp& warp, const Values& residual) const;

  Values values_;                              // zero mean, unit length
  Eigen::Matrix<double, kArea, 6> gradients_;  // d values / d (D by rows, d)
  Eigen::Matrix<double, 6, 6> inverse_hessian_;
  double sigma_ = 0.0;
};

}  // namespace slammot
