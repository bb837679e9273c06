#include "estimation/modules/births.h"

namespace slammot {

TrackRecord record_at_birth(int track, int frame, bool is_first_frame, Label given, Births births,
                            const LandmarkPrior& prior) {
  const bool is_open = given == Label::kUnknown;
  const bool by_rule = is_open && is_first_frame && births == Births::kStaticFirst;
  TrackRecord record = initialised(track, frame, by_rule ? Label::kStatic : given, prior);
  record.by_rule = by_rule;
  record.is_held = is_open && births == Births::kHeld;
  return record;
}

}  // namespace slammot
