// SPDX-License-Identifier: MIT
#include "tools/evaluation/trajectory_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace loopsift {
namespace {

using testing::HasSubstr;

/// A helix of `count` poses at 10 Hz.
Trajectory helix(int count, double start_s = 0) {
  Trajectory trajectory;
  for (int k = 0; k < count; ++k) {
    const double a = 0.1 * k;
    Vector6d xi;
    xi << std::cos(a), std::sin(a), 0.05 * a, 0.1, a, 0.3;
    trajectory.poses.push_back({start_s + 0.1 * k, Se3::exp(xi)});
  }
  return trajectory;
}

Se3 some_motion() {
  Vector6d xi;
  xi << 3, -2, 1, 0.4, 1.1, -0.7;
  return Se3::exp(xi);
}

Trajectory moved(const Trajectory& trajectory, const Se3& T_new_old) {
  Trajectory result = trajectory;
  for (StampedPose& pose : result.poses) pose.T_world_camera = T_new_old * pose.T_world_camera;
  return result;
}

std::vector<PosePair> pairs_of(const Trajectory& gt, const Trajectory& est) {
  const auto pairs = associate(gt, est, {});
  EXPECT_TRUE(pairs.ok()) << pairs.error().message;
  return pairs.ok() ? *pairs : std::vector<PosePair>{};
}

std::string error_of(const Trajectory& gt, const Trajectory& est, const AssociationOptions& options) {
  const auto pairs = associate(gt, est, options);
  if (pairs.ok()) return "";
  EXPECT_EQ(pairs.error().code, ErrorCode::kUsage);
  return pairs.error().message;
}

TEST(TrajectoryError, AnotherWorldFrameIsNoError) {
  const Trajectory gt = helix(40);
  const TrajectoryError error = trajectory_error(pairs_of(gt, moved(gt, some_motion())));
  EXPECT_EQ(error.pairs, 40);
  EXPECT_NEAR(error.ate_rmse_m, 0, 1e-12);
  EXPECT_NEAR(error.ate_max_m, 0, 1e-12);
  EXPECT_NEAR(error.rpe_trans_rmse_m.value(), 0, 1e-12);
  EXPECT_NEAR(error.rpe_rot_rmse_deg.value(), 0, 1e-6);
}

TEST(TrajectoryError, AlignmentFindsTheMotionBetweenTheWorlds) {
  const Trajectory gt = helix(40);
  const Se3 T_gt_est = align(pairs_of(gt, moved(gt, some_motion().inverse())));
  EXPECT_NEAR((T_gt_est.inverse() * some_motion()).log().norm(), 0, 1e-9);
}

TEST(TrajectoryError, AlignmentNeverMirrorsPositionsInAPlane) {
  Trajectory gt = helix(40);
  for (StampedPose& pose : gt.poses) {
    Eigen::Vector3d t = pose.T_world_camera.translation();
    t.z() = 0;
    pose.T_world_camera = Se3(pose.T_world_camera.rotation(), t);
  }
  const Se3 T_gt_est = align(pairs_of(gt, moved(gt, some_motion())));
  EXPECT_NEAR(T_gt_est.rotation().determinant(), 1, 1e-9);
}

TEST(TrajectoryError, ScaleIsNotAlignedAway) {
  // Positions ±1 m along x and y against ±1.1 m: every one is 0.1 m off, whatever rotation and translation
  // do.
  Trajectory gt, est;
  const double xs[] = {1, 0, -1, 0}, ys[] = {0, 1, 0, -1};
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d t(xs[k], ys[k], 0);
    gt.poses.push_back({0.1 * k, Se3(Eigen::Matrix3d::Identity(), t)});
    est.poses.push_back({0.1 * k, Se3(Eigen::Matrix3d::Identity(), 1.1 * t)});
  }
  const TrajectoryError error = trajectory_error(pairs_of(gt, est));
  EXPECT_NEAR(error.ate_rmse_m, 0.1, 1e-12);
  EXPECT_NEAR(error.ate_mean_m, 0.1, 1e-12);
  EXPECT_NEAR(error.ate_max_m, 0.1, 1e-12);
  EXPECT_FALSE(error.rpe_trans_rmse_m.has_value()) << "the trajectory lasts less than a second";
}

