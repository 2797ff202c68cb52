// SPDX-License-Identifier: MIT
// Spoiled recordings and trajectories: one clear message and the documented exit code, or the frame is
// skipped and counted. Command lines and settings: exit_codes_test.sh.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift {
namespace {

using test::Outcome;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kFrames = 8;

class BadInput : public ::testing::Test {
 protected:
  void SetUp() override {
    const Outcome made = test::run_program(
        {LOOPSIFT_TOOL, "synth", "room?width=160&height=120&frames=8", "--out", path("sequence")});
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() + "/" + name; }
  [[nodiscard]] std::string depth(int k) const {
    return path("sequence/depth/00000" + std::to_string(k) + ".png");
  }
  Outcome run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command = {LOOPSIFT_PROGRAM,
                                        "--source",
                                        "replay:tum:" + path("sequence"),
                                        "--rate",
                                        "max",
                                        "--out",
                                        path("out"),
                                        "--set",
                                        "lcm.enabled=false",
                                        "--set",
                                        "memory.cap_mib=100000"};
    command.insert(command.end(), more.begin(), more.end());
    return test::run_program(command);
  }
  /// The run goes on without one frame, which is named and counted.
  void expect_skipped(int frame, const std::string& why) const {
    const Outcome ran = run();
    EXPECT_EQ(ran.exit_code, 0) << ran.output;
    EXPECT_THAT(ran.output, AllOf(HasSubstr("skipped"), HasSubstr(depth(frame)), HasSubstr(why)));
    const auto figures = nlohmann::json::parse(test::read_file(path("out/run.json")));
    EXPECT_EQ(figures["frames"]["received"], kFrames);
    EXPECT_EQ(figures["frames"]["dropped"], 1);
    EXPECT_EQ(figures["frames"]["tracked"], kFrames - 1);
  }
  void expect_refused(int exit_code, const std::vector<std::string>& words,
                      const std::vector<std::string>& more = {}) const {
    const Outcome ran = run(more);
    EXPECT_EQ(ran.exit_code, exit_code) << ran.output;
    for (const std::string& word : words) EXPECT_THAT(ran.output, HasSubstr(word));
  }

  test::TemporaryFolder folder_;
};

TEST_F(BadInput, ATruncatedImageIsSkippedAndCounted) {
  test::truncate_file(depth(3), 0.5);
  expect_skipped(3, "");
}

TEST_F(BadInput, AnImageOfAnotherSizeIsSkippedAndCounted) {
  test::write_depth(depth(5), test::make_depth(80, 60, 1));
  expect_skipped(5, "size");
}

TEST_F(BadInput, AMissingImageIsSkippedAndCounted) {
  std::filesystem::remove(depth(0));
  expect_skipped(0, "");
}

TEST_F(BadInput, ImagesThatTheCameraIsNotKnownFor) {
  folder_.write("sequence/camera.txt", "fx 525\nfy 525\ncx 319.5\ncy 239.5\nwidth 640\nheight 480\n");
  expect_refused(3, {depth(0), "160x120", "640x480", "camera.txt"});
}

TEST_F(BadInput, ADepthScaleOfZero) {
  folder_.write("sequence/camera.txt",
                "fx 131\nfy 131\ncx 79.5\ncy 59.5\nwidth 160\nheight 120\ndepth_scale 0\n");
  expect_refused(3, {path("sequence/camera.txt:7"), "depth_scale must be greater than zero"});
}

TEST_F(BadInput, NoMatchingTimeStamps) {
  std::filesystem::remove(path("sequence/associations.txt"));
  folder_.write("sequence/rgb.txt", "500.0 rgb/000000.jpg\n");
  expect_refused(3, {"sequence", "rgb.txt", "depth.txt"});
}

TEST_F(BadInput, ATrajectoryWithoutNumber) {
  const std::string file = folder_.write("odometry.txt", "0.0 0 0 0 0 0 0 1\n0.1 nan 0 0 0 0 0 1\n");
  expect_refused(3, {file + ":2"}, {"--odometry", "file:" + file});
}

TEST_F(BadInput, ATrajectoryOutOfOrder) {
  const std::string file =
      folder_.write("odometry.txt", "0.0 0 0 0 0 0 0 1\n0.2 0 0 0 0 0 0 1\n0.1 0 0 0 0 0 0 1\n");
  expect_refused(3, {file + ":3", "sort"}, {"--odometry", "file:" + file});
}

TEST_F(BadInput, ATrajectoryOfAnotherTimeTracksNothingButEndsCleanly) {
  const std::string file = folder_.write("odometry.txt", "900.0 0 0 0 0 0 0 1\n900.1 0 0 0 0 0 0 1\n");
  const Outcome ran = run({"--odometry", "file:" + file});
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  const auto figures = nlohmann::json::parse(test::read_file(path("out/run.json")));
  EXPECT_EQ(figures["frames"]["lost"], kFrames);
  EXPECT_EQ(figures["frames"]["tracked"], 0);
}

}  // namespace
}  // namespace loopsift
