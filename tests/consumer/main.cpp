// Projects a point, and takes something from every installed library, so that each is really
// linked.
#include <slammot/datasets/sequence/sequence.h>
#include <slammot/eval/configuration/registry.h>
#include <slammot/filters/ekf.h>
#include <slammot/frontend/codecs/codecs.h>
#include <slammot/models/camera.h>
#include <slammot/smoothers/window/window.h>

#include <cstdio>

int main() {
  slammot::Setup setup;
  setup.camera.fx = setup.camera.fy = 385.0;
  setup.camera.cx = 319.5;
  setup.camera.cy = 239.5;
  const auto filter = slammot::make_ekf(setup, {}, {});
  const auto smoother = slammot::make_window(setup, {}, {});
  const slammot::InputError error("frames.csv", 1, "no frames");
  const auto projection = setup.camera.project({0.1, -0.2, 1.0});
  if (!filter || !smoother || slammot::estimator_table().empty() || !projection) return 1;
  if (!slammot::codecs().decode("no image").empty()) return 1;
  std::printf("pixel %.1f %.1f\n", projection->pixel.x(), projection->pixel.y());
  return 0;
}
