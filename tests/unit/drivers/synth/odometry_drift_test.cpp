// SPDX-License-Identifier: MIT
#include "drivers/synth/odometry_drift.hpp"

#include <gtest/gtest.h>

#include "drivers/synth/synth_sequence.hpp"

namespace loopsift {
namespace {

Trajectory truth() {
  auto sequence = make_synth_sequence("room", {});
  return sequence.ok() ? std::move(sequence->trajectory) : Trajectory();
}

double distance(const Trajectory& a, const Trajectory& b, std::size_t k) {
  return (a.poses[k].T_world_camera.translation() - b.poses[k].T_world_camera.translation()).norm();
}

TEST(OdometryDrift, EndsAsFarOffAsAsked) {
  const Trajectory gt = truth();
  ASSERT_GT(gt.poses.size(), 100U);
  for (const double metres : {0.05, 0.3, 1.0})
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const Trajectory odometry = drifting_odometry(gt, metres, seed);
      ASSERT_EQ(odometry.poses.size(), gt.poses.size());
      EXPECT_NEAR(distance(odometry, gt, gt.poses.size() - 1), metres, 1e-4);
      EXPECT_EQ(distance(odometry, gt, 0), 0.0);
    }
}

TEST(OdometryDrift, SeedsDifferAndRepeat) {
  const Trajectory gt = truth();
  const Trajectory first = drifting_odometry(gt, 0.3, 1), second = drifting_odometry(gt, 0.3, 2);
  EXPECT_GT(distance(first, second, gt.poses.size() / 2), 0.01);
  EXPECT_EQ(distance(first, drifting_odometry(gt, 0.3, 1), gt.poses.size() / 2), 0.0);
}

TEST(OdometryDrift, MovesSmoothly) {
  const Trajectory gt = truth(), odometry = drifting_odometry(gt, 0.3, 4);
  for (std::size_t k = 1; k < gt.poses.size(); ++k) {
    const Se3 true_motion = gt.poses[k - 1].T_world_camera.inverse() * gt.poses[k].T_world_camera;
    const Se3 motion = odometry.poses[k - 1].T_world_camera.inverse() * odometry.poses[k].T_world_camera;
    const Vector6d error = (true_motion.inverse() * motion).log();
    ASSERT_LT(error.head<3>().norm(), 0.02) << k;
    ASSERT_LT(error.tail<3>().norm(), 0.01) << k;
  }
}

}  // namespace
}  // namespace loopsift
