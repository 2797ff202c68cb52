// SPDX-License-Identifier: MIT
// What a graph or an .info knows about an odometry's motions.
#include "tools/loopsift_tool/odometry_information.hpp"

#include <gmock/gmock.h>

#include "core/posegraph/pose_graph.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;

constexpr int kFrames = 21, kEvery = 5;  // a keyframe every so many frames

double time_of(int frame) { return 2.0 + 0.04 * frame; }

Matrix6d some_information() {
  Matrix6d half = Matrix6d::Identity();
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < r; ++c) half(r, c) = 0.1 * (r - 2 * c);
  return 1e4 * half * half.transpose();
}

class OdometryInformationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    Vector6d step;
    step << 0.02, -0.01, 0.03, 0.01, 0.02, -0.015;
    for (int k = 0; k < kFrames; ++k)
      odometry_.poses.push_back({time_of(k), k == 0 ? Se3() : pose(k - 1) * Se3::exp(step * (1 + 0.1 * k))});
  }
  [[nodiscard]] const Se3& pose(int frame) const {
    return odometry_.poses[static_cast<std::size_t>(frame)].T_world_camera;
  }
  /// A run's graph of keyframes; one edge is missing, as where tracking was lost.
  std::string write_graph(bool timed) {
    PoseGraph graph;
    for (int k = 0; k < kFrames; k += kEvery) {
      const auto time_ns = static_cast<std::int64_t>(1e9 * time_of(k) + 0.5);
      graph.nodes.push_back({FragmentId{}, Se3(), timed ? time_ns : 0});
      graph.T_map_node.push_back(pose(k));
    }
    for (const int n : {0, 1, 3})
      graph.odometry.push_back({n, n + 1, pose(kEvery * n).inverse() * pose(kEvery * (n + 1)),
                                (n + 1.0) * some_information(), LoopId{}});
    EXPECT_TRUE(write_g2o(folder_ / "graph.g2o", graph).ok());
    return folder_ / "graph.g2o";
  }
  static FramePlace place(int frame) { return {frame, time_of(frame)}; }

  test::TemporaryFolder folder_;
  Trajectory odometry_;
};

TEST_F(OdometryInformationTest, MotionsAlongAnEdgeComposeToTheEdge) {
  const auto information = OdometryInformation::read(write_graph(true), odometry_);
  ASSERT_TRUE(information.ok()) << information.error().message;
  Matrix6d sum = Matrix6d::Zero(), one;
  for (int k = kEvery + 1; k <= 2 * kEvery; ++k) {
    ASSERT_TRUE(information->between(place(k - 1), place(k), &one)) << k;
    const Matrix6d A = (pose(2 * kEvery).inverse() * pose(k)).adjoint();
    sum += A * one.inverse() * A.transpose();
  }
  const Matrix6d expected = 2.0 * some_information();
  EXPECT_LT((sum.inverse() - expected).norm(), 1e-6 * expected.norm());
  // A frame in between that could not be read: the motion over it has its share as well.
  ASSERT_TRUE(information->between(place(6), place(8), &one));
  const Matrix6d A = (pose(2 * kEvery).inverse() * pose(8)).adjoint();
  EXPECT_LT((A * one.inverse() * A.transpose() - 0.4 * expected.inverse()).norm(),
            1e-6 * expected.inverse().norm());
}

TEST_F(OdometryInformationTest, SaysNothingWhereNoEdgeSpansTheMotion) {
  const auto information = OdometryInformation::read(write_graph(true), odometry_);
  ASSERT_TRUE(information.ok());
  Matrix6d unused;
  EXPECT_FALSE(information->between({}, place(0), &unused));
  EXPECT_FALSE(information->between(place(12), place(13), &unused)) << "the edge that is missing";
  EXPECT_FALSE(information->between(place(4), place(6), &unused)) << "over a keyframe";
  EXPECT_FALSE(information->between(place(20), place(22), &unused)) << "past the end";
  EXPECT_TRUE(information->between(place(15), place(16), &unused));
  EXPECT_FALSE(OdometryInformation().between(place(0), place(1), &unused));
}

TEST_F(OdometryInformationTest, WithoutTimesVerticesAreFrames) {
  const auto information = OdometryInformation::read(write_graph(false), odometry_);
  ASSERT_TRUE(information.ok()) << information.error().message;
  Matrix6d one;
  ASSERT_TRUE(information->between(place(1), place(2), &one));
  EXPECT_LT((one - 2.0 * some_information()).norm(), 1e-6 * one.norm());
  EXPECT_FALSE(information->between(place(0), place(2), &one));
}

TEST_F(OdometryInformationTest, WhatDoesNotFitIsNamed) {
  Trajectory numbered = odometry_;
  numbered.indexed = true;
  const auto error = [&](const std::string& path, const Trajectory& trajectory) {
    const auto read = OdometryInformation::read(path, trajectory);
    return read.ok() ? std::string() : read.error().message;
  };
  EXPECT_THAT(error(write_graph(true), numbered), HasSubstr("give a trajectory with times"));
  EXPECT_THAT(error(folder_ / "no.g2o", odometry_), HasSubstr("no.g2o"));
  const std::string zeros = "0 0 0 0 0 0\n0 0 0 0 0 0\n0 0 0 0 0 0\n0 0 0 0 0 0\n0 0 0 0 0 0\n0 0 0 0 0 0\n";
  EXPECT_THAT(error(folder_.write("far.info", "3 5 21\n" + zeros), odometry_),
              HasSubstr("far.info: record 3 5 joins no two frames in a row"));
  EXPECT_THAT(error(folder_.write("zero.info", "3 4 21\n" + zeros), odometry_),
              HasSubstr("zero.info: record 3 4: the 6x6 matrix is not positive definite"));
}

}  // namespace
}  // namespace loopsift::tool
