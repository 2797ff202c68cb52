// SPDX-License-Identifier: MIT
#include "drivers/calibration/depth_rectifier.hpp"

#include <gtest/gtest.h>

#include "tests/unit/drivers/calibration/distorted_scene.hpp"

namespace loopsift {
namespace {

using test::DistortedScene;

std::vector<std::uint16_t> rectified(const LensCalibration& lens, const DepthCorrection& correction,
                                     const std::vector<std::uint16_t>& factors,
                                     std::vector<std::uint16_t> device) {
  const DepthRectifier rectifier(lens, correction, 0.001, factors);
  EXPECT_FALSE(rectifier.is_identity());
  std::vector<std::uint16_t> out(device.size(), 99);
  rectifier.rectify({device.data(), lens.camera.width, lens.camera.height},
                    {out.data(), lens.camera.width, lens.camera.height});
  return out;
}

LensCalibration small_lens(int width) {
  LensCalibration lens;
  lens.camera = {width, 1, 10.0F, 10.0F, 1.0F, 0.0F};
  return lens;
}

TEST(DepthRectifier, ADistortedPlaneComesOutAsAnIdealCameraSeesIt) {
  const DistortedScene scene;
  const LensCalibration& lens = scene.calibration.depth;
  const auto device = scene.device_depth();
  const auto out = rectified(lens, {}, {}, device);
  const int width = lens.camera.width;
  double worst = 0, worst_before = 0;
  int outside = 0;
  for (int v = 0; v < lens.camera.height; ++v) {
    for (int u = 0; u < width; ++u) {
      const std::size_t i =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
      const double ideal_mm = scene.ideal_point(u, v).z() * 1000;
      outside += out[i] == 0 ? 1 : 0;
      if (out[i] != 0) worst = std::max(worst, std::abs(out[i] - ideal_mm));
      worst_before = std::max(worst_before, std::abs(device[i] - ideal_mm));
    }
  }
  // The plane's depth changes by up to 8 mm a pixel, and the nearest pixel is up to 0.71 pixels away; both
  // are rounded.
  EXPECT_LT(worst, 7.0);
  EXPECT_GT(worst_before, 40.0);
  EXPECT_LT(outside, 100);  // barrel distortion shows more than the ideal image holds
}

TEST(DepthRectifier, NothingToDoMakesNoTables) {
  EXPECT_TRUE(DepthRectifier(small_lens(3), {}, 0.001, {}).is_identity());
}

TEST(DepthRectifier, MirroringIsUndone) {
  LensCalibration lens = small_lens(4);
  lens.mirrored = true;
  EXPECT_EQ(rectified(lens, {}, {}, {1, 2, 3, 4}), (std::vector<std::uint16_t>{4, 3, 2, 1}));
}

TEST(DepthRectifier, ThePolynomialCorrectsEachDepthAndLeavesHolesAlone) {
  DepthCorrection correction;
  correction.c0_m = 0.01;
  correction.c1 = 1.02;
  correction.c2_per_m = -0.005;
  const auto out = rectified(small_lens(4), correction, {}, {0, 1000, 4000, 65535});
  EXPECT_EQ(out, (std::vector<std::uint16_t>{0, 1025, 4010, 0}));
}

TEST(DepthRectifier, DepthsThatDoNotFitBecomeHolesRatherThanWrapAround) {
  DepthCorrection correction;
  correction.c0_m = -0.5;
  correction.c1 = 2;
  EXPECT_EQ(rectified(small_lens(4), correction, {}, {100, 250, 251, 40000}),
            (std::vector<std::uint16_t>{0, 0, 2, 0}));
}

TEST(DepthRectifier, FactorsAreThoseOfTheDevicesPixels) {
  LensCalibration lens = small_lens(3);
  lens.mirrored = true;
  DepthCorrection correction;
  correction.factor_file = "factors.png";
  const std::vector<std::uint16_t> factors = {32768, 16384, 65535};
  EXPECT_EQ(rectified(lens, correction, factors, {1000, 1000, 1000}),
            (std::vector<std::uint16_t>{2000, 500, 1000}));
  EXPECT_EQ(rectified(lens, correction, factors, {1000, 0, 40000})[0], 0) << "80000 does not fit";
}

}  // namespace
}  // namespace loopsift
