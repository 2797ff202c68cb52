// SPDX-License-Identifier: MIT
#include "drivers/lcm/lcm_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/steady_time.hpp"
#include "drivers/lcm/lcm_clock.hpp"
#include "tests/support/lcm_images.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 12, kHeight = 5;
constexpr int kLong_ms = 60000;  // far longer than any of these tests takes
constexpr std::int64_t kFirst_us = 1'600'000'000'000'000, kPeriod_us = 33'333;

/// An LCM within the process, which keeps messages on CAMERA from now on: those without a subscriber it
/// drops.
lcm_t* make_bus() {
  lcm_t* lcm = lcm_create("memq://");
  const auto ignore = [](const lcm_recv_buf_t* /*received*/, const char* /*channel*/, void* /*user*/) {};
  lcm_subscribe(lcm, "CAMERA", ignore, nullptr);
  return lcm;
}

/// Sender and source on one LCM.
class LcmSourceTest : public ::testing::Test {
 protected:
  LcmSourceTest() : lcm_(make_bus()) {
    depth_.resize(kWidth * kHeight);
    color_.resize(kWidth * kHeight);
    frame_.depth_buffer = depth_;
    frame_.color_buffer = color_;
  }
  void send(const std::vector<std::uint8_t>& bytes) {
    ASSERT_EQ(lcm_publish(lcm_, "CAMERA", bytes.data(), static_cast<unsigned>(bytes.size())), 0);
  }
  void send(std::int64_t utime_us, std::uint16_t value = 700) {
    send(test::encode(test::images(utime_us, kWidth, kHeight, value)));
  }
  void open() {
    send(kFirst_us - kPeriod_us);
    auto opened = open_lcm(lcm_, "CAMERA", options_);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    source_ = std::move(*opened);
  }
  ReadStatus read() { return source_->read(frame_, kLong_ms); }

  lcm_t* lcm_;
  SourceOptions options_;
  std::unique_ptr<FrameSource> source_;
  std::vector<std::uint16_t> depth_;
  std::vector<Rgb8> color_;
  RawFrame frame_;
};

TEST_F(LcmSourceTest, TheFirstMessageSaysTheSizesAndEachLaterOneIsAFrame) {
  open();
  EXPECT_TRUE(source_->info().live);
  EXPECT_EQ(source_->info().camera.width, kWidth);
  EXPECT_EQ(source_->info().color_height, kHeight);
  EXPECT_DOUBLE_EQ(source_->info().depth_unit_m, 0.001);
  for (int k = 0; k < 20; ++k) {
    send(kFirst_us + k * kPeriod_us, static_cast<std::uint16_t>(100 * k));
    ASSERT_EQ(read(), ReadStatus::kFrame) << source_->message();
    EXPECT_EQ(frame_.timestamp_ns, (kFirst_us + k * kPeriod_us) * 1000);
    EXPECT_EQ(frame_.sequence, k);
    EXPECT_GT(frame_.captured_ns, 0);
    EXPECT_EQ(frame_.depth(2, 1), 100 * k + 2);
    EXPECT_EQ(frame_.color(2, 1).g, 100 * k % 256);
    EXPECT_EQ(source_->message(), "");
  }
}

TEST_F(LcmSourceTest, SilenceIsATimeoutAndNothingThatCameMeanwhileIsLost) {
  open();
  EXPECT_EQ(source_->read(frame_, 1), ReadStatus::kTimeout);
  for (int k = 0; k < 5; ++k) send(kFirst_us + k * kPeriod_us);
  for (int k = 0; k < 5; ++k) {
    ReadStatus status = ReadStatus::kTimeout;
    const std::int64_t until = steady_now_ns() + std::int64_t{kLong_ms} * 1'000'000;
    while (status == ReadStatus::kTimeout && steady_now_ns() < until) status = source_->read(frame_, 0);
    ASSERT_EQ(status, ReadStatus::kFrame);
    EXPECT_EQ(frame_.timestamp_ns, (kFirst_us + k * kPeriod_us) * 1000);
  }
}

TEST_F(LcmSourceTest, RepeatedLateAndBrokenMessagesAreSkippedWithAWord) {
  open();
  send(kFirst_us);
  ASSERT_EQ(read(), ReadStatus::kFrame);
  send(kFirst_us);
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), HasSubstr("lcm:CAMERA: a message was repeated"));
  send(kFirst_us - kPeriod_us);
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), HasSubstr("after a later one"));
  send(std::vector<std::uint8_t>(40, 7));
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), HasSubstr("no bot_core.images_t"));
  send(-5);
  EXPECT_EQ(read(), ReadStatus::kBad);
  send(test::encode(test::images(kFirst_us + kPeriod_us, 2 * kWidth, kHeight, 1)));
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), HasSubstr("another size"));
  send(kFirst_us + 1'000'000'000);  // a long gap is none of this one's business
  EXPECT_EQ(read(), ReadStatus::kFrame);
}

TEST_F(LcmSourceTest, BrokenColourLeavesTheDepth) {
  open();
  bot_core::images_t message = test::images(kFirst_us, kWidth, kHeight, 300);
  message.images[0].pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
  send(test::encode(message));
  EXPECT_EQ(read(), ReadStatus::kFrame);
  EXPECT_TRUE(frame_.color.empty());
  EXPECT_NE(source_->message(), "");
  EXPECT_EQ(frame_.depth(0, 0), 300);
}

TEST_F(LcmSourceTest, ASenderThatStartsAnewIsALoss) {
  open();
  send(kFirst_us);
  ASSERT_EQ(read(), ReadStatus::kFrame);
  send(5'000'000);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_THAT(source_->message(), HasSubstr("started anew"));
}

TEST_F(LcmSourceTest, OnThisHostsClockTheTimesAreThoseOfItsCameras) {
  options_.lcm_in.host_clock = true;
  open();
  const std::int64_t now_ns = steady_now_ns();
  send((now_ns - wall_to_monotonic_ns()) / 1000);
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_NEAR(static_cast<double>(frame_.timestamp_ns - now_ns), 0, 1001);
}

TEST_F(LcmSourceTest, TheCameraIsTheSettingsOrAKinect) {
  options_.camera.fx = 33;
  options_.want_color = false;
  open();
  EXPECT_EQ(source_->info().camera.fx, 33);
  EXPECT_EQ(source_->info().camera.cx, (kWidth - 1) / 2.0F);
  EXPECT_EQ(source_->info().color_width, 0);
}

TEST(LcmSourceOpening, SaysWhatIsMissing) {
  SourceOptions options;
  options.lcm_in.open_timeout_s = 0.05;
  const auto silent = open_lcm(make_bus(), "CAMERA", options);
  ASSERT_FALSE(silent.ok());
  EXPECT_EQ(silent.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(silent.error().message, HasSubstr("lcm:CAMERA: no message came"));

  lcm_t* lcm = make_bus();
  const std::vector<std::uint8_t> wrong(16, 1);
  ASSERT_EQ(lcm_publish(lcm, "CAMERA", wrong.data(), 16), 0);
  const auto foreign = open_lcm(lcm, "CAMERA", options);
  ASSERT_FALSE(foreign.ok());
  EXPECT_THAT(foreign.error().message, HasSubstr("no bot_core.images_t"));

  options.lcm_in.url = "nonsense://";
  const auto unreachable = open_lcm("CAMERA", options);
  ASSERT_FALSE(unreachable.ok());
  EXPECT_THAT(unreachable.error().message, HasSubstr("lcm_in.url"));
  EXPECT_EQ(open_lcm("", options).error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace loopsift
