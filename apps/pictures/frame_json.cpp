#include "apps/pictures/frame_json.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

template <typename Vector>
Json list(const Vector& v) {
  Json json = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) json.push_back(v(i));  // what is undefined is null
  return json;
}

Json rows(const Eigen::MatrixXd& m) {
  Json json = Json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) json.push_back(list(m.row(i)));
  return json;
}

Json points(const MapFrame& map, std::span<const Eigen::Vector3d> path) {
  Json json = Json::array();
  for (const Eigen::Vector3d& p : path) json.push_back(list(map.at(p)));
  return json;
}

// In the axes of the map.
Json turned(const MapFrame& map, const Eigen::Matrix3d& P) {
  return rows(map.axes * P * map.axes.transpose());
}

Json predictions(const PictureState& state, const CameraView& view) {
  Json json = Json::array();
  for (const Prediction& p : view.predictions) {
    const LandmarkEstimate* landmark = find_track(state.landmarks, p.track);
    json.push_back({{"track", p.track},
                    {"label", to_string(landmark ? landmark->label : Label::kUnknown)},
                    {"pixel", list(p.pixel)},
                    {"S", rows(p.S)},
                    {"measured", to_string(p.measured)}});
  }
  return json;
}

Json measurements(const CameraView& view) {
  Json json = Json::array();
  for (const Observation& z : view.observations) {
    const Prediction* prediction = find_track(view.predictions, z.track);
    json.push_back({{"track", z.track},
                    {"pixel", list(z.pixel)},
                    {"measured", to_string(prediction ? prediction->measured : Measured::kNot)}});
  }
  return json;
}

Json landmarks(const MapFrame& map, const PictureState& state) {
  Json json = Json::array();
  for (const LandmarkEstimate& landmark : state.landmarks) {
    if (!landmark.position.allFinite()) continue;
    json.push_back({{"track", landmark.track},
                    {"label", to_string(landmark.label)},
                    {"measured", state.is_measured(landmark.track)},
                    {"position", list(map.at(landmark.position))},
                    {"covariance", turned(map, landmark.position_covariance)},
                    {"velocity", list(map.axes * landmark.velocity)}});
  }
  return json;
}

Json camera(const MapFrame& map, const CameraEstimate& estimate) {
  return {{"position", list(map.at(estimate.state.position))},
          {"rotation", rows(map.axes * estimate.state.orientation.toRotationMatrix())},
          {"covariance", turned(map, estimate.covariance.topLeftCorner<3, 3>())}};
}

Json image_of(const std::filesystem::path& file) {
  if (file.empty()) return nullptr;
  return std::filesystem::absolute(file).lexically_normal().string();
}

Json other_cameras(const RunFrame& frame) {
  Json json = Json::array();
  for (std::size_t camera = 1; camera < frame.images.size(); ++camera) {
    const CameraView& view = frame.state.views[camera];
    json.push_back({{"image", image_of(frame.images[camera])},
                    {"predictions", predictions(frame.state, view)},
                    {"measurements", measurements(view)}});
  }
  return json;
}

}  // namespace

Json frame_json(const RunPictures& pictures, const RunFrame& frame) {
  const MapFrame& map = pictures.map();
  const PictureState& state = frame.state;
  return {{"format", "slammot-frame-1"},
          {"estimator", pictures.estimator()},
          {"frame", frame.frame->index},
          {"time_s", frame.time},
          {"image", image_of(frame.images[0])},
          {"width", pictures.camera().width},
          {"height", pictures.camera().height},
          {"predictions", predictions(state, state.views[0])},
          {"measurements", measurements(state.views[0])},
          {"other_cameras", other_cameras(frame)},
          {"landmarks", landmarks(map, state)},
          {"camera", camera(map, state.estimate)},
          {"path", points(map, state.path)},
          {"truth", points(map, state.truth)},
          {"shown", {{"lower", list(map.shown.min())}, {"upper", list(map.shown.max())}}}};
}

}  // namespace slammot
