// SPDX-License-Identifier: MIT
#include "firmware_app/supervised_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "core/base/steady_time.hpp"
#include "tests/support/fake_camera.hpp"

namespace loopsift {
namespace {

using test::Cable;
using test::FakeCamera;
using ::testing::HasSubstr;

constexpr int kTimeout_ms = 5, kWellIntoTheWait_ms = 50;
constexpr std::int64_t kLimit_ns = 60'000'000'000;  // far longer than any of these tests takes

class SupervisedSourceTest : public ::testing::Test {
 protected:
  SupervisedSourceTest() : depth_(kWidth * kHeight) {
    cable_.info.camera = {kWidth, kHeight, 10, 10, 4, 2};
    cable_.info.live = true;
    cable_.info.description = "fake camera";
    options_.retry_first_ms = 1;
    options_.retry_max_ms = 2;
    frame_.depth_buffer = {depth_.data(), depth_.size()};
  }
  void open(int frames, int frames_after) {
    cable_.frames_after = frames;
    auto opened = FakeCamera::open(cable_);
    ASSERT_TRUE(opened.ok());
    cable_.frames_after = frames_after;
    source_ = std::make_unique<SupervisedSource>(
        std::move(*opened), [this] { return FakeCamera::open(cable_); }, options_);
    source_->start();
  }
  // The next thing that is no timeout.
  ReadStatus read() {
    const std::int64_t until = steady_now_ns() + kLimit_ns;
    ReadStatus status = ReadStatus::kTimeout;
    while (status == ReadStatus::kTimeout && steady_now_ns() < until)
      status = source_->read(frame_, kTimeout_ms);
    return status;
  }

