// The words of the native sequence folder, shared by its reader and its writer.
#pragma once

#include <string_view>

namespace slammot::native {

inline constexpr std::string_view kFormat = "slammot-sequence-1";

inline constexpr std::string_view kSettings = "sequence.yaml";
inline constexpr std::string_view kFrames = "frames.csv";
inline constexpr std::string_view kOtherImages = "other_images.csv";
inline constexpr std::string_view kObservations = "observations.csv";
inline constexpr std::string_view kGroundTruth = "groundtruth.tum";
inline constexpr std::string_view kLandmarks = "landmarks.csv";
inline constexpr std::string_view kKnown = "known.csv";
inline constexpr std::string_view kPriors = "priors.csv";
inline constexpr std::string_view kInitial = "initial.yaml";
inline constexpr std::string_view kFileNames[] = {kSettings,     kFrames,      kOtherImages,
                                                  kObservations, kGroundTruth, kLandmarks,
                                                  kKnown,        kPriors,      kInitial};

inline constexpr std::string_view kFramesHeader = "frame,timestamp";
inline constexpr std::string_view kFramesWithImagesHeader = "frame,timestamp,image";
inline constexpr std::string_view kOtherImagesHeader = "frame,camera,image";
inline constexpr std::string_view kObservationsHeader = "frame,track,u,v";
inline constexpr std::string_view kSigmaColumn = "relative_sigma";
inline constexpr std::string_view kCameraColumn = "camera";
inline constexpr std::string_view kDepthColumns = "depth,depth_sigma";
inline constexpr std::string_view kLandmarksHeader = "track,frame,class,x,y,z,vx,vy,vz";
inline constexpr std::string_view kKnownHeader = "track,x,y,z,sigma";
inline constexpr std::string_view kPriorsHeader = "track,p_static";

}  // namespace slammot::native
