// The readers of sequences.
#include <cmath>

#include "datasets/camera/camera_file.h"
#include "datasets/readers/author_reader.h"
#include "datasets/readers/image_reader.h"
#include "datasets/readers/reader.h"
#include "datasets/text/text_table.h"
#include "tests/datasets/fixture.h"
#include "tests/fuzz/target.h"

namespace slammot::fuzz {
namespace {

using Path = std::filesystem::path;

bool is_finite(const CameraState& x) {
  return x.position.allFinite() && x.orientation.coeffs().allFinite() && x.velocity.allFinite() &&
         x.angular_velocity.allFinite() && std::abs(x.orientation.norm() - 1.0) < 1e-9;
}

void check_frames(const Sequence& s) {
  require(!s.frames.empty(), "no frame");
  for (size_t i = 0; i < s.frames.size(); ++i) {
    require(std::isfinite(s.frames[i].timestamp), "a time");
    require(i == 0 || s.frames[i].timestamp > s.frames[i - 1].timestamp, "the order of times");
    for (const Observation& z : s.frames[i].observations) {
      require(z.track >= 0 && z.pixel.allFinite(), "a measurement");
      require(z.relative_sigma > 0.0 && std::isfinite(z.relative_sigma), "its sigma");
    }
  }
  for (const auto& x : s.truth) require(!x || is_finite(*x), "a true camera");
}

void check(const Sequence& s) {
  check_frames(s);
  require(std::isfinite(s.camera.fx * s.camera.fy * s.camera.cx * s.camera.cy), "the camera");
  require(s.pixel_sigma > 0.0 && std::isfinite(s.pixel_sigma), "the sigma of a pixel");
  for (const auto& [track, landmark] : s.landmarks) {
    for (const auto& [frame, point] : landmark.by_frame) {
      require(point.position.allFinite() && point.velocity.allFinite(), "a true landmark");
    }
  }
  for (const KnownLandmark& k : s.known) {
    require(k.position.allFinite() && k.sigma > 0.0, "a known landmark");
  }
  for (const auto& [track, p] : s.p_static) require(p >= 0.0 && p <= 1.0, "a probability");
  require(!s.initial || is_finite(s.initial->state), "the first camera");
}

void read_measured(const Path& folder) { check(read_sequence(folder)); }
void read_imaged(const Path& folder) {
  Sequence s = read_images(folder);
  check_frames(s);
  add_other_images(s);
  for (const MountedCamera& other : s.other_cameras) {
    require(other.t.allFinite() && other.R.coeffs().allFinite(), "another camera");
  }
  for (const auto& names : s.other_images) require(names.size() == s.frames.size(), "its images");
}
void read_camera_alone(const Path& folder) {
  const Path file = folder / "camera.yaml";
  const Camera camera = read_camera_file(file, read_text_file(file)).camera;
  require(std::isfinite(camera.fx * camera.fy), "the camera");
}

Files native() { return {test::kGood.begin(), test::kGood.end()}; }

Files rig() {
  const std::string camera =
      "{model: pinhole, width: 320, height: 240, fx: 170, fy: 171, cx: 160, cy: 120";
  Files files = native();
  files["sequence.yaml"] =
      "format: slammot-sequence-1\nname: small\npixel_sigma: 1\ncameras:\n  - " + camera +
      "}\n  - " + camera + ", T_C0_C: {position: [0.1, 0, 0], quaternion: [0, 0, 0, 1]}}\n";
  files["frames.csv"] = "frame,timestamp,image\n0,0,a.png\n1,0.1,b.png\n2,0.2,c.png\n";
  files["other_images.csv"] = "frame,camera,image\n0,1,d.png\n2,1,e.png\n";
  return files;
}

Files camera() {
  return {{"camera.yaml",
           "{model: radtan, width: 320, height: 240, fx: 170, fy: 171, cx: 160, cy: 120, "
           "distortion: [0.1, 0.2]}\n"}};
}

Files author() {
  return {{"groundTruth.txt",
           "numOfFrames: 2\nCam: Position Orientation\n0: (0, 0, 0), (1, 0, 0, 0)\n"
           "1: (0, 0, 0.1), (0.6, 0.8, 0, 0)\nPoint 9: Static\nPosition: (1, 2, 3)\nProjections:\n"
           "0, (100, 110)\n1, (-1, -1)\nPoint 13: Moving\nProjections:\n"
           "0, (1, 2, 3), (50, 60)\n1, (1, 2, 4), (51, 61)\n"}};
}

Files euroc() {
  return {{"mav0/cam0/data.csv", "#timestamp [ns],filename\n1000000000,a.png\n1050000000,b.png\n"},
          {"mav0/cam0/sensor.yaml",
           "T_BS:\n  rows: 4\n  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n"
           "resolution: [752, 480]\nintrinsics: [458.654, 457.296, 367.215, 248.375]\n"
           "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0, 0]\n"},
          {"mav0/cam1/data.csv", "#timestamp [ns],filename\n1000000000,c.png\n1050000000,d.png\n"},
          {"mav0/cam1/sensor.yaml",
           "T_BS:\n  data: [0, -1, 0, 0.1, 1, 0, 0, 0.3, 0, 0, 1, 0.3, 0, 0, 0, 1]\n"
           "resolution: [752, 480]\nintrinsics: [458.654, 457.296, 367.215, 248.375]\n"
           "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0, 0]\n"},
          {"mav0/state_groundtruth_estimate0/data.csv",
           "#t,x,y,z,qw,qx,qy,qz\n1000000000,0,0,0,1,0,0,0\n1050000000,1,0,0,0.6,0.8,0,0\n"}};
}

Files tum() {
  return {{"rgb.txt", "# color images\n1.00 rgb/a.png\n1.05 rgb/b.png\n"},
          {"depth.txt", "# depth maps\n1.01 depth/a.png\n1.06 depth/b.png\n"},
          {"groundtruth.txt", "1.0 0 0 0 0 0 0 1\n1.06 1 0 0 0 0 0.6 0.8\n"}};
}

Files kitti() {
  return {{"calib.txt",
           "P0: 718 0 607 0 0 718 185 0 0 0 1 0\n"
           "P1: 718 0 607 -386 0 718 185 0 0 0 1 0\n"},
          {"times.txt", "0\n0.1\n"},
          {"image_0/000000.png", ""},
          {"image_1/000000.png", ""},
          {"poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0.9\n"}};
}

Files kitti_raw() {
  std::string reading = "49.01 8.43 112.8 0.01 0.02 1.5";
  for (int i = 6; i < 30; ++i) reading += " 0";
  return {
      {"calib_cam_to_cam.txt",
       "S_rect_00: 1242 375\nR_rect_00: 1 0 0 0 1 0 0 0 1\n"
       "P_rect_00: 721 0 609 0 0 721 172 0 0 0 1 0\n"},
      {"calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n"},
      {"calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.08 -0.27\n"},
      {"image_00/timestamps.txt", "2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.067967474\n"},
      {"oxts/timestamps.txt", "2011-09-26 13:02:25.95\n2011-09-26 13:02:26.07\n"},
      {"oxts/data/0000000000.txt", reading + "\n"},
      {"oxts/data/0000000001.txt", reading + "\n"}};
}

constexpr Target kTargets[] = {
    {"native_settings", native, "sequence.yaml", read_measured},
    {"native_frames", native, "frames.csv", read_measured},
    {"native_observations", native, "observations.csv", read_measured},
    {"native_truth", native, "groundtruth.tum", read_measured},
    {"native_landmarks", native, "landmarks.csv", read_measured},
    {"native_known", native, "known.csv", read_measured},
    {"native_priors", native, "priors.csv", read_measured},
    {"native_initial", native, "initial.yaml", read_measured},
    {"native_rig", rig, "sequence.yaml", read_imaged},
    {"native_other_images", rig, "other_images.csv", read_imaged},
    {"camera", camera, "camera.yaml", read_camera_alone},
    {"author", author, "groundTruth.txt", read_measured},
    {"euroc_images", euroc, "mav0/cam0/data.csv", read_imaged},
    {"euroc_sensor", euroc, "mav0/cam0/sensor.yaml", read_imaged},
    {"euroc_truth", euroc, "mav0/state_groundtruth_estimate0/data.csv", read_imaged},
    {"tum_images", tum, "rgb.txt", read_imaged},
    {"euroc_second_images", euroc, "mav0/cam1/data.csv", read_imaged},
    {"euroc_second_sensor", euroc, "mav0/cam1/sensor.yaml", read_imaged},
    {"tum_depths", tum, "depth.txt", read_imaged},
    {"tum_truth", tum, "groundtruth.txt", read_imaged},
    {"kitti_calibration", kitti, "calib.txt", read_imaged},
    {"kitti_times", kitti, "times.txt", read_imaged},
    {"kitti_poses", kitti, "poses.txt", read_imaged},
    {"kitti_raw_cameras", kitti_raw, "calib_cam_to_cam.txt", read_imaged},
    {"kitti_raw_rigid", kitti_raw, "calib_imu_to_velo.txt", read_imaged},
    {"kitti_raw_times", kitti_raw, "image_00/timestamps.txt", read_imaged},
    {"kitti_raw_oxts", kitti_raw, "oxts/data/0000000001.txt", read_imaged},
};

}  // namespace

std::span<const Target> dataset_targets() { return kTargets; }

}  // namespace slammot::fuzz
