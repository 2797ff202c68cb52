// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "drivers/replay/recording.hpp"
#include "drivers/replay/replay_source.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::FrameBuffers;
using test::TemporaryFolder;
using ::testing::HasSubstr;

constexpr int kWidth = 40, kHeight = 30;
constexpr const char* kCamera = "fx 50\nfy 50\ncx 19.5\ncy 14.5\nwidth 40\nheight 30\ndepth_scale 5000\n";

class TumReplay : public ::testing::Test {
 protected:
  TumReplay() {
    folder_.write("camera.txt", kCamera);
    for (int k = 0; k < 3; ++k) {
      test::write_depth(folder_ / depth(k), test::make_depth(kWidth, kHeight, k));
      test::write_color_png(folder_ / color(k), test::make_color(kWidth, kHeight, k));
    }
  }
  static std::string depth(int k) { return "depth/" + std::to_string(k) + ".png"; }
  static std::string color(int k) { return "rgb/" + std::to_string(k) + ".png"; }
  Expected<std::unique_ptr<FrameSource>> open(const SourceOptions& options = {}) {
    return open_replay("tum", folder_.path(), options);
  }
  std::string problem() {
    const auto source = open();
    return source.ok() ? "accepted" : source.error().message;
  }
  void expect_three_frames(bool with_color) {
    auto source = open();
    ASSERT_TRUE(source.ok()) << source.error().message;
    FrameBuffers buffers((*source)->info());
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame) << (*source)->message();
      EXPECT_EQ(buffers.frame.sequence, k);
      EXPECT_EQ(buffers.frame.timestamp_ns, 10'000'000'000 + k * 33'000'000);
      EXPECT_TRUE(test::equal(buffers.frame.depth, test::make_depth(kWidth, kHeight, k).view()));
      EXPECT_EQ(buffers.frame.color.empty(), !with_color);
      if (with_color) {
        EXPECT_EQ(test::largest_difference(buffers.frame.color, test::make_color(kWidth, kHeight, k).view()),
                  0);
      }
    }
    EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kEnd);
    EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kEnd);
  }

  TemporaryFolder folder_;
};

TEST_F(TumReplay, AssociationsWithDepthFirst) {
  folder_.write("associations.txt",
                "10.000 depth/0.png 10.001 rgb/0.png\n10.033 depth/1.png 10.03 rgb/1.png\n10.066 depth/2.png "
                "10.06 rgb/2.png\n");
  expect_three_frames(true);
}

TEST_F(TumReplay, AssociationsWithColorFirstAreTimedByTheDepth) {
  folder_.write("associations.txt",
                "10.001 rgb/0.png 10.000 depth/0.png\n10.03 rgb/1.png 10.033 depth/1.png\n10.06 rgb/2.png "
                "10.066 depth/2.png\n");
  expect_three_frames(true);
}

TEST_F(TumReplay, AssociationsWithDepthAlone) {
  folder_.write("associations.txt", "10.000 depth/0.png\n10.033 depth/1.png\n10.066 depth/2.png\n");
  expect_three_frames(false);
}

TEST_F(TumReplay, ListsArePairedByTime) {
  folder_.write("depth.txt", "# depth\n10.000 depth/0.png\n10.033 depth/1.png\n10.066 depth/2.png\n");
  folder_.write("rgb.txt", "# rgb\n9.99 rgb/0.png\n10.04 rgb/1.png\n10.07 rgb/2.png\n");
  expect_three_frames(true);
}

TEST_F(TumReplay, DepthListAloneIsEnough) {
  folder_.write("depth.txt", "10.000 depth/0.png\n10.033 depth/1.png\n10.066 depth/2.png\n");
  expect_three_frames(false);
}

TEST_F(TumReplay, ADepthImageWithoutColorNearItComesAlone) {
  folder_.write("depth.txt", "10.000 depth/0.png\n10.033 depth/1.png\n");
  folder_.write("rgb.txt", "10.035 rgb/1.png\n");
  auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  FrameBuffers buffers((*source)->info());
  ASSERT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_TRUE(buffers.frame.color.empty());
  EXPECT_EQ((*source)->message(), "");
  ASSERT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_FALSE(buffers.frame.color.empty());
}

TEST_F(TumReplay, InfoTellsCameraUnitAndCount) {
  folder_.write("associations.txt", "10.000 depth/0.png 10.001 rgb/0.png\n");
  auto source = open();
  ASSERT_TRUE(source.ok());
  const SourceInfo& info = (*source)->info();
  EXPECT_EQ(info.camera.width, kWidth);
  EXPECT_EQ(info.camera.fx, 50);
  EXPECT_DOUBLE_EQ(info.depth_unit_m, 1.0 / 5000);
  EXPECT_EQ(info.color_width, kWidth);
  EXPECT_EQ(info.frame_count, 1);
  EXPECT_FALSE(info.live);
  EXPECT_THAT(info.description, HasSubstr("1 frames"));
}

TEST_F(TumReplay, UnwantedColorIsNeitherReadNorAnnounced) {
  folder_.write("associations.txt", "10.000 depth/0.png 10.001 rgb/none.png\n");
  SourceOptions options;
  options.want_color = false;
  auto source = open(options);
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->info().color_width, 0);
  FrameBuffers buffers((*source)->info());
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ((*source)->message(), "");
}

TEST_F(TumReplay, ABadFrameIsNamedAndTheNextOneComes) {
  folder_.write("associations.txt",
                "10.000 depth/0.png\n10.033 depth/1.png\n10.05 depth/none.png\n10.066 depth/2.png\n");
  test::truncate_file(folder_ / depth(1), 0.5);
  auto source = open();
  ASSERT_TRUE(source.ok());
  FrameBuffers buffers((*source)->info());
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_EQ((*source)->message(), folder_ / depth(1) + ": the file is truncated");
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_EQ((*source)->message(), folder_ / "depth/none.png" + ": the file does not exist");
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_TRUE(test::equal(buffers.frame.depth, test::make_depth(kWidth, kHeight, 2).view()));
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kEnd);
}

