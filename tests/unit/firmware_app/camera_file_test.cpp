// SPDX-License-Identifier: MIT
#include "firmware_app/camera_file.hpp"

#include <gmock/gmock.h>

#include "firmware_app/settings.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> problems_of(const std::string& text) {
  const test::TemporaryFolder folder;
  folder.write("camera.toml", text);
  CameraCalibration calibration;
  std::vector<std::string> problems;
  const bool read = read_camera_file(folder / "camera.toml", &calibration, &problems);
  EXPECT_EQ(read, problems.empty());
  return problems;
}

TEST(CameraFile, EveryKeyReachesItsMember) {
  const test::TemporaryFolder folder;
  folder.write("camera.toml", R"(
[depth]
width = 320
height = 240
fx = 290
fy = 291
cx = 160.5
cy = 119.5
k1 = 0.1
k2 = 0.2
p1 = 0.01
p2 = 0.02
k3 = 0.3
mirrored = true
scale = 5000
[depth_correction]
c0_m = 0.01
c1 = 0.99
c2_per_m = 0.002
c3_per_m2 = 0.0001
factor_file = "factors.png"
[color]
width = 640
height = 480
fx = 600
fy = 601
cx = 321
cy = 242
k1 = -0.1
[T_color_depth]
x_m = -0.025
y_m = 0.001
z_m = 0.002
rz_rad = 1.5707963267948966
)");
  CameraCalibration c;
  std::vector<std::string> problems;
  ASSERT_TRUE(read_camera_file(folder / "camera.toml", &c, &problems)) << problems.front();
  EXPECT_EQ(c.depth.camera.width, 320);
  EXPECT_EQ(c.depth.camera.cx, 160.5F);
  EXPECT_EQ(c.depth.distortion.k1, 0.1);
  EXPECT_EQ(c.depth.distortion.p2, 0.02);
  EXPECT_EQ(c.depth.distortion.k3, 0.3);
  EXPECT_TRUE(c.depth.mirrored);
  EXPECT_FALSE(c.color.mirrored);
  EXPECT_EQ(c.depth_scale, 5000);
  EXPECT_NEAR(c.correction.polynomial(2), 0.01 + 1.98 + 0.008 + 0.0008, 1e-12);
  EXPECT_EQ(c.correction.factor_file, folder / "factors.png");
  EXPECT_EQ(c.color.camera.fy, 601.0F);
  EXPECT_FALSE(c.color_is_aligned());
  const Eigen::Vector3d moved = c.T_color_depth * Eigen::Vector3d(1, 0, 0);
  EXPECT_TRUE(moved.isApprox(Eigen::Vector3d(-0.025, 1.001, 0.002), 1e-12)) << moved;
}

TEST(CameraFile, AllProblemsAreToldWithTheirLines) {
  EXPECT_THAT(
      problems_of("[depth]\nk1 = \"big\"\nk9 = 1\n[color]\nfx = -1\n"),
      ElementsAre(AllOf(HasSubstr("camera.toml:"), HasSubstr("color.fx: -1 is out of range")),
                  HasSubstr("camera.toml:2: depth.k1: expected a number"),
                  HasSubstr("camera.toml:3: depth.k9: there is no such key; the nearest is depth.k1")));
  EXPECT_THAT(problems_of("fx = 3"), ElementsAre(HasSubstr("there is no such key")));
  EXPECT_THAT(problems_of("[depth\n"), ElementsAre(HasSubstr("is not TOML")));
}

TEST(CameraFile, WhatDoesNotFitTogetherIsRefused) {
  EXPECT_THAT(problems_of("[depth]\nfx = 500\n"), ElementsAre(HasSubstr("depth: give all of width height")));
  EXPECT_THAT(problems_of("[T_color_depth]\nx_m = 0.02\n"),
              ElementsAre(HasSubstr("needs the colour camera")));
  EXPECT_THAT(problems_of("[depth_correction]\nc2_per_m = -0.5\n"),
              ElementsAre(HasSubstr("grow with depth")));
}

TEST(CameraFile, AnEmptyFileChangesNothing) { EXPECT_THAT(problems_of(""), IsEmpty()); }

TEST(CameraFile, TheReadyOnesAreInOrder) {
  for (const std::string name : {"kinect_v1", "xtion", "structure", "realsense_d435"}) {
    CameraCalibration c;
    std::vector<std::string> problems;
    EXPECT_TRUE(read_camera_file(LOOPSIFT_CONFIG_DIR "/cameras/" + name + ".toml", &c, &problems)) << name;
    EXPECT_TRUE(c.depth.camera.is_valid()) << name;
    EXPECT_EQ(c.color_is_aligned(), name == "structure") << name;
  }
}

TEST(CameraFile, SettingsNameItAndReportItsProblemsWithTheirOwn) {
  const auto settings = load_settings("", {"camera.file=" LOOPSIFT_CONFIG_DIR "/cameras/kinect_v1.toml",
                                           "camera.color_source=v4l2:/dev/video2"});
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  EXPECT_EQ(settings->source.calibration.depth.camera.fx, 585.0F);
  EXPECT_EQ(settings->source.color_source, "v4l2:/dev/video2");
  const auto bad = load_settings("", {"camera.file=/no/such/camera.toml", "camera.fx=-1"});
  ASSERT_FALSE(bad.ok());
  EXPECT_THAT(bad.error().message,
              AllOf(HasSubstr("/no/such/camera.toml: cannot be read"), HasSubstr("camera.fx")));
}

}  // namespace
}  // namespace loopsift
