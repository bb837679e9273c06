// slammot with a landmark model, a classifier, an estimator, a reader, a scenario and a metric
// more: all commands, keys, lists, studies and reports know them.
#include <slammot/apps/app.h>

#include "corridor.h"
#include "dead_reckoning.h"
#include "decaying_velocity.h"
#include "path_ratio.h"
#include "pixel_list.h"
#include "speed_classifier.h"

int main(int argc, char** argv) {
  using namespace slammot;
  const ClassifierRow speed{
      "speed", "below or above classifier.speed",
      [](const ClassifierOptions& options,
         const std::map<int, Label>&) -> std::unique_ptr<Classifier> {
        return std::make_unique<SpeedClassifier>(options.own.at("classifier.speed"));
      }};
  return app::main(argc, argv,
                   {.program = "my_slammot",
                    .landmarks = landmark_rows<DecayingVelocity>(),
                    .classifiers = {speed},
                    .estimators = {kDeadReckoning},
                    .readers = {kPixelList},
                    .scenarios = {scenario_row<CorridorOptions, simulate_corridor>(
                        "corridor", "between two walls of static points")},
                    .metrics = {kPathRatio},
                    .numbers = {{"classifier.speed", 0.3}}});
}
