// SPDX-License-Identifier: MIT
#include "core/odometry/trajectory_odometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

namespace loopsift {
namespace {

Trajectory straight(int poses, bool indexed) {
  Trajectory trajectory;
  trajectory.indexed = indexed;
  for (int i = 0; i < poses; ++i)
    trajectory.poses.push_back(
        {indexed ? i : 0.1 * i, Se3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.05 * i, 0, 0))});
  return trajectory;
}

TEST(TrajectoryOdometry, FollowsFrameNumbers) {
  TrajectoryOdometry odometry(straight(3, true), {});
  EXPECT_EQ(odometry.track(FrameId{0}, 0).status, TrackingStatus::kFirst);
  const TrackingResult second = odometry.track(FrameId{1}, 0);
  EXPECT_EQ(second.status, TrackingStatus::kTracked);
  EXPECT_DOUBLE_EQ(second.T_odom_camera.translation().x(), 0.05);
  EXPECT_GT(second.information(0, 0), 0.0);
  (void)odometry.track(FrameId{2}, 0);
  const TrackingResult past = odometry.track(FrameId{3}, 0);
  EXPECT_EQ(past.status, TrackingStatus::kLost);
  EXPECT_EQ(past.reason, LostReason::kNoPose);
  EXPECT_DOUBLE_EQ(past.T_odom_camera.translation().x(), 0.10) << "the last known pose";
}

TEST(TrajectoryOdometry, InterpolatesTimesAndNeverAcrossGaps) {
  Trajectory trajectory = straight(3, false);
  trajectory.poses.push_back({5.0, Se3()});
  TrajectoryOdometryOptions options;
  options.max_gap_s = 0.15;
  TrajectoryOdometry odometry(trajectory, options);
  EXPECT_EQ(odometry.track(FrameId{0}, 0).status, TrackingStatus::kFirst);
  EXPECT_NEAR(odometry.track(FrameId{1}, 150000000).T_odom_camera.translation().x(), 0.075, 1e-9);
  EXPECT_EQ(odometry.track(FrameId{2}, 3000000000).status, TrackingStatus::kLost);
  EXPECT_EQ(odometry.track(FrameId{3}, 5000000000).status, TrackingStatus::kFirst) << "a new piece";
}

TEST(TrajectoryOdometry, LongerMotionsAreLessCertain) {
  TrajectoryOdometry slow(straight(2, true), {});
  Trajectory far = straight(2, true);
  far.poses[1].T_world_camera = Se3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(1, 0, 0));
  TrajectoryOdometry fast(far, {});
  (void)slow.track(FrameId{0}, 0);
  (void)fast.track(FrameId{0}, 0);
  EXPECT_GT(slow.track(FrameId{1}, 0).information(0, 0), 10 * fast.track(FrameId{1}, 0).information(0, 0));
}

TEST(TrajectoryOdometry, ErrorsNameTheFile) {
  const auto missing = TrajectoryOdometry::open("/nonexistent/poses.txt", {});
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(missing.error().message, testing::HasSubstr("/nonexistent/poses.txt"));
}

}  // namespace
}  // namespace loopsift
