#include "eval/python/python_messages.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

template <typename Vector>
Json numbers(const Vector& values) {
  Json json = Json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) json.push_back(values[i]);
  return json;
}

double number_from(const Json& json) { return json.is_null() ? kUndefined : json.get<double>(); }

template <int kRows>
Eigen::Matrix<double, kRows, 1> vector_from(const Json& json) {
  Eigen::Matrix<double, kRows, 1> values;
  for (int i = 0; i < kRows; ++i) values[i] = number_from(json.at(static_cast<std::size_t>(i)));
  return values;
}

// By rows; NaN throughout where nothing is stated.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> square_from(const Json& json) {
  Eigen::Matrix<double, kSize, kSize> matrix;
  matrix.setConstant(kUndefined);
  if (json.is_null()) return matrix;
  std::size_t next = 0;  // row by row
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j < kSize; ++j) matrix(i, j) = number_from(json.at(next++));
  }
  return matrix;
}

Label label_from(const Json& json) {
  for (const Label label : {Label::kUnknown, Label::kStatic, Label::kMoving}) {
    if (json.get<std::string>() == to_string(label)) return label;
  }
  throw std::invalid_argument("a label is static, moving or unknown, not " + json.dump());
}

Json camera_json(const Camera& camera) {
  return {{"model", lens_name(camera.lens)},
          {"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"distortion", lens_distortion(camera.lens)}};
}

Json prior_json(const LandmarkPrior& prior) {
  return {
      {"inverse_depth", prior.inverse_depth}, {"inverse_depth_sigma", prior.inverse_depth_sigma},
      {"mean_sigma", prior.mean_sigma},       {"max_speed", prior.max_speed},
      {"acceleration", prior.acceleration},   {"jerk", prior.jerk},
      {"steady_time", prior.steady_time},     {"spread_follows_mean", prior.spread_follows_mean}};
}

Json state_json(const CameraState& x) {
  return {{"position", numbers(x.position)},
          {"orientation", numbers(x.orientation.coeffs())},
          {"velocity", numbers(x.velocity)},
          {"angular_velocity", numbers(x.angular_velocity)}};
}

std::optional<int> optional_int(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional(json.get<int>());
}

}  // namespace

Json setup_message(const Setup& setup) {
  Json known = {{"tracks", Json::array()}, {"positions", Json::array()}, {"sigmas", Json::array()}};
  for (const KnownLandmark& landmark : setup.known) {
    known["tracks"].push_back(landmark.track);
    known["positions"].push_back(numbers(landmark.position));
    known["sigmas"].push_back(landmark.sigma);
  }
  Json p_static = {{"tracks", Json::array()}, {"values", Json::array()}};
  for (const auto& [track, p] : setup.p_static) {
    p_static["tracks"].push_back(track);
    p_static["values"].push_back(p);
  }
  Json initial = state_json(setup.initial.state);
  initial["sigmas"] = numbers(setup.initial.sigmas());
  Json others = Json::array();
  for (const MountedCamera& other : setup.other_cameras) {
    Json camera = camera_json(other.lens);
    camera["T_C0_C"] = {{"position", numbers(other.t)}, {"orientation", numbers(other.R.coeffs())}};
    others.push_back(camera);
  }
  return {{"camera", camera_json(setup.camera)},
          {"other_cameras", others},
          {"pixel_sigma", setup.pixel_sigma},
          {"acceleration", setup.camera_noise.acceleration},
          {"angular_acceleration", setup.camera_noise.angular_acceleration},
          {"prior", prior_json(setup.prior)},
          {"initial", initial},
          {"known", known},
          {"p_static", p_static}};
}

Json frame_message(const Frame& frame) {
  Json tracks = Json::array(), pixels = Json::array(), relative_sigmas = Json::array(),
       depths = Json::array();
  for (const Observation& z : frame.observations) {
    tracks.push_back(z.track);
    pixels.push_back(z.pixel.x());
    pixels.push_back(z.pixel.y());
    relative_sigmas.push_back(z.relative_sigma);
    depths.push_back(z.depth);
    depths.push_back(z.depth_sigma);
  }
  Json others = {{"tracks", Json::array()}, {"cameras", Json::array()}, {"pixels", Json::array()}};
  for (const Observation& z : frame.other_views) {
    others["tracks"].push_back(z.track);
    others["cameras"].push_back(z.camera);
    others["pixels"].push_back(z.pixel.x());
    others["pixels"].push_back(z.pixel.y());
  }
  return {{"frame", frame.index},  {"timestamp", frame.timestamp},
          {"other_views", others}, {"tracks", tracks},
          {"pixels", pixels},      {"relative_sigmas", relative_sigmas},
          {"depths", depths}};
}

// A quaternion of any length, as Python has no type that keeps it one.
CameraEstimate camera_from(const Json& json) {
  CameraEstimate camera;
  camera.timestamp = json.at("timestamp").get<double>();
  camera.state.position = vector_from<3>(json.at("position"));
  camera.state.orientation.coeffs() = vector_from<4>(json.at("orientation")).normalized();
  camera.state.velocity = vector_from<3>(json.at("velocity"));
  camera.state.angular_velocity = vector_from<3>(json.at("angular_velocity"));
  const Json& covariance = json.at("covariance");
  camera.covariance.setConstant(kUndefined);
  if (covariance.size() == 36) {
    camera.covariance.topLeftCorner<6, 6>() = square_from<6>(covariance);
  } else {
    camera.covariance = square_from<kCameraDim>(covariance);
  }
  return camera;
}

LandmarkEstimate landmark_from(const Json& json) {
  LandmarkEstimate landmark;
  landmark.track = json.at("track").get<int>();
  landmark.label = label_from(json.at("label"));
  landmark.first_frame = json.at("first_frame").get<int>();
  landmark.last_frame = json.at("last_frame").get<int>();
  landmark.decision_frame = optional_int(json.at("decision_frame"));
  landmark.observations = json.at("observations").get<int>();
  landmark.position = vector_from<3>(json.at("position"));
  landmark.position_covariance = square_from<3>(json.at("position_covariance"));
  if (!json.at("velocity").is_null()) landmark.velocity = vector_from<3>(json.at("velocity"));
  landmark.velocity_covariance = square_from<3>(json.at("velocity_covariance"));
  return landmark;
}

// What the script does not state is no reason to warn.
FrameReport report_from(const Json& json) {
  FrameReport report;
  report.joint_nis = kUndefined;
  if (json.is_null()) return report;
  report.accepted = json.at("accepted").get<int>();
  report.rejected = json.at("rejected").get<int>();
  report.admitted = json.at("admitted").get<int>();
  report.state_size = json.at("state_size").get<int>();
  report.nis_sum = number_from(json.at("nis_sum"));
  report.accepted_static = optional_int(json.at("accepted_static")).value_or(report.accepted);
  report.joint_nis = report.accepted > 0 ? number_from(json.at("joint_nis")) : 0.0;
  return report;
}

}  // namespace slammot
