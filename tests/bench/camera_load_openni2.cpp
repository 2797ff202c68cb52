// SPDX-License-Identifier: MIT
// OpenNI2 with the test camera, which plays a film in this process: reading it and the plugin's copy of each
// image are counted with the rest.
#include <algorithm>

#include "drivers/openni2/openni2_source.hpp"
#include "tests/bench/camera_load.hpp"
#include "tests/support/openni2_plugin/test_camera.hpp"

namespace loopsift::bench {

void load_openni2() {
  const std::string name = "openni2, depth and colour";
  if (!test::TestCamera::install()) return print_skipped(name, test::TestCamera::kNotAllowed);
  test::TestCamera camera;
  camera.control.film = camera.folder() / "film";
  test::write_drawn_film(camera.control.film, 30, kWidth, kHeight);
  camera.control.repeat = true;
  camera.apply();
  const auto source = open_openni2("", usual_options());
  if (!source.ok()) return print_skipped(name, source.error().message);
  measure(name, **source, 0, [] {});
}

}  // namespace loopsift::bench
