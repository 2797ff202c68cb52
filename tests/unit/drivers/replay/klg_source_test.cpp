// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "drivers/replay/replay_source.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::FrameBuffers;
using test::KlgFrame;
using test::TemporaryFolder;
using ::testing::HasSubstr;

constexpr int kWidth = 40, kHeight = 30;

class KlgReplay : public ::testing::Test {
 protected:
  KlgReplay() { folder_.write("camera.txt", "fx 50\nfy 50\ncx 19.5\ncy 14.5\nwidth 40\nheight 30\n"); }
  std::unique_ptr<FrameSource> open(const std::vector<KlgFrame>& frames, const SourceOptions& options = {}) {
    test::write_klg(folder_ / "a.klg", frames);
    return reopen(options);
  }
  std::unique_ptr<FrameSource> reopen(const SourceOptions& options = {}) {
    auto source = open_replay("klg", folder_ / "a.klg", options);
    if (source.ok()) return std::move(*source);
    ADD_FAILURE() << source.error().message;
    return nullptr;
  }
  static test::DepthImage depth(int seed) { return test::make_depth(kWidth, kHeight, seed); }
  static test::ColorImage color(int seed) { return test::make_color(kWidth, kHeight, seed); }
  static std::vector<KlgFrame> three_frames() {
    return {{1000, test::zlib_bytes(depth(0)), test::jpeg_bytes(color(0))},
            {34000, test::raw_bytes(depth(1)), test::raw_bytes(color(1))},
            {67000, test::zlib_bytes(depth(2)), {}}};
  }

  TemporaryFolder folder_;
};

TEST_F(KlgReplay, CompressedAndRawFrames) {
  const auto source = open(three_frames());
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().frame_count, 3);
  EXPECT_EQ(source->info().color_width, kWidth);
  FrameBuffers buffers(source->info());
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame) << source->message();
    EXPECT_EQ(buffers.frame.timestamp_ns, 1'000'000 + 33'000'000 * k);
    EXPECT_EQ(buffers.frame.sequence, k);
    EXPECT_TRUE(test::equal(buffers.frame.depth, depth(k).view()));
    ASSERT_EQ(buffers.frame.color.empty(), k == 2);
    if (k < 2) {
      EXPECT_LE(test::largest_difference(buffers.frame.color, color(k).view()), k == 0 ? 12 : 0);
    }
  }
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kEnd);
}

TEST_F(KlgReplay, UnwantedColorIsPassedOver) {
  SourceOptions options;
  options.want_color = false;
  const auto source = open(three_frames(), options);
  ASSERT_NE(source, nullptr);
  FrameBuffers buffers(source->info());
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame) << source->message();
    EXPECT_TRUE(buffers.frame.color.empty());
    EXPECT_TRUE(test::equal(buffers.frame.depth, depth(k).view()));
  }
}

TEST_F(KlgReplay, ACorruptFrameIsBadAndTheNextOneComes) {
  std::vector<KlgFrame> frames = three_frames();
  frames[0].depth[20] ^= 0x55;
  frames[1].depth = test::zlib_bytes(test::make_depth(kWidth, kHeight / 2, 1));
  const auto source = open(frames);
  ASSERT_NE(source, nullptr);
  FrameBuffers buffers(source->info());
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_THAT(source->message(), HasSubstr("a.klg, frame 0: the depth image is corrupt"));
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_TRUE(test::equal(buffers.frame.depth, depth(2).view()));
}

TEST_F(KlgReplay, ABrokenJpegLeavesTheDepthAndAMessage) {
  std::vector<KlgFrame> frames = three_frames();
  frames[1].image = {frames[0].image.begin(), frames[0].image.begin() + 300};
  const auto source = open(frames);
  ASSERT_NE(source, nullptr);
  FrameBuffers buffers(source->info());
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_TRUE(buffers.frame.color.empty());
  EXPECT_THAT(source->message(), HasSubstr("frame 1: the JPEG is truncated"));
}

// Its decoder would take 11 GB.
TEST_F(KlgReplay, AJpegThatClaimsAHugeImageIsNoColour) {
  std::vector<KlgFrame> frames = three_frames();
  frames[0].image = test::claim_jpeg_size(frames[0].image, 60000, 30000);
  const auto source = open(frames);
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().color_width, 0);
  FrameBuffers buffers(source->info());
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_TRUE(test::equal(buffers.frame.depth, depth(0).view()));
}

TEST_F(KlgReplay, ATruncatedFileEndsWithItsLastWholeFrame) {
  test::write_klg(folder_ / "a.klg", three_frames());
  test::truncate_file(folder_ / "a.klg", 0.95);
  const auto source = reopen();
  ASSERT_NE(source, nullptr);
  FrameBuffers buffers(source->info());
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_THAT(source->message(), HasSubstr("frame 2: the file is truncated"));
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kEnd);
}

TEST_F(KlgReplay, DamagedSizesEndTheRecording) {
  std::vector<KlgFrame> frames = three_frames();
  frames[1].depth.resize(1 << 20);
  const auto source = open(frames);
  ASSERT_NE(source, nullptr);
  FrameBuffers buffers(source->info());
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_THAT(source->message(), HasSubstr("size fields are damaged"));
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kEnd);
}

TEST_F(KlgReplay, TimeThatGoesBackIsBad) {
  std::vector<KlgFrame> frames = three_frames();
  frames[1].timestamp_us = 1000;
  const auto source = open(frames);
  ASSERT_NE(source, nullptr);
  FrameBuffers buffers(source->info());
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_THAT(source->message(), HasSubstr("time stamp does not go forward"));
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame);
}

// Multiplied without a look they overflow (found by fuzzing).
TEST_F(KlgReplay, TimesThatNanosecondsCannotHoldAreBad) {
  constexpr std::int64_t kLowest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kHighest = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t time_us :
       {kLowest, kLowest / 1000 - 1, std::int64_t{-1}, kHighest / 1000 + 1, kHighest}) {
    std::vector<KlgFrame> frames = three_frames();
    frames[0].timestamp_us = time_us;
    const auto source = open(frames);
    ASSERT_NE(source, nullptr);
    FrameBuffers buffers(source->info());
    EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kBad) << time_us;
    EXPECT_THAT(source->message(), HasSubstr("time stamp"));
    EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kFrame) << time_us;
  }
}

TEST_F(KlgReplay, MissingAndEmptyFilesAreErrors) {
  const auto missing = open_replay("klg", folder_ / "none.klg", {});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  folder_.write("empty.klg", "");
  EXPECT_THAT(open_replay("klg", folder_ / "empty.klg", {}).error().message,
              HasSubstr("empty.klg: holds no frames"));
}

}  // namespace
}  // namespace loopsift
