// SPDX-License-Identifier: MIT
// The correction that POSE shows, when it must not jump: it follows the one in force at a bounded rate,
// measured where the camera is. In: T_map_odom in force, the camera's pose, time. Out: T_map_odom to publish.
// Thread: front. Never allocates.
#pragma once
#include "core/geometry/se3.hpp"

namespace loopsift {

/// At most so fast; 0: at once. With both 0 there is no slew.
struct SlewOptions {
  double max_m_per_s = 0;
  double max_rad_per_s = 0;
};

class Slew {
 public:
  explicit Slew(const SlewOptions& options) : options_(options) {}

  /// The correction to publish, dt_s after the last call (≤ 0: none passes). The camera's corrected pose
  /// moves along the one-parameter motion towards where the correction in force has it: at the limits, or all
  /// the way.
  [[nodiscard]] const Se3& follow(const Se3& T_map_odom, const Se3& T_odom_camera, double dt_s);
  /// The next pose is where the correction has it: there was none before that it could move from.
  void jump_to(const Se3& T_map_odom) { T_map_odom_ = T_map_odom; }

 private:
  SlewOptions options_;
  Se3 T_map_odom_;
};

}  // namespace loopsift
