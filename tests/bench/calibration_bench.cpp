// SPDX-License-Identifier: MIT
// What a camera file costs per frame of 640 × 480: depth brought right, colour brought over.
#include <benchmark/benchmark.h>

#include <random>

#include "drivers/calibration/color_registrar.hpp"
#include "drivers/calibration/depth_rectifier.hpp"
#include "drivers/calibration/lens.hpp"

namespace loopsift {
namespace {

struct Images {
  LensCalibration lens;
  std::vector<std::uint16_t> depth, rectified;
  std::vector<Rgb8> color, registered;
  Images() {
    lens.camera = {640, 480, 525.0F, 525.0F, 319.5F, 239.5F};
    lens.distortion.k1 = 0.1;
    lens.distortion.k2 = -0.2;
    std::mt19937 random(1);
    for (int i = 0; i < 640 * 480; ++i)
      depth.push_back(static_cast<std::uint16_t>(1500 + i / 640 + random() % 20));
    rectified.resize(depth.size());
    color.resize(depth.size());
    registered.resize(depth.size());
  }
};

void rectify_depth(benchmark::State& state) {
  Images images;
  const DepthRectifier rectifier(images.lens, {}, 0.001, {});
  for (auto _ : state)
    rectifier.rectify({images.depth.data(), 640, 480}, {images.rectified.data(), 640, 480});
}
BENCHMARK(rectify_depth)->Unit(benchmark::kMillisecond);

void register_color(benchmark::State& state) {
  Images images;
  ColorRegistrar registrar(images.lens.camera, images.lens, *largest_radius2(images.lens, "bench"),
                           Se3(Eigen::Matrix3d::Identity(), {-0.025, 0, 0}), 0.001);
  for (auto _ : state)
    registrar.register_color({images.depth.data(), 640, 480}, {images.color.data(), 640, 480},
                             {images.registered.data(), 640, 480});
}
BENCHMARK(register_color)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace loopsift
