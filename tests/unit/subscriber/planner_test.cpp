// SPDX-License-Identifier: MIT
// The example planner drives a simulated robot whose odometry drifts and is corrected in large steps.
#include "subscriber/examples/planner.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace loopsift::example {
namespace {

using client::Transform;
using client::Vector3;

constexpr double kDt_s = 1.0 / 30;
constexpr double kPi = 3.14159265358979323846;

Transform planar(double x, double y, double yaw) {
  return {{x, y, 0}, {std::cos(yaw / 2), 0, 0, std::sin(yaw / 2)}};
}

/// True motion in map; the odometry turns a little with every metre; corrections bring T_map_odom up to date.
class Robot {
 public:
  void drive(const Velocity& command) {
    const double turn = command.yaw_rad_s * kDt_s, way = command.forward_m_s * kDt_s;
    T_map_body_ = T_map_body_ * planar(way, 0, turn);
    T_odom_body_ = T_odom_body_ * planar(1.03 * way, 0, turn + 0.08 * way);
  }
  void correct() { T_map_odom_ = T_map_body_ * T_odom_body_.inverse(); }
  [[nodiscard]] const Transform& T_map_body() const { return T_map_body_; }
  [[nodiscard]] const Transform& T_odom_body() const { return T_odom_body_; }
  [[nodiscard]] const Transform& T_map_odom() const { return T_map_odom_; }

 private:
  Transform T_map_body_, T_odom_body_, T_map_odom_;
};

struct Drive {
  double worst_yaw_step = 0;      // rad/s from one command to the next, after the first second
  double worst_forward_step = 0;  // m/s
  double distance_m = 0;          // true, to the goal, at the end
  double correction_m = 0;        // the largest jump of the corrected position
};

constexpr Vector3 kGoal = {12, 3, 0};

Drive simulate(const std::function<Velocity(const Robot&)>& plan) {
  Robot robot;
  Drive drive;
  Velocity last;
  for (int tick = 0; tick < 60 * 30; ++tick) {
    if (tick % (6 * 30) == 0) {
      const Vector3 before = (robot.T_map_odom() * robot.T_odom_body()).trans;
      robot.correct();
      const Vector3 after = (robot.T_map_odom() * robot.T_odom_body()).trans;
      drive.correction_m =
          std::max(drive.correction_m, std::hypot(after[0] - before[0], after[1] - before[1]));
    }
    const Velocity command = plan(robot);
    if (tick > 30) {
      drive.worst_yaw_step = std::max(drive.worst_yaw_step, std::abs(command.yaw_rad_s - last.yaw_rad_s));
      drive.worst_forward_step =
          std::max(drive.worst_forward_step, std::abs(command.forward_m_s - last.forward_m_s));
    }
    last = command;
    robot.drive(command);
  }
  const Vector3& end = robot.T_map_body().trans;
  drive.distance_m = std::hypot(end[0] - kGoal[0], end[1] - kGoal[1]);
  return drive;
}

TEST(Planner, AbsorbsCorrectionsWithoutAJumpAndArrives) {
  Planner planner;
  planner.set_goal(kGoal);
  const Drive smooth = simulate([&planner](const Robot& robot) {
    return planner.update(robot.T_odom_body(), robot.T_map_odom(), kDt_s);
  });
  // The same control law on the corrected pose: what planners complain about.
  const PlannerOptions options;
  const Drive jumping = simulate([&options](const Robot& robot) {
    Planner fresh(options);
    fresh.set_goal(kGoal);
    return fresh.update(robot.T_map_odom() * robot.T_odom_body(), Transform{}, kDt_s);
  });
  EXPECT_GT(smooth.correction_m, 0.15) << "the corrections are worth the name";
  EXPECT_GT(jumping.worst_yaw_step, 0.1) << "and would be felt";
  EXPECT_LT(smooth.worst_yaw_step, 0.03);
  EXPECT_LT(smooth.worst_forward_step, 0.06);  // the last, at arrival
  EXPECT_LT(smooth.distance_m, 0.1);
}

TEST(Planner, TurnsBeforeItDrivesAndStopsOnArrival) {
  Planner planner;
  planner.set_goal({-2, 0.1, 0});
  const Velocity behind = planner.update({}, {}, kDt_s);
  EXPECT_EQ(behind.forward_m_s, 0);
  EXPECT_GT(behind.yaw_rad_s, 0.5);
  const Velocity there = planner.update(planar(-2, 0.08, 0), {}, kDt_s);
  EXPECT_EQ(there.forward_m_s, 0);
  EXPECT_EQ(there.yaw_rad_s, 0);
}

TEST(Planner, ANewGoalIsTakenAtOnce) {
  Planner planner;
  planner.set_goal({1, 0, 0});
  (void)planner.update({}, {}, kDt_s);
  planner.set_goal({0, 5, 0});
  (void)planner.update({}, planar(0, 0, kPi / 2), kDt_s);
  EXPECT_NEAR(planner.p_odom_goal()[0], 5, 1e-9);
}

}  // namespace
}  // namespace loopsift::example
