// SPDX-License-Identifier: MIT
#include "drivers/calibration/calibrated_source.hpp"

#include <gmock/gmock.h>

#include "tests/support/listed_source.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/unit/drivers/calibration/distorted_scene.hpp"

namespace loopsift {
namespace {

using test::DistortedScene;
using test::FrameBuffers;
using test::ListedFrame;
using test::ListedSource;
using ::testing::AllOf;
using ::testing::HasSubstr;

SourceInfo info_of(const DistortedScene& scene) {
  SourceInfo info;
  info.camera = scene.calibration.depth.camera;
  info.color_width = scene.calibration.color.camera.width;
  info.color_height = scene.calibration.color.camera.height;
  return info;
}

std::unique_ptr<FrameSource> source_of(const SourceInfo& info, std::vector<ListedFrame> frames = {}) {
  return std::make_unique<ListedSource>(info, std::move(frames));
}

Error error_of(const SourceInfo& info, const CameraCalibration& calibration,
               const std::vector<std::uint16_t>& factors = {}) {
  const auto source = CalibratedSource::create(source_of(info), calibration, factors);
  return source.ok() ? Error{ErrorCode::kUsage, "made"} : source.error();
}

TEST(CalibratedSource, DepthAndColorComeOutAsOneIdealCameraSeesThem) {
  const DistortedScene scene;
  ListedFrame frame;
  frame.timestamp_ns = 42;
  frame.depth = scene.device_depth();
  frame.color = scene.device_color(scene.calibration.color, scene.calibration.T_color_depth);
  auto source = CalibratedSource::create(source_of(info_of(scene), {frame}), scene.calibration, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ((*source)->info().color_width, 160);
  EXPECT_EQ((*source)->info().color_height, 120);
  FrameBuffers buffers((*source)->info());
  ASSERT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ(buffers.frame.timestamp_ns, 42);
  ASSERT_EQ(buffers.frame.depth.data, buffers.frame.depth_buffer.data()) << "the caller's buffer";
  ASSERT_EQ(buffers.frame.color.data, buffers.frame.color_buffer.data());
  for (int v = 20; v < 100; v += 5) {
    for (int u = 20; u < 140; u += 5) {
      const Eigen::Vector3d point = scene.ideal_point(u, v);
      EXPECT_NEAR(buffers.frame.depth(u, v), point.z() * 1000, 6.0);
      EXPECT_NEAR(buffers.frame.color(u, v).r, DistortedScene::texture(point), 4.0);
    }
  }
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kEnd);
  EXPECT_EQ(buffers.frame.depth_buffer.size(), 160U * 120U) << "the caller's buffers are given back";
}

TEST(CalibratedSource, AlignedColorGoesThroughTheDepthsLens) {
  DistortedScene scene;
  scene.calibration.color = {};
  scene.calibration.depth.mirrored = scene.calibration.color.mirrored = true;
  SourceInfo info = info_of(scene);
  info.color_width = 320;  // twice the depth image
  info.color_height = 240;
  LensCalibration lens = scene.calibration.depth;
  lens.camera = {320, 240, 290.0F, 292.0F, 158.5F, 121.5F};
  ListedFrame frame;
  frame.depth = scene.device_depth();
  frame.color = scene.device_color(lens, {});
  auto source = CalibratedSource::create(source_of(info, {frame}), scene.calibration, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  FrameBuffers buffers((*source)->info());
  ASSERT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  for (int v = 20; v < 100; v += 5)
    for (int u = 20; u < 140; u += 5)
      EXPECT_NEAR(buffers.frame.color(u, v).r, DistortedScene::texture(scene.ideal_point(u, v)), 3.0);
}

TEST(CalibratedSource, WhatChangesNothingIsLeftOut) {
  DistortedScene scene;
  const SourceInfo info = info_of(scene);
  scene.calibration.depth.distortion = {};
  scene.calibration.color = {};
  scene.calibration.T_color_depth = {};
  auto inner = source_of(info);
  const FrameSource* const same = inner.get();
  const auto source = CalibratedSource::create(std::move(inner), scene.calibration, {});
  ASSERT_TRUE(source.ok());
  EXPECT_EQ(source->get(), same);
}

TEST(CalibratedSource, DepthAloneIsEnoughAndFramesWithoutColorStayWithout) {
  const DistortedScene scene;
  ListedFrame with, without;
  with.depth_value = without.depth_value = 1000;
  without.has_color = false;
  auto source = CalibratedSource::create(source_of(info_of(scene), {without, with}), scene.calibration, {});
  ASSERT_TRUE(source.ok());
  FrameBuffers buffers((*source)->info());
  ASSERT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_TRUE(buffers.frame.color.empty());
  EXPECT_EQ(buffers.frame.depth(80, 60), 1000);
  SourceInfo depth_only = info_of(scene);
  depth_only.color_width = depth_only.color_height = 0;
  EXPECT_TRUE(CalibratedSource::create(source_of(depth_only), scene.calibration, {}).ok());
}

TEST(CalibratedSource, AMessageAndABadFrameComeThrough) {
  const DistortedScene scene;
  ListedFrame bad;
  bad.status = ReadStatus::kBad;
  bad.message = "torn";
  auto source = CalibratedSource::create(source_of(info_of(scene), {bad}), scene.calibration, {});
  ASSERT_TRUE(source.ok());
  FrameBuffers buffers((*source)->info());
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_EQ((*source)->message(), "torn");
}

TEST(CalibratedSource, ASizeThatDoesNotFitNamesFileAndSizes) {
  const DistortedScene scene;
  SourceInfo other = info_of(scene);
  other.camera.width = 320;
  EXPECT_THAT(error_of(other, scene.calibration).message,
              AllOf(HasSubstr("test.toml"), HasSubstr("160x120"), HasSubstr("320x120")));
  other = info_of(scene);
  other.color_height = 160;
  EXPECT_THAT(error_of(other, scene.calibration).message,
              AllOf(HasSubstr("test.toml"), HasSubstr("200x150"), HasSubstr("200x160")));
  other.color_width = 400;  // the same shape, twice as large
  other.color_height = 300;
  EXPECT_EQ(error_of(other, scene.calibration).message, "made");
  EXPECT_THAT(error_of(info_of(scene), scene.calibration, std::vector<std::uint16_t>(7)).message,
              HasSubstr("160x120"));
}

TEST(CalibratedSource, ADistortionThatFoldsTheImageIsRefused) {
  DistortedScene scene;
  scene.calibration.color.distortion.k1 = -3;
  EXPECT_THAT(error_of(info_of(scene), scene.calibration).message,
              AllOf(HasSubstr("the colour camera: the distortion folds"), HasSubstr("k1")));
  scene = {};
  scene.calibration.depth.distortion.k1 = -3;
  EXPECT_THAT(error_of(info_of(scene), scene.calibration).message,
              HasSubstr("the depth camera: the distortion"));
}

}  // namespace
}  // namespace loopsift