  static constexpr int kWidth = 8, kHeight = 4;
  Cable cable_;
  RetryOptions options_;
  std::vector<std::uint16_t> depth_;
  RawFrame frame_;
  std::unique_ptr<SupervisedSource> source_;
};

TEST_F(SupervisedSourceTest, WhatIsPulledOutAndComesBackGoesOnInANewSession) {
  open(3, 2);
  cable_.refusals = 4;
  std::int64_t last_ns = -1;
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(read(), ReadStatus::kFrame);
    EXPECT_EQ(frame_.session, 0);
    EXPECT_EQ(frame_.sequence, k);
    last_ns = frame_.timestamp_ns;
  }
  EXPECT_FALSE(source_->away());
  ASSERT_EQ(source_->read(frame_, kTimeout_ms), ReadStatus::kTimeout) << "the loss is no end";
  EXPECT_TRUE(source_->away());
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_FALSE(source_->away());
  EXPECT_EQ(frame_.session, 1);
  EXPECT_EQ(frame_.sequence, 3) << "frame numbers go on";
  EXPECT_GT(frame_.timestamp_ns, last_ns) << "its clock began anew, the run's does not";
  const std::int64_t first_back_ns = frame_.timestamp_ns;
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(frame_.timestamp_ns - first_back_ns, 33'333'333) << "within an opening the source's own times";
  EXPECT_EQ(source_->returns(), 1);
  EXPECT_EQ(cable_.opened, 2);
  EXPECT_EQ(cable_.alive, 1) << "the lost one was closed";
}

TEST_F(SupervisedSourceTest, WithItsTriesUsedUpItIsLostAndStaysSo) {
  options_.retry_limit = 3;
  open(1, 0);
  cable_.refusals = 1000;
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_THAT(source_->message(), HasSubstr("pulled out"));
  EXPECT_THAT(source_->message(), HasSubstr("3 tries"));
  EXPECT_THAT(source_->message(), HasSubstr("no such device"));
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_EQ(cable_.tried, 1 + 3);
}

TEST_F(SupervisedSourceTest, AnOpeningWithoutAFrameIsATryInVain) {
  options_.retry_limit = 5;
  open(1, 0);  // opens again each time, and is lost at once
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_EQ(cable_.opened, 1 + 5);
}

TEST_F(SupervisedSourceTest, AFrameStartsTheCountOfTriesAnew) {
  options_.retry_limit = 2;
  open(1, 1);
  for (int k = 0; k < 8; ++k) {
    ASSERT_EQ(read(), ReadStatus::kFrame) << k;
    EXPECT_EQ(frame_.session, k);
    cable_.refusals = 1;
  }
}

TEST_F(SupervisedSourceTest, SilenceIsALoss) {
  options_.stall_periods = 3;
  cable_.silent_at_end = true;
  open(2, 2);
  for (int k = 0; k < 6; ++k) {
    ASSERT_EQ(read(), ReadStatus::kFrame) << k;
    EXPECT_EQ(frame_.session, k / 2);
  }
}

TEST_F(SupervisedSourceTest, AnotherImageSizeIsRefusedWithAWord) {
  options_.retry_limit = 2;
  open(1, 1);
  cable_.info.camera.width = 4 * kWidth;  // a larger image would not fit the frames' memory
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_THAT(source_->message(), HasSubstr("other images (32 x 4 depth"));
  EXPECT_EQ(cable_.alive, 0);
}

TEST_F(SupervisedSourceTest, AnotherCameraOfTheSameSizeIsRefused) {
  options_.retry_limit = 1;
  open(1, 1);
  cable_.info.camera.fx = 20;
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_THAT(source_->message(), HasSubstr("another camera"));
}

TEST_F(SupervisedSourceTest, ARecordingIsNeverOpenedAgain) {
  cable_.info.live = false;
  open(1, 1);
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_EQ(source_->message(), "pulled out");
  EXPECT_EQ(cable_.tried, 1);
}

TEST_F(SupervisedSourceTest, WithoutTriesTheFirstLossIsFinal) {
  options_.retry_limit = 0;
  open(1, 1);
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_EQ(cable_.tried, 1);
}

TEST_F(SupervisedSourceTest, EndsWhileItWaitsForTheNextTry) {
  options_.retry_limit = -1;
  options_.retry_first_ms = options_.retry_max_ms = 1e6;
  open(0, 0);
  ASSERT_EQ(source_->read(frame_, kTimeout_ms), ReadStatus::kTimeout);
  const std::int64_t until = steady_now_ns() + kLimit_ns;
  while (cable_.alive > 0) ASSERT_LT(steady_now_ns(), until);  // the lost one is closed just before the wait
  (void)source_->read(frame_, kWellIntoTheWait_ms);
  EXPECT_TRUE(source_->end(60'000));
}

TEST_F(SupervisedSourceTest, ADriverThatHangsInItsOpeningDoesNotHoldUpTheReaderNorTheEnd) {
  std::atomic<bool> hanging{false}, go_on{false};
  cable_.frames_after = 1;
  auto opened = FakeCamera::open(cable_);
  source_ = std::make_unique<SupervisedSource>(
      std::move(*opened),
      [&]() -> Expected<std::unique_ptr<FrameSource>> {
        hanging = true;
        while (!go_on) {
        }
        return Error{ErrorCode::kIo, "at last"};
      },
      options_);
  source_->start();
  ASSERT_EQ(read(), ReadStatus::kFrame);
  const std::int64_t until = steady_now_ns() + kLimit_ns;
  while (!hanging && steady_now_ns() < until)
    ASSERT_EQ(source_->read(frame_, kTimeout_ms), ReadStatus::kTimeout);
  EXPECT_FALSE(source_->end(10));
  go_on = true;
  EXPECT_TRUE(source_->end(60'000));
}

TEST_F(SupervisedSourceTest, AtTheStartACameraIsWaitedForAndAWrongSettingIsNot) {
  options_.first_retry_limit = 3;
  std::atomic<bool> stop{false};
  cable_.refusals = 2;
  EXPECT_TRUE(open_patiently([this] { return FakeCamera::open(cable_); }, options_, stop).ok());
  cable_.refusals = 4;
  const auto refused = open_patiently([this] { return FakeCamera::open(cable_); }, options_, stop);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message, "fake: no such device");
  int calls = 0;
  const SourceOpener wrong = [&]() -> Expected<std::unique_ptr<FrameSource>> {
    ++calls;
    return Error{ErrorCode::kUsage, "no such key"};
  };
  EXPECT_FALSE(open_patiently(wrong, options_, stop).ok());
  EXPECT_EQ(calls, 1);
  stop = true;
  cable_.refusals = 1;
  cable_.tried = 0;
  EXPECT_FALSE(open_patiently([this] { return FakeCamera::open(cable_); }, options_, stop).ok());
  EXPECT_EQ(cable_.tried, 1);
}

}  // namespace
}  // namespace loopsift
