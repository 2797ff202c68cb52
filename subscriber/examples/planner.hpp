// SPDX-License-Identifier: MIT
// How a planner lives with corrections: it steers in odom, where nothing ever jumps, towards a goal that was
// given in map. A correction moves the goal in odom; the planner lets it glide there at a bounded speed, so
// that what it commands stays smooth however large the correction is, and arrives where the goal is now.
#pragma once
#include <algorithm>
#include <cmath>

#include "loopsift/client/transform.hpp"

namespace loopsift::example {

struct Velocity {
  double forward_m_s = 0;
  double yaw_rad_s = 0;
};

struct PlannerOptions {
  double max_forward_m_s = 0.5;
  double max_yaw_rad_s = 0.8;
  double yaw_gain_per_s = 1.5;  ///< of the bearing of the goal
  double arrival_m = 0.05;      ///< nearer than this is there
  double glide_m_s = 0.25;      ///< how fast a correction is absorbed, at most
};

class Planner {
 public:
  explicit Planner(const PlannerOptions& options = {}) : options_(options) {}

  /// A place in map.
  void set_goal(const client::Vector3& p_map_goal) {
    p_map_goal_ = p_map_goal;
    gliding_ = false;
  }

  /// One step of the control loop, dt_s after the one before, with the newest pose and T_map_odom.
  [[nodiscard]] Velocity update(const client::Transform& T_odom_body, const client::Transform& T_map_odom,
                                double dt_s) {
    glide(T_map_odom.inverse() * p_map_goal_, dt_s);
    const client::Vector3 p_body_goal = T_odom_body.inverse() * p_odom_goal_;
    const double distance = std::hypot(p_body_goal[0], p_body_goal[1]);
    if (distance < options_.arrival_m) return {};
    const double bearing = std::atan2(p_body_goal[1], p_body_goal[0]);
    const double slower_near = std::min(1.0, distance);
    // Near the goal its bearing races; turning fades out before that.
    const double yaw =
        std::clamp(options_.yaw_gain_per_s * bearing * std::min(1.0, distance - options_.arrival_m),
                   -options_.max_yaw_rad_s, options_.max_yaw_rad_s);
    const double forward = options_.max_forward_m_s * slower_near * std::max(0.0, std::cos(bearing));
    return {forward, yaw};
  }

  /// Where it steers to, in odom.
  [[nodiscard]] const client::Vector3& p_odom_goal() const { return p_odom_goal_; }

 private:
  void glide(const client::Vector3& target, double dt_s) {
    if (!gliding_) p_odom_goal_ = target;
    gliding_ = true;
    client::Vector3 way{};
    double length = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      way[i] = target[i] - p_odom_goal_[i];
      length += way[i] * way[i];
    }
    length = std::sqrt(length);
    const double part = length > 0 ? std::min(1.0, options_.glide_m_s * dt_s / length) : 0.0;
    for (std::size_t i = 0; i < 3; ++i) p_odom_goal_[i] += part * way[i];
  }

  PlannerOptions options_;
  client::Vector3 p_map_goal_{}, p_odom_goal_{};
  bool gliding_ = false;  // p_odom_goal_ is of this goal
};

}  // namespace loopsift::example
