// SPDX-License-Identifier: MIT
// 7-Scenes, redwood and SUN3D folders.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/replay/replay_source.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::FrameBuffers;
using test::TemporaryFolder;
using ::testing::HasSubstr;

constexpr int kWidth = 40, kHeight = 30;
constexpr const char* kCamera = "fx 50\nfy 50\ncx 19.5\ncy 14.5\nwidth 40\nheight 30\n";

class NumberedReplay : public ::testing::Test {
 protected:
  NumberedReplay() { folder_.write("camera.txt", kCamera); }
  void depth(const std::string& name, int seed) const {
    test::write_depth(folder_ / name, test::make_depth(kWidth, kHeight, seed));
  }
  // Colour may have a size of its own.
  void color(const std::string& name, int seed) const {
    test::write_color_jpeg(folder_ / name, test::make_color(2 * kWidth, 2 * kHeight, seed));
  }
  std::unique_ptr<FrameSource> open(const std::string& format, const SourceOptions& options = {}) {
    auto source = open_replay(format, folder_.path(), options);
    if (source.ok()) return std::move(*source);
    ADD_FAILURE() << source.error().message;
    return nullptr;
  }
  std::string problem(const std::string& format) {
    const auto source = open_replay(format, folder_.path(), {});
    return source.ok() ? "accepted" : source.error().message;
  }
  static void expect_frame(FrameSource& source, FrameBuffers& buffers, int seed, std::int64_t time_ns,
                           bool with_color) {
    ASSERT_EQ(source.read(buffers.frame, 0), ReadStatus::kFrame) << source.message();
    EXPECT_TRUE(test::equal(buffers.frame.depth, test::make_depth(kWidth, kHeight, seed).view()))
        << "seed " << seed;
    EXPECT_EQ(buffers.frame.timestamp_ns, time_ns);
    ASSERT_EQ(buffers.frame.color.empty(), !with_color);
    if (!with_color) return;
    EXPECT_LE(
        test::largest_difference(buffers.frame.color, test::make_color(2 * kWidth, 2 * kHeight, seed).view()),
        12);
  }

  TemporaryFolder folder_;
};

TEST_F(NumberedReplay, SevenScenesIsTimedByFrameNumber) {
  depth("frame-000000.depth.png", 0);
  color("frame-000000.color.jpg", 0);
  depth("frame-000003.depth.png", 10);
  test::write_color_png(folder_ / "frame-000003.color.png", test::make_color(2 * kWidth, 2 * kHeight, 10));
  depth("frame-000004.depth.png", 20);
  folder_.write("frame-000000.pose.txt", "1 0 0 0\n");
  const auto source = open("7scenes");
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().color_width, 2 * kWidth);
  EXPECT_DOUBLE_EQ(source->info().depth_unit_m, 0.001);
  FrameBuffers buffers(source->info());
  expect_frame(*source, buffers, 0, 0, true);
  expect_frame(*source, buffers, 10, 100'000'000, true);
  EXPECT_EQ(buffers.frame.sequence, 3);
  expect_frame(*source, buffers, 20, 133'333'333, false);
  EXPECT_EQ(source->read(buffers.frame, 0), ReadStatus::kEnd);
}

TEST_F(NumberedReplay, TheRateOptionSetsTheTimeStamps) {
  depth("frame-000001.depth.png", 0);
  SourceOptions options;
  options.rate_hz = 10;
  const auto source = open("7scenes", options);
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().nominal_rate_hz, 10);
  FrameBuffers buffers(source->info());
  expect_frame(*source, buffers, 0, 100'000'000, false);
}

TEST_F(NumberedReplay, RedwoodPairsByNumberAndCountsFromItsFirst) {
  for (int k = 1; k <= 3; ++k) {
    depth("depth/0000" + std::to_string(k) + ".png", 10 * k);
    if (k != 2) color("image/0000" + std::to_string(k) + ".jpg", 10 * k);
  }
  const auto source = open("redwood");
  ASSERT_NE(source, nullptr);
  FrameBuffers buffers(source->info());
  expect_frame(*source, buffers, 10, 0, true);
  EXPECT_EQ(buffers.frame.sequence, 0);
  expect_frame(*source, buffers, 20, 33'333'333, false);
  expect_frame(*source, buffers, 30, 66'666'667, true);
}

TEST_F(NumberedReplay, RedwoodTakesColorFromTheColorFolderToo) {
  depth("depth/00000.png", 10);
  color("color/00000.jpg", 10);
  const auto source = open("redwood");
  ASSERT_NE(source, nullptr);
  FrameBuffers buffers(source->info());
  expect_frame(*source, buffers, 10, 0, true);
}

TEST_F(NumberedReplay, Sun3dUnrotatesBitsAndPairsByTheTimesInItsNames) {
  for (int k = 0; k < 3; ++k) {
    test::DepthImage rotated = test::make_depth(kWidth, kHeight, 10 * k);
    for (std::uint16_t& value : rotated.pixels) value = static_cast<std::uint16_t>(value << 3 | value >> 13);
    test::write_depth(
        folder_ / ("depth/000000" + std::to_string(k + 1) + "-00000000" + std::to_string(k) + "000.png"),
        rotated);
  }
  // Colour frame 2 was lost: numbers no longer agree, times do (1 and 2 ms after the depth).
  color("image/0000001-000000000100.jpg", 0);
  color("image/0000002-000000002100.jpg", 20);
  folder_.write("camera.txt", "width 40\n");
  folder_.write("intrinsics.txt", "50 0 20\n0 51 15\n0 0 1\n");
  SourceOptions options;
  options.rate_hz = 1000;
  const auto source = open("sun3d", options);
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().camera.fy, 51);
  EXPECT_EQ(source->info().camera.height, kHeight);
  FrameBuffers buffers(source->info());
  expect_frame(*source, buffers, 0, 0, true);
  expect_frame(*source, buffers, 10, 1'000'000, false);
  expect_frame(*source, buffers, 20, 2'000'000, true);
}

TEST_F(NumberedReplay, EmptyOrIncompleteFoldersAreErrors) {
  EXPECT_THAT(problem("7scenes"), HasSubstr("holds no frame-NNNNNN.depth.png"));
  EXPECT_THAT(problem("redwood"), HasSubstr("/depth: cannot be listed as a folder"));
  folder_.write("depth/readme.txt", "");
  EXPECT_THAT(problem("redwood"), HasSubstr("/depth: holds no numbered image"));
  depth("depth/1.png", 0);
  depth("depth/01.png", 0);
  EXPECT_THAT(problem("redwood"), HasSubstr("have the same frame number"));
}

TEST_F(NumberedReplay, ColorOfAnotherRecordingIsAnError) {
  depth("depth/1.png", 0);
  color("image/7.jpg", 0);
  EXPECT_THAT(problem("redwood"), HasSubstr("no colour image belongs to any depth image by number"));
}

TEST_F(NumberedReplay, Sun3dNeedsIntrinsics) {
  depth("depth/1.png", 0);
  folder_.write("camera.txt", "");
  EXPECT_THAT(problem("sun3d"), HasSubstr("no usable intrinsics are known"));
  folder_.write("intrinsics.txt", "50 0 20\n0 51 15\n");
  EXPECT_THAT(problem("sun3d"), HasSubstr("intrinsics.txt:2: expected a 3x3 matrix"));
}

}  // namespace
}  // namespace loopsift
