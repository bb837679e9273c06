// What leaves the window with its oldest frame, what is deactivated out of view, and what returns.
#pragma once

#include <span>

#include "smoothers/solver/marginalise.h"
#include "smoothers/window/track_history.h"
#include "smoothers/window/window_landmark.h"

namespace slammot {

class Departures {
 public:
  Departures(Graph& graph, CameraWindow& cameras, WindowLandmarks& landmarks)
      : graph_(graph), cameras_(cameras), landmarks_(landmarks) {}

  // One marginalisation for all that leaves: the oldest frame, when there are more than `frames`,
  // and the motions of landmarks that have become static. `histories`: told what passes, or null.
  void marginalise(int frames, TrackHistories* histories);

  // Those motions alone.
  void marginalise_motions();

  // A landmark that has just been released moves on from where it came to rest to this frame, by a
  // step without noise. Its pixels up to there go into the prior.
  void move_to(const WindowLandmark& landmark, double rest_time, const WindowFrame& base);

  // What the prior knows of a free landmark becomes p(y, w | core): it will be considered.
  void set_apart(const WindowLandmark& landmark);

  // Of landmarks that are measured again.
  void reactivate(std::span<const int> tracks);

 private:
  enum class Use { kUnused, kInactive, kActive };
  struct LeftAnchor {  // a camera position whose frame has left
    VariableId position = 0;
    Use use = Use::kUnused;
  };

  void linearise();
  void find(const WindowFrame* oldest, TrackHistories* histories);
  void add(const WindowLandmark& landmark, const WindowFrame* oldest, bool is_pruned);
  Departure departure_of(const WindowLandmark& landmark, const WindowFrame* oldest,
                         bool is_pruned) const;
  void find_inactive(const WindowFrame& oldest);
  void mark_anchors(const WindowFrame& oldest);
  void use(VariableId anchor, Use how);
  bool leaves(const WindowLandmark& landmark) const;
  void finish();
  bool is_inactive(VariableId id) const { return !graph_.variables[id].is_active; }

  Graph& graph_;
  CameraWindow& cameras_;
  WindowLandmarks& landmarks_;
  Marginaliser marginaliser_;
  std::vector<LeftAnchor> left_anchors_;  // by position
  Leaving leaving_;                       // kept for its memory, as is the next
  std::vector<VariableId> returning_;
};

}  // namespace slammot
