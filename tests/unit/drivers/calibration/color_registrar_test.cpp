// SPDX-License-Identifier: MIT
#include "drivers/calibration/color_registrar.hpp"

#include <gtest/gtest.h>

#include "drivers/calibration/lens.hpp"
#include "tests/unit/drivers/calibration/distorted_scene.hpp"

namespace loopsift {
namespace {

using test::DistortedScene;

struct Registered {
  int worst = 0;    // grey levels from the texture at the depth pixel's point
  double mean = 0;  // the same over the image
};

// The ideal depth image of the scene, coloured from the colour device's image.
Registered register_scene(const DistortedScene& scene, const Se3& T_color_depth) {
  const PinholeCamera& depth = scene.calibration.depth.camera;
  const LensCalibration& lens = scene.calibration.color;
  auto color = scene.device_color(lens, scene.calibration.T_color_depth);
  std::vector<std::uint16_t> raw;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u)
      raw.push_back(static_cast<std::uint16_t>(std::lround(scene.ideal_point(u, v).z() / scene.unit_m)));
  std::vector<Rgb8> out(raw.size());
  const auto radius2 = largest_radius2(lens, "test");
  EXPECT_TRUE(radius2.ok());
  ColorRegistrar registrar(depth, lens, *radius2, T_color_depth, scene.unit_m);
  const ImageView<Rgb8> image(out.data(), depth.width, depth.height);
  registrar.register_color({raw.data(), depth.width, depth.height},
                           {color.data(), lens.camera.width, lens.camera.height}, image);
  Registered result;
  constexpr int kBorder = 16;  // that the colour camera does not see
  int count = 0;
  for (int v = kBorder; v < depth.height - kBorder; ++v) {
    for (int u = kBorder; u < depth.width - kBorder; ++u) {
      const int error = std::abs(
          image(u, v).r - static_cast<int>(std::lround(DistortedScene::texture(scene.ideal_point(u, v)))));
      EXPECT_EQ(image(u, v).r + image(u, v).g, 255);
      EXPECT_EQ(image(u, v).b, 7);
      result.worst = std::max(result.worst, error);
      result.mean += error;
      ++count;
    }
  }
  result.mean /= count;
  return result;
}

TEST(ColorRegistrar, EachDepthPixelHasTheColorOfItsPoint) {
  const DistortedScene scene;
  const Registered result = register_scene(scene, scene.calibration.T_color_depth);
  EXPECT_LE(result.worst, 3);  // half a colour pixel is at most 2 grey levels of this texture
  EXPECT_LT(result.mean, 1.0);
}

TEST(ColorRegistrar, TheTestSceneTellsARightTransformFromItsInverse) {
  const DistortedScene scene;
  EXPECT_GT(register_scene(scene, scene.calibration.T_color_depth.inverse()).mean, 5.0);
  EXPECT_GT(register_scene(scene, {}).mean, 2.5);
}

TEST(ColorRegistrar, AMirroredColorImageIsReadTheOtherWayRound) {
  DistortedScene scene;
  scene.calibration.color.mirrored = true;
  EXPECT_LE(register_scene(scene, scene.calibration.T_color_depth).worst, 3);
}

// A 5 × 1 depth image and a colour camera 10 pixels wide beside it: 10 px · 0.1 m / z of parallax.
struct SmallPair {
  PinholeCamera depth{5, 1, 10.0F, 10.0F, 2.0F, 0.0F};
  LensCalibration color;
  std::vector<Rgb8> colors;
  SmallPair() {
    color.camera = {10, 1, 10.0F, 10.0F, 4.0F, 0.0F};
    for (unsigned char i = 0; i < 10; ++i) colors.push_back({i, 0, 0});
  }
  std::vector<int> registered(std::vector<std::uint16_t> raw) {
    ColorRegistrar registrar(depth, color, 100.0, Se3(Eigen::Matrix3d::Identity(), {0.1, 0, 0}), 0.001);
    std::vector<Rgb8> out(raw.size());
    registrar.register_color({raw.data(), 5, 1}, {colors.data(), 10, 1}, {out.data(), 5, 1});
    std::vector<int> reds;
    for (const Rgb8& pixel : out) reds.push_back(pixel.r);
    return reds;
  }
};

TEST(ColorRegistrar, ParallaxFollowsTheDepth) {
  // u_color = (u − 2) + 4 + 1 m / z: 1 pixel at 1 m, 2 pixels at 0.5 m.
  EXPECT_EQ(SmallPair().registered({1000, 1000, 1000, 1000, 1000}), (std::vector<int>{3, 4, 5, 6, 7}));
  EXPECT_EQ(SmallPair().registered({1000, 1000, 500, 1000, 1000}), (std::vector<int>{3, 4, 6, 6, 7}));
}

TEST(ColorRegistrar, HolesLieAsDeepAsWhatIsLeftOfThem) {
  EXPECT_EQ(SmallPair().registered({0, 500, 0, 65535, 1000}), (std::vector<int>{2, 5, 6, 7, 7}));
}

TEST(ColorRegistrar, WhatTheColorCameraDoesNotSeeGetsItsBorder) {
  EXPECT_EQ(SmallPair().registered({200, 100, 100, 100, 100}), (std::vector<int>{7, 9, 9, 9, 9}));
}

}  // namespace
}  // namespace loopsift
