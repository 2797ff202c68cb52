// SPDX-License-Identifier: MIT
#include "firmware_app/recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <random>

#include "core/base/steady_time.hpp"
#include "drivers/replay/replay_source.hpp"
#include "tests/support/in_arena.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48;
constexpr std::int64_t kLimit_ns = 60'000'000'000;

class Recorder : public ::testing::Test {
 protected:
  Recorder() : depth_(kWidth * kHeight), color_(kWidth * kHeight) {
    info_.camera = {kWidth, kHeight, 50, 51, 31.5F, 23.5F};
    info_.color_width = kWidth;
    info_.color_height = kHeight;
    info_.depth_unit_m = 0.0002;
    options_.folder = folder_ / "kept";
  }
  // Frame k, of noise that does not compress.
  RawFrame frame(int k) {
    std::mt19937 random(static_cast<unsigned>(k));
    for (std::uint16_t& value : depth_) value = static_cast<std::uint16_t>(random());
    for (Rgb8& value : color_) value = {50, static_cast<unsigned char>(k), 200};
    RawFrame frame;
    frame.timestamp_ns = 1'000'000'000 + std::int64_t{33'000'000} * k;
    frame.depth = {depth_.data(), kWidth, kHeight};
    frame.color = {color_.data(), kWidth, kHeight};
    return frame;
  }
  // Offers frame k again until it is taken, as a slow camera would.
  static void keep(FrameRecorder& recorder, const RawFrame& frame) {
    const std::int64_t before = recorder.counts().left_out, until = steady_now_ns() + kLimit_ns;
    std::int64_t refused = before;
    do {
      refused = recorder.counts().left_out;
      recorder.offer(frame);
    } while (recorder.counts().left_out > refused && steady_now_ns() < until);
  }
  std::unique_ptr<FrameSource> replayed() {
    const SourceOptions plain;
    auto source = open_replay("klg", options_.folder + "/recording.klg", plain);
    EXPECT_TRUE(source.ok()) << source.error().message;
    return source.ok() ? std::move(*source) : nullptr;
  }
  test::TemporaryFolder folder_;
  SourceInfo info_;
  RecordOptions options_;
  std::vector<std::uint16_t> depth_;
  std::vector<Rgb8> color_;
};

TEST_F(Recorder, WhatWasKeptIsReplayedAsItWas) {
  const test::InArena<FrameRecorder> recorder(options_, info_);
  EXPECT_EQ(recorder.carved_bytes(), recorder.measured_bytes());
  ASSERT_TRUE(recorder->start().ok());
  for (int k = 0; k < 30; ++k) keep(*recorder, frame(k));
  EXPECT_THAT(recorder->finish(), HasSubstr("30 frames"));
  EXPECT_EQ(recorder->finish(), "") << "once";

  const auto source = replayed();
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().frame_count, 30);
  EXPECT_EQ(source->info().camera.fy, 51);
  EXPECT_EQ(source->info().color_width, kWidth);
  EXPECT_NEAR(source->info().depth_unit_m, 0.0002, 1e-12);
  std::vector<std::uint16_t> depth(depth_.size());
  std::vector<Rgb8> color(color_.size());
  RawFrame read;
  read.depth_buffer = depth;
  read.color_buffer = color;
  for (int k = 0; k < 30; ++k) {
    ASSERT_EQ(source->read(read, 0), ReadStatus::kFrame) << source->message();
    EXPECT_EQ(read.timestamp_ns, frame(k).timestamp_ns);
    EXPECT_EQ(depth, depth_) << k;
    EXPECT_NEAR(read.color(5, 5).g, k, 4);
  }
  EXPECT_EQ(source->read(read, 0), ReadStatus::kEnd);
}

TEST_F(Recorder, TheFileIsWholeAfterEachFrame) {
  const test::InArena<FrameRecorder> recorder(options_, info_);
  ASSERT_TRUE(recorder->start().ok());
  keep(*recorder, frame(0));
  keep(*recorder, frame(1));
  const std::int64_t until = steady_now_ns() + kLimit_ns;
  while (recorder->counts().written < 2 && steady_now_ns() < until) {
  }
  const auto source = replayed();
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().frame_count, 2);
}

TEST_F(Recorder, EndsAtItsLimitAndTheRestIsNotMissed) {
  options_.max_mib = 1;
  const test::InArena<FrameRecorder> recorder(options_, info_);
  ASSERT_TRUE(recorder->start().ok());
  const int frames = (1 << 20) / (2 * kWidth * kHeight) + 20;
  for (int k = 0; k < frames; ++k) keep(*recorder, frame(k));
  (void)recorder->finish();
  EXPECT_TRUE(recorder->counts().full);
  EXPECT_LE(std::filesystem::file_size(options_.folder + "/recording.klg"), std::uintmax_t{1} << 20);
  const auto source = replayed();
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().frame_count, recorder->counts().written);
  EXPECT_GT(recorder->counts().written, 100);
}

TEST_F(Recorder, AFullDiskEndsTheRecordingAndLeavesWhatIsWhole) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const test::InArena<FrameRecorder> recorder(options_, info_);
  ASSERT_TRUE(recorder->start().ok());
  const rlimit small{40'000, before.rlim_max};  // some six frames
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  for (int k = 0; k < 30; ++k) keep(*recorder, frame(k));
  (void)recorder->finish();
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(recorder->counts().full);
  EXPECT_GT(recorder->counts().written, 2);
  EXPECT_LT(recorder->counts().written, 10);
  const auto source = replayed();
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().frame_count, recorder->counts().written);
  EXPECT_EQ(static_cast<std::int64_t>(std::filesystem::file_size(options_.folder + "/recording.klg")),
            recorder->counts().bytes);
}

TEST_F(Recorder, WithoutAFreeSlotAFrameIsLeftOutAndNobodyWaits) {
  const test::InArena<FrameRecorder> recorder(options_, info_);
  for (int k = 0; k < 5; ++k) recorder->offer(frame(k));  // not started: no slot is free yet
  EXPECT_EQ(recorder->counts().left_out, 5);
}

TEST_F(Recorder, BeginsWithTheFirstColourAndGoesOnWithout) {
  const test::InArena<FrameRecorder> recorder(options_, info_);
  ASSERT_TRUE(recorder->start().ok());
  RawFrame grey = frame(0);
  grey.color = {};
  keep(*recorder, grey);
  keep(*recorder, frame(1));
  grey = frame(2);
  grey.color = {};
  keep(*recorder, grey);
  (void)recorder->finish();
  EXPECT_EQ(recorder->counts().written, 2);
  const auto source = replayed();
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().color_width, kWidth);
}

TEST_F(Recorder, NeverWritesOverARecording) {
  folder_.write("kept/recording.klg", "precious");
  const test::InArena<FrameRecorder> recorder(options_, info_);
  const Status started = recorder->start();
  ASSERT_FALSE(started.ok());
  EXPECT_THAT(started.error().message, HasSubstr("recording.klg"));
  EXPECT_EQ(std::filesystem::file_size(folder_ / "kept/recording.klg"), 8U);
}

TEST_F(Recorder, WithoutAFolderItHoldsNoMemoryAndDoesNothing) {
  options_.folder.clear();
  const test::InArena<FrameRecorder> recorder(options_, info_);
  EXPECT_EQ(recorder.measured_bytes(), 0U);
  ASSERT_TRUE(recorder->start().ok());
  recorder->offer(frame(0));
  EXPECT_EQ(recorder->finish(), "");
}

}  // namespace
}  // namespace loopsift
