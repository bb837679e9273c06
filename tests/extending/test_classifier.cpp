// A classifier, as examples/extension/ adds one; its code stands there.
#include <gtest/gtest.h>

#include "estimation/classification.h"
#include "examples/extension/speed_classifier.h"

namespace slammot {
namespace {

// [example: classifier with a memory]
// Static only after another classifier has said so in some frames running.
class PatientClassifier final : public Classifier {
 public:
  PatientClassifier(std::unique_ptr<Classifier> other, double frames)
      : other_(std::move(other)), frames_(frames) {}

  Label decide(const MotionBelief& belief, ClassifierMemory& memory) const override {
    if (memory.empty()) memory.push_back(0.0);  // frames running; what follows is the other's
    ClassifierMemory of_other(memory.begin() + 1, memory.end());
    const Label label = other_->decide(belief, of_other);
    memory[0] = label == Label::kStatic ? memory[0] + 1.0 : 0.0;
    memory.resize(1);
    memory.insert(memory.end(), of_other.begin(), of_other.end());
    return label == Label::kStatic && memory[0] < frames_ ? Label::kUnknown : label;
  }

 private:
  std::unique_ptr<Classifier> other_;
  double frames_;
};
// [end]

TEST(ExtendingClassifier, RemembersInTheRecordOfTheLandmark) {
  const PatientClassifier classifier(std::make_unique<SpeedClassifier>(0.3), 3);
  MotionBelief at_rest;
  at_rest.w = Eigen::Vector3d::Zero();
  at_rest.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  MotionBelief unsure = at_rest;
  unsure.covariance *= 1e4;
  ClassifierMemory memory;
  EXPECT_EQ(classifier.decide(at_rest, memory), Label::kUnknown);
  EXPECT_EQ(classifier.decide(at_rest, memory), Label::kUnknown);
  ClassifierMemory replayed = memory;  // as a record is copied
  EXPECT_EQ(classifier.decide(at_rest, memory), Label::kStatic);
  EXPECT_EQ(classifier.decide(unsure, replayed), Label::kUnknown);
  EXPECT_EQ(classifier.decide(at_rest, replayed), Label::kUnknown);  // from the start
  EXPECT_EQ(classifier.decide(at_rest, memory), Label::kStatic);     // another past
}

TEST(ExtendingClassifier, DecidesThroughItsInterface) {
  const std::unique_ptr<Classifier> classifier = std::make_unique<SpeedClassifier>(0.3);
  ClassifierMemory memory;
  MotionBelief belief;
  belief.w = Eigen::Vector3d(0.1, 0.0, 0.0);
  belief.covariance = Eigen::Matrix3d::Identity();
  EXPECT_EQ(classifier->decide(belief, memory), Label::kUnknown);
  belief.covariance *= 1e-4;
  EXPECT_EQ(classifier->decide(belief, memory), Label::kStatic);
  belief.w(0) = 1.0;
  EXPECT_EQ(classifier->decide(belief, memory), Label::kMoving);
  // The same point in scaled velocity, at rho = 0.2: u = rho v.
  belief.w *= 0.2;
  belief.covariance *= 0.04;
  belief.density_scale = 0.008;
  EXPECT_EQ(classifier->decide(belief, memory), Label::kMoving);
  EXPECT_EQ(classifier->at_birth(7), Label::kUnknown);
}

}  // namespace
}  // namespace slammot
