// SPDX-License-Identifier: MIT
#include "tools/evaluation/trajectory_formats.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using testing::HasSubstr;

Trajectory turning_walk() {
  Trajectory trajectory;
  for (int k = 0; k < 7; ++k) {
    Vector6d xi;
    xi << 0.2 * k, -0.1 * k, 0.05, 0.3, 0.4 * k, -0.2;
    trajectory.poses.push_back({1403636580.5 + 0.05 * k, Se3::exp(xi)});
  }
  return trajectory;
}

class TrajectoryFormats : public testing::Test {
 protected:
  std::string error_of(const std::string& content, std::optional<TrajectoryFormat> format = {}) const {
    folder_.write("bad.txt", content);
    const auto read = read_any_trajectory(folder_ / "bad.txt", format);
    return read.ok() ? "" : read.error().message;
  }
  test::TemporaryFolder folder_;
};

TEST_F(TrajectoryFormats, EachComesBackAsWrittenAndIsRecognised) {
  const Trajectory walk = turning_walk();
  for (const auto format : {TrajectoryFormat::kTum, TrajectoryFormat::kKitti, TrajectoryFormat::kEuroc,
                            TrajectoryFormat::kRedwood}) {
    const std::string path = folder_ / "walk.txt";
    ASSERT_TRUE(write_any_trajectory(path, walk, format, 20).ok());
    const auto read = read_any_trajectory(path);
    ASSERT_TRUE(read.ok()) << read.error().message;
    const bool timeless = format == TrajectoryFormat::kKitti || format == TrajectoryFormat::kRedwood;
    EXPECT_EQ(read->indexed, timeless);
    ASSERT_EQ(read->poses.size(), walk.poses.size());
    for (std::size_t k = 0; k < walk.poses.size(); ++k) {
      EXPECT_NEAR(read->poses[k].time_s, timeless ? static_cast<double>(k) : walk.poses[k].time_s, 1e-6);
      EXPECT_LT((read->poses[k].T_world_camera.inverse() * walk.poses[k].T_world_camera).log().norm(), 1e-7);
    }
  }
}

TEST_F(TrajectoryFormats, FrameNumbersBecomeSecondsWhereTheFormatWantsThem) {
  Trajectory frames = turning_walk();
  frames.indexed = true;
  for (std::size_t k = 0; k < frames.poses.size(); ++k) frames.poses[k].time_s = static_cast<double>(k);
  ASSERT_TRUE(write_any_trajectory(folder_ / "a.txt", frames, TrajectoryFormat::kTum, 20).ok());
  const auto read = read_any_trajectory(folder_ / "a.txt");
  ASSERT_TRUE(read.ok());
  EXPECT_NEAR(read->poses.back().time_s, 0.3, 1e-9);
}

TEST_F(TrajectoryFormats, EurocWithHeaderMoreColumnsAndFolder) {
  const std::string folder = folder_ / "V1_01/mav0/state_groundtruth_estimate0";
  std::filesystem::create_directories(folder);
  folder_.write(
      "V1_01/mav0/state_groundtruth_estimate0/data.csv",
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], ...\n"
      "1403715273262142976,0.878612,2.142470,0.947262,0.060514,-0.828459,-0.058956,-0.553641,0.1,0.2\n"
      "1403715273267142912, 0.878612, 2.142470, 0.947263, 0.060514, -0.828459, -0.058956, -0.553641\n");
  const auto read = read_any_trajectory(folder_ / "V1_01");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->poses.size(), 2U);
  EXPECT_NEAR(read->poses[0].time_s, 1403715273.262142976, 1e-6);
  EXPECT_NEAR(read->poses[1].T_world_camera.translation().z(), 0.947263, 1e-9);
  EXPECT_NEAR(std::abs(read->poses[0].T_world_camera.quaternion().w()), 0.0605, 1e-3);
}

TEST_F(TrajectoryFormats, WrongLinesAreNamed) {
  EXPECT_THAT(error_of("1 2 3 4 5\n"), HasSubstr("bad.txt:1: is no line of a trajectory"));
  EXPECT_THAT(error_of("1 0 0 0 0 1 0 0 0 0 1 0\n2 0 0 0\n"), HasSubstr("bad.txt:2: a KITTI pose has 12"));
  EXPECT_THAT(error_of("1 0 0 0 0 1 0 0 0 0 nan 0\n"), HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(error_of("5 0 0 0 0 5 0 0 0 0 5 0\n"), HasSubstr("no rigid motion"));
  EXPECT_THAT(error_of("12,0,0,0,1,0,0\n"), HasSubstr("at least 8 values"));
  EXPECT_THAT(error_of("1.5,0,0,0,1,0,0,0\n"), HasSubstr("'1.5' is no time stamp in nanoseconds"));
  EXPECT_THAT(error_of("20,0,0,0,1,0,0,0\n10,0,0,0,1,0,0,0\n"), HasSubstr("bad.txt:2: time goes back"));
  EXPECT_THAT(error_of("20,0,0,0,3,0,0,0\n"), HasSubstr("no rotation"));
  EXPECT_THAT(error_of("# nothing\n"), HasSubstr("holds no pose"));
  EXPECT_THAT(error_of("0 0 0 0 0 0 0 1\n", TrajectoryFormat::kEuroc), HasSubstr("at least 8 values"));
  EXPECT_THAT(read_any_trajectory(folder_.path()).error().message, HasSubstr("without a data.csv"));
  EXPECT_THAT(trajectory_format("bag").error().message, HasSubstr("known are tum, kitti"));
}

}  // namespace
}  // namespace loopsift
