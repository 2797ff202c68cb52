// SPDX-License-Identifier: MIT
// `loopsift-tool view` as a user calls it, and the figures that it shows.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "drivers/replay/image_file.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/frame_statistics.hpp"

namespace loopsift::tool {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::int64_t kMs = 1000000;

SourceInfo small_info() {
  SourceInfo info;
  info.camera = {4, 1, 5.0F, 5.0F, 1.5F, 0.0F};
  info.color_width = info.color_height = 1;
  return info;
}

class FrameStatisticsTest : public ::testing::Test {
 protected:
  void add(std::int64_t stamp_ms, std::int64_t sequence, std::vector<std::uint16_t> depth,
           bool color = true) {
    RawFrame frame;
    frame.timestamp_ns = stamp_ms * kMs;
    frame.sequence = sequence;
    frame.depth = {depth.data(), 4, 1};
    Rgb8 pixel{10, 20, 30};
    if (color) frame.color = {&pixel, 1, 1};
    statistics_.add(frame, stamp_ms * 2 * kMs);
  }
  FrameStatistics statistics_{small_info()};
};

TEST_F(FrameStatisticsTest, DepthAndColor) {
  add(0, 0, {0, 1000, 2000, 65535});
  add(33, 1, {1000, 2000, 2000, 3000}, false);
  const FrameFigures figures = statistics_.take();
  EXPECT_EQ(figures.frames, 2);
  EXPECT_EQ(figures.valid_share, 0.75);
  EXPECT_DOUBLE_EQ(figures.near_m, 1.0);
  EXPECT_DOUBLE_EQ(figures.median_m, 2.0);
  EXPECT_DOUBLE_EQ(figures.far_m, 3.0);
  EXPECT_EQ(figures.brightness, 20);
  EXPECT_EQ(figures.without_color, 1);
}

TEST_F(FrameStatisticsTest, RatesGapsAndFaultsAcrossTakes) {
  add(0, 0, {0, 0, 0, 0});
  add(33, 1, {0, 0, 0, 0});
  (void)statistics_.take();
  add(66, 2, {0, 0, 0, 0});
  add(132, 5, {0, 0, 0, 0});
  add(132, 6, {0, 0, 0, 0});
  const FrameFigures figures = statistics_.take();
  EXPECT_EQ(figures.missed, 2);
  EXPECT_EQ(figures.stamp_gaps, 1);
  EXPECT_EQ(figures.stamp_faults, 1);
  EXPECT_NEAR(figures.stamp_rate_hz, 3 / 0.099, 1e-9);
  EXPECT_NEAR(figures.rate_hz, 3 / 0.198, 1e-9);
  EXPECT_EQ(figures.valid_share, 0);
  EXPECT_EQ(figures.median_m, 0);
}

int run(const std::vector<std::string>& arguments, std::string* out, std::string* complaint) {
  std::vector<const char*> argv = {"loopsift-tool", "view"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int exit_code = run_tool(static_cast<int>(argv.size()), argv.data());
  *out = testing::internal::GetCapturedStdout();
  *complaint = testing::internal::GetCapturedStderr();
  return exit_code;
}

class ViewCommand : public ::testing::Test {
 protected:
  test::TemporaryFolder folder_;
  std::string out_, complaint_;
};

TEST_F(ViewCommand, ShowsARecordingAndWritesAPictureAndFigures) {
  ASSERT_EQ(run({"--source", "synth:room?frames=4&width=64&height=48", "--frames", "3", "--png",
                 folder_ / "view.png", "--json", folder_ / "view.json"},
                &out_, &complaint_),
            0)
      << complaint_;
  EXPECT_THAT(out_, AllOf(HasSubstr("depth 64x48"), HasSubstr("colour 64x48"), HasSubstr("in all:")));
  std::ifstream file(folder_ / "view.json");
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["frames"], 3);
  EXPECT_GT(json["valid_share"], 0.5);
  EXPECT_GT(json["median_m"], 0.3);
  EXPECT_EQ(json["stamp_faults"], 0);
  EXPECT_NEAR(json["stamp_rate_hz"], 30, 0.5);
  const auto size = read_image_size(folder_ / "view.png");
  ASSERT_TRUE(size.ok());
  EXPECT_EQ(size->width, 128);
  EXPECT_EQ(size->height, 48);
}

TEST_F(ViewCommand, SettingsReachTheSource) {
  folder_.write("camera.toml", "[depth]\nmirrored = true\n");
  ASSERT_EQ(run({"--source", "synth:room?frames=2&width=64&height=48", "--set",
                 "camera.file=" + (folder_ / "camera.toml"), "--set", "camera.fx=77"},
                &out_, &complaint_),
            0)
      << complaint_;
  EXPECT_THAT(out_, HasSubstr("fx 77.0"));
  EXPECT_EQ(run({"--source", "synth:room", "--set", "camera.file=/none"}, &out_, &complaint_), 2);
  EXPECT_THAT(complaint_, HasSubstr("/none"));
}

TEST_F(ViewCommand, SaysWhatCannotBeShown) {
  EXPECT_EQ(run({}, &out_, &complaint_), 2);
  EXPECT_THAT(complaint_, HasSubstr("--source URI"));
  EXPECT_EQ(run({"--source", "replay:tum:/no/such"}, &out_, &complaint_), 3);
  EXPECT_EQ(run({"--source", "synth:room", "--set", "camera.wide=1"}, &out_, &complaint_), 2);
  folder_.write("seq/depth.txt", "1.0 depth/0.png\n2.0 depth/1.png\n");
  test::write_depth(folder_ / "seq/depth/0.png", test::make_depth(32, 24, 0));
  test::truncate_file(folder_ / "seq/depth/0.png", 0.5);
  folder_.write("seq/camera.txt", "width 32\nheight 24\n");
  EXPECT_EQ(run({"--source", "replay:tum:" + (folder_ / "seq")}, &out_, &complaint_), 1);
  EXPECT_THAT(complaint_, AllOf(HasSubstr("gave no usable frame"), HasSubstr("1.png")));
}

}  // namespace
}  // namespace loopsift::tool
