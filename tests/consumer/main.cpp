// Projects a point, and takes something from each library, so that it is really linked.
#include <slammot/filters/ekf.h>
#include <slammot/models/camera.h>

#include <cstdio>

int main() {
  slammot::Setup setup;
  setup.camera.fx = setup.camera.fy = 385.0;
  setup.camera.cx = 319.5;
  setup.camera.cy = 239.5;
  const auto filter = slammot::make_ekf(setup, {}, {});
  const auto projection = setup.camera.project({0.1, -0.2, 1.0});
  if (!filter || !projection) return 1;
  std::printf("pixel %.1f %.1f\n", projection->pixel.x(), projection->pixel.y());
  return 0;
}
