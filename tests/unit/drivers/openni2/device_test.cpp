// SPDX-License-Identifier: MIT
// The OpenNI2 driver on the test camera: opening, modes, images, times, pairing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "tests/unit/drivers/openni2/camera_fixture.hpp"

namespace loopsift {
namespace {

using test::CameraFixture;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48, kFrames = 20;

class OpenNi2Device : public CameraFixture {
 protected:
  OpenNi2Device() {
    film(kFrames, kWidth, kHeight);
    options.camera.width = kWidth;
    options.camera.height = kHeight;
  }
  /// Of the film's images that a frame shows; the camera counts its frames from 1.
  [[nodiscard]] static int seed_of(const Seen& frame) {
    return static_cast<int>(frame.sequence - 1) % kFrames;
  }
};

TEST_F(OpenNi2Device, SaysWhatItIs) {
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_TRUE(info.live);
  EXPECT_EQ(info.frame_count, -1);
  EXPECT_EQ(info.camera.width, kWidth);
  EXPECT_EQ(info.color_width, kWidth);
  EXPECT_EQ(info.color_height, kHeight);
  EXPECT_DOUBLE_EQ(info.depth_unit_m, 1e-3);
  EXPECT_DOUBLE_EQ(info.nominal_rate_hz, 30);
  // Half of the image's width is seen under half of the field of view, 1 rad.
  EXPECT_NEAR(info.camera.fx, 32 / std::tan(0.5), 1e-3);
  EXPECT_NEAR(info.camera.fy, info.camera.fx, 1e-3);
  EXPECT_FLOAT_EQ(info.camera.cx, 31.5F);
  EXPECT_THAT(info.description, AllOf(HasSubstr("loopsift Test Camera"), HasSubstr("64x48 30 Hz, 1 mm"),
                                      HasSubstr("registered"), HasSubstr("synchronised")));
}

TEST_F(OpenNi2Device, DeliversEveryPixelOfDepthAndItsColor) {
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  // A reader that comes late may find the colour image of the next depth image: then there is none.
  for (int with_color = 0; with_color < 5;) {
    const Seen frame = read_frames(**source, 1).at(0);
    EXPECT_EQ(frame.depth, test::make_depth(kWidth, kHeight, seed_of(frame)).pixels);
    if (frame.color.empty()) continue;
    ASSERT_TRUE(is_color(frame, seed_of(frame)));
    ++with_color;
  }
}

TEST_F(OpenNi2Device, PairsByTimeWhereTheDeviceDoesNot) {
  options.openni2.frame_sync = false;
  camera.control.color_delay_ms = 9;
  camera.apply();
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_THAT((*source)->info().description, ::testing::Not(HasSubstr("synchronised")));
  for (const Seen& frame : read_frames(**source, 5)) {
    // A stalled reader may find a depth image whose colour is gone: no colour, but never another's.
    EXPECT_TRUE(frame.color.empty() || is_color(frame, seed_of(frame)));
  }
}

TEST_F(OpenNi2Device, GoesOnWithoutColorThatDoesNotCome) {
  options.openni2.frame_sync = false;
  camera.control.color_every = 1000;
  camera.apply();
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  Seen frame = read_frames(**source, 1).front();
  while (!frame.color.empty()) frame = read_frames(**source, 1).front();  // one of the film's has colour
  EXPECT_THAT((*source)->message(), HasSubstr("no colour image within half a frame"));
}

TEST_F(OpenNi2Device, DeliversDepthAloneOnRequest) {
  options.openni2.color = false;
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ((*source)->info().color_width, 0);
  EXPECT_TRUE(read_frames(**source, 3).back().color.empty());
  EXPECT_EQ((*source)->message(), "");
}

TEST_F(OpenNi2Device, TurnsMirroredImagesRound) {
  camera.control.mirrored = true;
  camera.apply();
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  const Seen frame = read_frames(**source, 1).front();
  const auto drawn = test::make_depth(kWidth, kHeight, seed_of(frame));
  for (std::size_t x = 0; x < kWidth; ++x) ASSERT_EQ(frame.depth[x], drawn.pixels[kWidth - 1 - x]);
}

TEST_F(OpenNi2Device, TimesAreOnTheHostsClock) {
  camera.control.time_offset_s = 12345;
  camera.apply();
  const std::int64_t before_ns = steady_now_ns();
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  const auto frames = read_frames(**source, 5);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    EXPECT_GT(frames[k].timestamp_ns, k == 0 ? before_ns : frames[k - 1].timestamp_ns);
    EXPECT_LE(frames[k].captured_ns, steady_now_ns());
  }
}

TEST_F(OpenNi2Device, TimesAreTheDevicesOwnOnRequest) {
  options.openni2.host_time = false;
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  for (const Seen& frame : read_frames(**source, 5)) {
    const std::int64_t film_us = 1'000'000 + (frame.sequence - 1) * 1'000'000 / 30;
    EXPECT_EQ(frame.timestamp_ns % 1000, 0);
    EXPECT_LE(std::abs(frame.timestamp_ns / 1000 - film_us), 100);  // each round is rounded
  }
}

TEST_F(OpenNi2Device, TimesThatGoBackAreMappedAnewOrMakeTheFrameBad) {
  for (const bool host_time : {true, false}) {
    options.openni2.host_time = host_time;
    camera.control.time_offset_s = 20;
    camera.apply();
    const auto source = open();
    ASSERT_TRUE(source.ok()) << source.error().message;
    std::int64_t last_ns = read_frames(**source, 3).back().timestamp_ns;
    camera.control.time_offset_s = 10;
    camera.apply();
    test::FrameBuffers buffers((*source)->info());
    int bad = 0;
    for (int k = 0; k < 20; ++k) {
      const ReadStatus status = read(**source, buffers.frame);
      if (status == ReadStatus::kBad) {
        EXPECT_THAT((*source)->message(), HasSubstr("is not after the one before"));
        ++bad;
        continue;
      }
      ASSERT_EQ(status, ReadStatus::kFrame) << (*source)->message();
      EXPECT_GT(buffers.frame.timestamp_ns, last_ns);
      last_ns = buffers.frame.timestamp_ns;
    }
    EXPECT_EQ(bad > 0, !host_time);
  }
}

TEST_F(OpenNi2Device, DepthInTenthsOfAMillimetre) {
  options.openni2.fine_depth = true;
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_DOUBLE_EQ((*source)->info().depth_unit_m, 1e-4);
  EXPECT_THAT((*source)->info().description, HasSubstr("0.1 mm"));
  EXPECT_EQ(read_frames(**source, 2).size(), 2U);
}

TEST_F(OpenNi2Device, WithoutRegistrationAndSyncWhenTheyAreNotWanted) {
  options.openni2.registration = false;
  options.openni2.frame_sync = false;
  const auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_THAT((*source)->info().description,
              AllOf(::testing::Not(HasSubstr("registered")), ::testing::Not(HasSubstr("synchronised"))));
}

TEST_F(OpenNi2Device, SettingsReplaceTheFieldOfView) {
  camera.control.field_of_view_rad = 0;
  camera.apply();
  const auto unknown = open();
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().code, ErrorCode::kFormat);
  EXPECT_THAT(unknown.error().message, AllOf(HasSubstr("field of view"), HasSubstr("camera.fx")));
  options.camera.fx = options.camera.fy = 55;
  options.camera.cx = 30;
  const auto known = open();
  ASSERT_TRUE(known.ok()) << known.error().message;
  EXPECT_FLOAT_EQ((*known)->info().camera.fx, 55);
  EXPECT_FLOAT_EQ((*known)->info().camera.cx, 30);
  EXPECT_FLOAT_EQ((*known)->info().camera.cy, 23.5F);
}

