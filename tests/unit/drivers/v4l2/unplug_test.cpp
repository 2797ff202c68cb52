// SPDX-License-Identifier: MIT
// A device that stumbles or goes away while it streams.
#include <gmock/gmock.h>

#include <cerrno>

#include "tests/unit/drivers/v4l2/fake_camera.hpp"

namespace loopsift {
namespace {

using test::kMs;
using ::testing::HasSubstr;

constexpr std::int64_t kStart = 1000 * kMs;

class V4l2Unplug : public test::FakeCamera {
 protected:
  // kLost, and lost it stays; everything can be given back all the same.
  void expect_lost(const std::string& why) {
    EXPECT_EQ(read(), ReadStatus::kLost);
    EXPECT_THAT(source_->message(), HasSubstr(why));
    EXPECT_EQ(read(), ReadStatus::kLost);
    EXPECT_THAT(source_->message(), HasSubstr(why));
    source_.reset();
    EXPECT_TRUE(video_.all_given_back());
  }
};

TEST_F(V4l2Unplug, WhileWaiting) {
  test::VideoEvent gone;
  gone.kind = test::VideoEvent::Kind::kPollError;
  gone.error_number = ENODEV;
  video_.events = {depth_frame(0, kStart), gone};
  open();
  EXPECT_EQ(read(), ReadStatus::kFrame);
  expect_lost("No such device");
}

TEST_F(V4l2Unplug, WhileTakingAFrame) {
  video_.events = {depth_frame(0, kStart), take_error(ENODEV)};
  open();
  EXPECT_EQ(read(), ReadStatus::kFrame);
  expect_lost("v4l2:/dev/video0: the device is gone");
}

TEST_F(V4l2Unplug, WhileGivingTheBufferBackTheFrameStillCounts) {
  video_.events = {depth_frame(0, kStart), depth_frame(1, kStart)};
  open();
  video_.fail(VIDIOC_QBUF, ENODEV, 1, 100);
  video_.fail(VIDIOC_STREAMOFF, ENODEV, 1, 100);
  EXPECT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_EQ(read(), ReadStatus::kLost);
}

TEST_F(V4l2Unplug, TheSameNodeOpensAgain) {
  for (int k = 0; k < 10; ++k) {
    video_.events.push_back(depth_frame(0, kStart));
    video_.events.push_back(take_error(ENODEV));
  }
  for (int k = 0; k < 10; ++k) {
    open();
    EXPECT_EQ(read(), ReadStatus::kFrame) << k;
    expect_lost("No such device");
    EXPECT_EQ(open_error("/dev/video1").code, ErrorCode::kNotFound);  // while it is away
  }
  EXPECT_EQ(video_.stream_starts, 10);
}

TEST_F(V4l2Unplug, AnInputOutputErrorStartsTheStreamAnew) {
  video_.events = {depth_frame(5, kStart - 3 * kMs), take_error(EIO), depth_frame(0, kStart - 2 * kMs)};
  open();
  EXPECT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), HasSubstr("started again: Input/output error"));
  EXPECT_EQ(video_.stream_starts, 2);
  EXPECT_EQ(video_.buffers_with_device(), 4);
  EXPECT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(frame_.sequence, 1);
}

TEST_F(V4l2Unplug, APollErrorThatNoCallExplainsStartsTheStreamAnew) {
  test::VideoEvent stuck = take_error(EAGAIN);
  stuck.poll_error_flag = true;
  video_.events = {stuck, depth_frame(0, kStart)};
  open();
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_EQ(read(), ReadStatus::kFrame);
}

TEST_F(V4l2Unplug, InputOutputErrorsWithoutEndAreALoss) {
  for (int k = 0; k < 10; ++k) video_.events.push_back(take_error(EIO));
  open();
  for (int k = 0; k < 3; ++k) EXPECT_EQ(read(), ReadStatus::kBad);
  expect_lost("Input/output error");
}

TEST_F(V4l2Unplug, AGoodFrameBetweenErrorsForgivesThem) {
  for (std::uint32_t k = 0; k < 10; ++k) {
    video_.events.push_back(take_error(EIO));
    video_.events.push_back(depth_frame(k, kStart - 100 * kMs + k * kMs));
  }
  open();
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(read(), ReadStatus::kBad);
    EXPECT_EQ(read(), ReadStatus::kFrame);
  }
}

TEST_F(V4l2Unplug, AStreamThatDoesNotStartAgainIsALoss) {
  video_.events = {take_error(EIO)};
  open();
  video_.fail(VIDIOC_STREAMON, ENODEV);
  expect_lost("No such device");
}

TEST_F(V4l2Unplug, ADriverThatBreaksTheRulesIsALoss) {
  video_.events = {depth_frame(0, kStart)};
  video_.events[0].bytes_used = 1'000'000;  // more than the buffer holds
  open();
  expect_lost("Protocol error");
}

}  // namespace
}  // namespace loopsift
