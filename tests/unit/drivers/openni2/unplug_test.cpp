// SPDX-License-Identifier: MIT
// A camera that goes away and comes back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/drivers/openni2/camera_fixture.hpp"

namespace loopsift {
namespace {

using test::CameraFixture;
using ::testing::HasSubstr;

class OpenNi2Unplug : public CameraFixture {
 protected:
  OpenNi2Unplug() {
    film(30, 64, 48);
    options.camera.width = 64;
    options.camera.height = 48;
    camera.control.rate_hz = 120;
    camera.apply();
  }
  void plug(bool in) {
    camera.control.plugged = in;
    camera.apply();
  }
  /// Until the source says something else than a frame.
  [[nodiscard]] ReadStatus read_until_lost(FrameSource& source) const {
    test::FrameBuffers buffers(source.info());
    ReadStatus status = ReadStatus::kFrame;
    while (status == ReadStatus::kFrame) status = read(source, buffers.frame);
    return status;
  }
};

TEST_F(OpenNi2Unplug, TenTimes) {
  for (int round = 0; round < 10; ++round) {
    auto source = open_when_there();
    ASSERT_TRUE(source.ok()) << round << ": " << source.error().message;
    ASSERT_EQ(read_frames(**source, 3).size(), 3U) << round;
    plug(false);
    ASSERT_EQ(read_until_lost(**source), ReadStatus::kLost) << round;
    EXPECT_THAT((*source)->message(), HasSubstr("unplugged"));
    source->reset();
    const auto without = open();
    ASSERT_FALSE(without.ok());
    EXPECT_EQ(without.error().code, ErrorCode::kNotFound);
    plug(true);
  }
}

TEST_F(OpenNi2Unplug, AnOldSourceMayOutliveTheReturn) {
  auto lost = open_when_there();
  ASSERT_TRUE(lost.ok());
  (void)read_frames(**lost, 1);
  plug(false);
  ASSERT_EQ(read_until_lost(**lost), ReadStatus::kLost);
  plug(true);
  auto back = open_when_there();
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(read_frames(**back, 3).size(), 3U);
  lost->reset();
  EXPECT_EQ(read_frames(**back, 3).size(), 3U);
}

TEST_F(OpenNi2Unplug, ASilentCameraTimesOutAndGoesOn) {
  const auto source = open_when_there();
  ASSERT_TRUE(source.ok());
  (void)read_frames(**source, 2);
  camera.control.silent = true;
  camera.apply();
  test::FrameBuffers buffers((*source)->info());
  const std::int64_t limit_ns = steady_now_ns() + test::kLimitNs;
  ReadStatus status = ReadStatus::kFrame;
  while (status == ReadStatus::kFrame && steady_now_ns() < limit_ns)
    status = (*source)->read(buffers.frame, 300);
  EXPECT_EQ(status, ReadStatus::kTimeout);
  camera.control.silent = false;
  camera.apply();
  EXPECT_EQ(read_frames(**source, 3).size(), 3U);
}

}  // namespace
}  // namespace loopsift
