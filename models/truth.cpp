#include "models/truth.h"

namespace slammot {

const TruePoint* TrueLandmark::at(int frame) const {
  if (by_frame.empty()) return nullptr;
  if (label == Label::kStatic) return &by_frame.begin()->second;
  const auto found = by_frame.find(frame);
  return found == by_frame.end() ? nullptr : &found->second;
}

Label TrueLandmark::label_at(int frame) const {
  const TruePoint* point = at(frame);
  return point != nullptr && point->velocity.isZero(0.0) ? Label::kStatic : label;
}

}  // namespace slammot
