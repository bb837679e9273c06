// The scene of circle and square: static and moving points anywhere in a volume around the path.
//
// A moving point passes through the volume at a random time of the run, so that there are as many
// at its end as at its start. It goes straight and for ever unless `stops` or `manoeuvres` say
// otherwise. One that stops does not manoeuvre, and one that manoeuvres never stands still.
// Static points have tracks 0, 1, ...; moving ones follow.
#pragma once

#include "datasets/simulation/scene/disturbances.h"
#include "datasets/simulation/scene/known_landmarks.h"
#include "datasets/simulation/scene/recording.h"
#include "datasets/simulation/scene/statements.h"

namespace slammot {

struct VolumeOptions {
  int static_points = 300;
  int moving_points = 288;
  int first_static = 12;                    // static points placed in view of the first frame
  double width = 30.0;                      // x and z [m]
  double height = 10.0;                     // y [m]
  double min_speed = 1.0, max_speed = 2.0;  // of moving points [m/s]
  double max_climb_deg = 10.0;              // of their direction against the horizontal
  int first_moving = -1;  // moving points allowed in view of the first frame; those beyond are
                          // drawn again; -1: all that the draw puts there
  StopOptions stops;      // of moving points; of scenarios without stops the default, none
  ManoeuvreOptions manoeuvres;  // of moving points that never stop; by default none
};
Parameters parameters(VolumeOptions& options);

struct SceneOptions {
  RecordingOptions recording;
  VolumeOptions volume;
  KnownOptions known;
  StatementOptions statements;
  DisturbanceOptions disturbances;
};
Parameters parameters(SceneOptions& options);

// Places the points around `centre`, records them from the path, states what is true, and disturbs.
// The prior stated is that of the population from which the points are drawn, the same for every
// seed. Where points stop, the acceleration stated covers the stops; where they only manoeuvre, it
// is the RMS of the true one (mover_sigmas.h says why not more). Throws std::invalid_argument for
// more manoeuvring points than there are, and for braking so hard that the slowest would stop.
Sequence simulate_in_volume(const SceneOptions& options, const Eigen::Vector3d& centre,
                            const std::vector<CameraState>& path, std::uint64_t seed);

}  // namespace slammot
