#include "frontend/rendering/render.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "datasets/simulation/random/random_stream.h"

namespace slammot {
namespace {

constexpr int kExposureSteps = 8;

// Rays of all samples of all pixels in the camera frame, row by row.
std::vector<Eigen::Vector3d> sample_rays(const Camera& camera, int n) {
  std::vector<Eigen::Vector3d> rays;
  for (int v = 0; v < camera.height * n; ++v) {
    for (int u = 0; u < camera.width * n; ++u) {
      const Eigen::Vector2d pixel((u + 0.5) / n - 0.5, (v + 0.5) / n - 0.5);
      const auto bearing = camera.unproject(pixel);
      if (!bearing) throw std::invalid_argument("the lens has no inverse at the image's corner");
      rays.push_back(bearing->ray);
    }
  }
  return rays;
}

cv::Mat instant(const Room& room, const MountedCamera& camera, int n,
                const std::vector<Eigen::Vector3d>& rays, double time) {
  const cv::Size size(camera.lens.width, camera.lens.height);
  const CameraState first = room.camera_at(time);
  const Eigen::Vector3d from = first.position + first.orientation * camera.t;
  const Eigen::Matrix3d R = (first.orientation * camera.R).toRotationMatrix();
  cv::Mat samples(size * n, CV_32F);
  cv::parallel_for_({0, samples.rows}, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      auto ray = rays.begin() + static_cast<std::ptrdiff_t>(v) * samples.cols;
      for (int u = 0; u < samples.cols; ++u, ++ray) {
        samples.at<float>(v, u) = static_cast<float>(brightness(room.cast(from, R * *ray, time)));
      }
    }
  });
  cv::Mat image;
  cv::resize(samples, image, size, 0, 0, cv::INTER_AREA);
  return image;
}

void add_grain(double sigma, std::uint64_t seed, int frame, int camera, cv::Mat& image) {
  if (sigma == 0.0) return;
  const std::string of = camera == 0 ? "" : fmt::format(" of camera {}", camera);
  RandomStream random(seed, fmt::format("grain {}{}", frame, of));
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image.at<float>(v, u) += static_cast<float>(sigma * random.normal());
    }
  }
}

}  // namespace

cv::Mat render(const Room& room, const RoomOptions& options, std::uint64_t seed, int frame,
               int camera) {
  const Rig rig(room.camera(), room.other_cameras());
  const MountedCamera& mounted = rig[camera];
  const std::vector<Eigen::Vector3d> rays = sample_rays(mounted.lens, options.samples);
  const cv::Size size(mounted.lens.width, mounted.lens.height);
  const int steps = options.exposure > 0.0 ? kExposureSteps : 1;
  cv::Mat sum = cv::Mat::zeros(size, CV_32F);
  for (int k = 0; k < steps; ++k) {
    const double offset = ((k + 0.5) / steps - 0.5) * options.exposure;
    sum += instant(room, mounted, options.samples, rays, frame / options.rate + offset);
  }
  sum /= steps;
  if (options.blur > 0.0) cv::GaussianBlur(sum, sum, {0, 0}, options.blur);
  add_grain(options.grain, seed, frame, camera, sum);
  cv::Mat image;
  sum.convertTo(image, CV_8U);
  return image;
}

}  // namespace slammot
