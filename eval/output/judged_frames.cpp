#include "eval/output/judged_frames.h"

#include <cmath>

#include "eval/metrics/accuracy.h"
#include "eval/metrics/nees.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

struct CameraPart {
  const char* nees;
  int first;  // of the 12 entries of the camera's error
  int dof;
};
constexpr CameraPart kCameraParts[] = {
    {"nees_pose", 0, 6}, {"nees_position", 0, 3}, {"nees_rotation", 3, 3}};

Json frames_json(const std::vector<PosePair>& pairs) {
  Json json;
  for (const char* key : {"frame", "position_error_m", "rotation_error_deg", "nees_pose",
                          "nees_position", "nees_rotation", "position_sigma_m"}) {
    json[key] = Json::array();
  }
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const PosePair& p = pairs[i];
    const PoseNees nees = pose_nees(p);
    json["frame"].push_back(p.frame);
    json["position_error_m"].push_back(position_error(p));
    json["rotation_error_deg"].push_back(rotation_error_deg(p));
    json["nees_pose"].push_back(nees.pose);
    json["nees_position"].push_back(nees.position);
    json["nees_rotation"].push_back(nees.rotation);
    json["position_sigma_m"].push_back(
        std::sqrt(p.estimate.covariance.topLeftCorner<3, 3>().trace()));
  }
  return json;
}

// But for the first, which is a pin.
bool is_stated(const std::vector<PosePair>& pairs, const CameraPart& part) {
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const auto& P = pairs[i].estimate.covariance;
    if (!P.block(part.first, part.first, part.dof, part.dof).hasNaN()) return true;
  }
  return false;
}

}  // namespace

Json judged_frames(const Sequence& sequence, const std::vector<PosePair>& pairs) {
  Json json = frames_json(sequence.exact_truth ? pairs : aligned(pairs));
  for (const CameraPart& part : kCameraParts) {
    if (!sequence.exact_truth || !is_stated(pairs, part)) json.erase(part.nees);
  }
  if (!sequence.exact_truth) {
    json["position_sigma_m"] = std::vector<double>(json["frame"].size(), kUndefined);
  }
  return json;
}

}  // namespace slammot