TEST_F(TumReplay, AFrameOfAnotherSizeIsBad) {
  folder_.write("associations.txt", "10.000 depth/0.png\n10.033 depth/1.png\n");
  test::write_depth(folder_ / depth(1), test::make_depth(20, 30, 0));
  auto source = open();
  ASSERT_TRUE(source.ok());
  FrameBuffers buffers((*source)->info());
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_THAT((*source)->message(), HasSubstr("1.png: the image has another size than the camera"));
}

TEST_F(TumReplay, BrokenColorLeavesTheDepthAndAMessage) {
  folder_.write("associations.txt", "10.000 depth/0.png 10.0 rgb/0.png\n10.033 depth/1.png 10.0 rgb/1.png\n");
  test::truncate_file(folder_ / color(1), 0.5);
  auto source = open();
  ASSERT_TRUE(source.ok());
  FrameBuffers buffers((*source)->info());
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  EXPECT_TRUE(buffers.frame.color.empty());
  EXPECT_TRUE(test::equal(buffers.frame.depth, test::make_depth(kWidth, kHeight, 1).view()));
  EXPECT_THAT((*source)->message(), HasSubstr(color(1)));
}

TEST_F(TumReplay, ABrokenFirstImageDoesNotHideTheSize) {
  folder_.write("associations.txt", "10.000 depth/0.png\n10.033 depth/1.png\n");
  test::truncate_file(folder_ / depth(0), 0.0);
  auto source = open();
  ASSERT_TRUE(source.ok()) << source.error().message;
  FrameBuffers buffers((*source)->info());
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kBad);
  EXPECT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
}

TEST_F(TumReplay, ListsThatDoNotFitAreErrors) {
  EXPECT_THAT(problem(), HasSubstr("holds neither associations.txt nor depth.txt"));
  folder_.write("depth.txt", "10.000 depth/0.png\n10.033 depth/1.png\n");
  folder_.write("rgb.txt", "99.000 rgb/0.png\n99.033 rgb/1.png\n");
  EXPECT_THAT(problem(),
              HasSubstr("no time in rgb.txt lies within half a frame (16 ms) of one in depth.txt"));
  folder_.write("rgb.txt", "soon rgb/0.png\n");
  EXPECT_THAT(problem(), HasSubstr("rgb.txt:1: 'soon' is not a time"));
  folder_.write("depth.txt", "10.033 depth/0.png\n10.0 depth/1.png\n");
  EXPECT_THAT(problem(), HasSubstr("depth.txt:2: time does not go forward"));
  folder_.write("associations.txt", "10.0 a.png 10.0 b.png\n");
  EXPECT_THAT(problem(), HasSubstr("associations.txt:1: cannot tell depth from colour"));
  folder_.write("associations.txt", "10.0\n");
  EXPECT_THAT(problem(), HasSubstr("associations.txt:1: expected `time depth`"));
  folder_.write("associations.txt", "# nothing yet\n");
  EXPECT_THAT(problem(), HasSubstr("the list of depth images is empty"));
  folder_.write("associations.txt", "10.0 depth/x.png\n");
  EXPECT_THAT(problem(), HasSubstr("none of its 1 depth images can be read"));
}

TEST_F(TumReplay, FoldersAndScalesThatCannotBe) {
  EXPECT_EQ(open_replay("tum", folder_ / "none", {}).error().code, ErrorCode::kNotFound);
  EXPECT_THAT(open_replay("tum", folder_ / "none", {}).error().message, HasSubstr("none: cannot be listed"));
  EXPECT_THAT(open_replay("tum", "", {}).error().message, HasSubstr("path is missing"));
  EXPECT_THAT(open_replay("euroc", folder_.path(), {}).error().message,
              HasSubstr("unknown format 'euroc'; known are tum"));
  folder_.write("associations.txt", "10.000 depth/0.png\n");
  folder_.write("camera.txt", "depth_scale 0\n");
  EXPECT_THAT(problem(), HasSubstr("camera.txt:1: depth_scale must be greater than zero"));
  std::filesystem::remove(folder_ / "camera.txt");
  EXPECT_THAT(problem(), HasSubstr("0.png is 40x30, but the camera is known for 640x480"));
}

TEST(TumCamera, IsToldByTheFolderName) {
  const TemporaryFolder folder;
  folder.write("rgbd_dataset_freiburg1_desk/depth.txt", "1.0 depth/0.png\n");
  folder.write("mine/depth.txt", "1.0 depth/0.png\n");
  EXPECT_EQ(list_tum(folder / "rgbd_dataset_freiburg1_desk", {})->defaults.camera.fx, 517.3F);
  EXPECT_EQ(list_tum(folder / "mine", {})->defaults.camera.fx, 525.0F);
  EXPECT_EQ(list_tum(folder / "mine", {})->defaults.depth_scale, 5000);
}

TEST(PairNearest, TakesTheNearestWithinTheLimit) {
  EXPECT_EQ(pair_nearest({10, 20, 30, 40}, {11, 19, 22, 47}, 3), (std::vector<int>{0, 1, -1, -1}));
  EXPECT_EQ(pair_nearest({10, 20}, {}, 3), (std::vector<int>{-1, -1}));
  EXPECT_EQ(pair_nearest({10, 20}, {1, 2, 3, 20}, 0), (std::vector<int>{-1, 3}));
}

}  // namespace
}  // namespace loopsift
