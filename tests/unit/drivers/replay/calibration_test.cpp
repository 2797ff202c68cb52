// SPDX-License-Identifier: MIT
#include "drivers/replay/calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::TemporaryFolder;
using ::testing::HasSubstr;

const Calibration kDefaults{{640, 480, 525, 525, 319.5F, 239.5F}, 5000};

std::string problem_with(const std::string& camera_txt) {
  const TemporaryFolder folder;
  folder.write("camera.txt", camera_txt);
  const auto calibration = resolve_calibration(kDefaults, folder.path(), {});
  return calibration.ok() ? "accepted" : calibration.error().message;
}

TEST(Calibration, DefaultsStandWithoutAFile) {
  const TemporaryFolder folder;
  const auto calibration = resolve_calibration(kDefaults, folder.path(), {});
  ASSERT_TRUE(calibration.ok());
  EXPECT_EQ(calibration->camera.fx, 525);
  EXPECT_EQ(calibration->depth_scale, 5000);
}

TEST(Calibration, TheFileOverridesTheDefaultsAndTheOptionsTheFile) {
  const TemporaryFolder folder;
  folder.write("camera.txt", "# ours\nfx 600\nfy 601.5\ndepth_scale 1000\n");
  SourceOptions options;
  options.camera.fx = 700;
  const auto calibration = resolve_calibration(kDefaults, folder.path(), options);
  ASSERT_TRUE(calibration.ok()) << calibration.error().message;
  EXPECT_EQ(calibration->camera.fx, 700);
  EXPECT_EQ(calibration->camera.fy, 601.5F);
  EXPECT_EQ(calibration->camera.cx, 319.5F);
  EXPECT_EQ(calibration->depth_scale, 1000);
  options.depth_scale = 2000;
  EXPECT_EQ(resolve_calibration(kDefaults, folder.path(), options)->depth_scale, 2000);
}

TEST(Calibration, BadLinesAreNamed) {
  EXPECT_THAT(problem_with("fx 1\ndepth_scale 0\n"),
              HasSubstr("camera.txt:2: depth_scale must be greater than zero"));
  EXPECT_THAT(problem_with("fx -500\n"), HasSubstr("camera.txt:1: fx must be greater than zero"));
  EXPECT_THAT(problem_with("focal 500\n"), HasSubstr("unknown name 'focal'; known are fx fy cx cy"));
  EXPECT_THAT(problem_with("fx nan\n"), HasSubstr("'nan' is not a number"));
  EXPECT_THAT(problem_with("fx\n"), HasSubstr("expected `name value`"));
  EXPECT_THAT(problem_with("width 640.5\n"), HasSubstr("whole number of pixels"));
}

TEST(Calibration, ANegativeDepthScaleFromTheOptionsIsRefused) {
  const TemporaryFolder folder;
  SourceOptions options;
  options.depth_scale = -1;
  const auto calibration = resolve_calibration(kDefaults, folder.path(), options);
  ASSERT_FALSE(calibration.ok());
  EXPECT_THAT(calibration.error().message, HasSubstr("depth scale must be greater than zero"));
}

TEST(Calibration, FitTakesAnUnknownSizeFromTheImage) {
  PinholeCamera camera{0, 0, 570, 570, 320, 240};
  ASSERT_TRUE(fit_to_image("folder", "a.png", 320, 240, &camera).ok());
  EXPECT_EQ(camera.width, 320);
  EXPECT_EQ(camera.height, 240);
}

TEST(Calibration, FitRefusesIntrinsicsOfAnotherSizeAndNone) {
  PinholeCamera camera = kDefaults.camera;
  EXPECT_THAT(fit_to_image("folder", "a.png", 320, 240, &camera).error().message,
              HasSubstr("a.png is 320x240, but the camera is known for 640x480: give fx"));
  PinholeCamera none;
  EXPECT_THAT(fit_to_image("folder", "a.png", 320, 240, &none).error().message,
              HasSubstr("no usable intrinsics are known: give fx"));
}

}  // namespace
}  // namespace loopsift