TEST(TrajectoryError, RelativeErrorIsOfTheMotionWithinASecond) {
  // Straight ahead at 1 m/s; the estimate is 3 % too fast and turns 2° per second.
  Trajectory gt, est;
  for (int k = 0; k <= 30; ++k) {
    const double t = 0.1 * k;
    const Eigen::AngleAxisd turn(2.0 * t * EIGEN_PI / 180.0, Eigen::Vector3d::UnitZ());
    gt.poses.push_back({t, Se3(Eigen::Matrix3d::Identity(), {0, 0, t})});
    est.poses.push_back({t, Se3(turn.toRotationMatrix(), {0, 0, 1.03 * t})});
  }
  const TrajectoryError error = trajectory_error(pairs_of(gt, est));
  // Each second is the first pair at least a second later; rounding of time stamps may make that 1.1 s.
  EXPECT_NEAR(error.rpe_trans_rmse_m.value(), 0.03, 0.0031);
  EXPECT_NEAR(error.rpe_rot_rmse_deg.value(), 2.0, 0.21);
}

TEST(Association, TakesTheNearestWithinTwentyMilliseconds) {
  const Trajectory gt = helix(20);
  Trajectory est = helix(20, 0.015);
  EXPECT_EQ(pairs_of(gt, est).size(), 20U);
  est.poses[7].time_s += 0.02;  // 35 ms from its frame
  EXPECT_EQ(pairs_of(gt, est).size(), 19U);
}

TEST(Association, FrameNumbersOfALogArePairedByNumber) {
  Trajectory gt = helix(20), est = helix(20);
  for (int k = 0; k < 20; ++k) gt.poses[static_cast<std::size_t>(k)].time_s = k;
  for (int k = 0; k < 20; ++k) est.poses[static_cast<std::size_t>(k)].time_s = k + 5;
  gt.indexed = est.indexed = true;
  const auto pairs = pairs_of(gt, est);
  ASSERT_EQ(pairs.size(), 15U);
  EXPECT_NEAR((pairs[0].T_gt_camera.inverse() * gt.poses[5].T_world_camera).log().norm(), 0, 1e-12);
  EXPECT_NEAR(pairs[1].time_s - pairs[0].time_s, 1.0 / 30, 1e-12);
}

TEST(Association, NothingInCommonIsSaidWithBothTimeRanges) {
  const std::string message = error_of(helix(20), helix(20, 1000), {});
  EXPECT_THAT(message, HasSubstr("no time in common"));
  EXPECT_THAT(message, HasSubstr("1000.0"));
  EXPECT_THAT(error_of({}, helix(20), {}), HasSubstr("ground truth holds nothing"));
  EXPECT_THAT(error_of(helix(20), {}, {}), HasSubstr("the estimate nothing"));
}

TEST(Association, FewerThanThreePairsIsAnError) {
  EXPECT_THAT(error_of(helix(20), helix(2), {}), HasSubstr("only 2 poses in common"));
}

TEST(Association, SecondsAndFrameNumbersDoNotMixUnlessAskedTo) {
  const Trajectory gt = helix(20);
  Trajectory est = helix(20);
  est.indexed = true;
  EXPECT_THAT(error_of(gt, est, {}), HasSubstr("by frame number and the other by seconds"));
  AssociationOptions by_index;
  by_index.by_index = true;
  EXPECT_TRUE(associate(gt, est, by_index).ok());
  est.poses.pop_back();
  EXPECT_THAT(error_of(gt, est, by_index), HasSubstr("20 and 19 poses"));
}

}  // namespace
}  // namespace loopsift