TEST_F(OpenNi2Device, AModeThatItHasNotIsRefusedWithThoseThatItHas) {
  options.camera.width = 320;
  const auto source = open();
  ASSERT_FALSE(source.ok());
  EXPECT_EQ(source.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(source.error().message, AllOf(HasSubstr("no mode depth 320x48 30 Hz, 1 mm"),
                                            HasSubstr("[64x48 30 Hz, 1 mm]"), HasSubstr("camera.width")));
  options.camera.width = kWidth;
  options.openni2.rate_hz = 60;
  EXPECT_FALSE(open().ok());
}

TEST_F(OpenNi2Device, ABusyDeviceIsSaidToBe) {
  camera.control.busy = true;
  camera.apply();
  const auto source = open();
  ASSERT_FALSE(source.ok());
  EXPECT_EQ(source.error().code, ErrorCode::kIo);
  EXPECT_THAT(source.error().message, AllOf(HasSubstr("in use by another program"), HasSubstr("udev")));
}

TEST_F(OpenNi2Device, NoDeviceAndAnUnknownOne) {
  const auto unknown = open("1d27/0601@9/9");
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(unknown.error().message, AllOf(HasSubstr("1d27/0601@9/9"), HasSubstr("loopsift-tool devices")));
  camera.control.plugged = false;
  camera.apply();
  const auto none = open();
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
}

TEST_F(OpenNi2Device, IsListedWithItsModes) {
  const auto devices = list_openni2_devices();
  ASSERT_EQ(devices.size(), 1U);
  EXPECT_EQ(devices[0].uri, "openni2:testcam@1");
  EXPECT_EQ(devices[0].name, "loopsift Test Camera");
  EXPECT_THAT(devices[0].formats,
              ElementsAre("depth 64x48 30 Hz, 1 mm", "depth 64x48 30 Hz, 0.1 mm", "colour 64x48 30 Hz, RGB"));
  camera.control.busy = true;
  camera.apply();
  EXPECT_THAT(list_openni2_devices().at(0).formats, ElementsAre(HasSubstr("cannot be opened")));
  camera.control.plugged = false;
  camera.apply();
  EXPECT_TRUE(list_openni2_devices().empty());
}

TEST_F(OpenNi2Device, ItsListedUriOpensIt) {
  const auto source = open("testcam@1");
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ(read_frames(**source, 1).size(), 1U);
}

}  // namespace
}  // namespace loopsift
