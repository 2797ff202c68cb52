// SPDX-License-Identifier: MIT
// Smooth camera motion through waypoints. Set-up code: allocates.
//
// The polyline through the waypoints is cut into pieces of equal effort and smoothed by a uniform cubic
// B-spline (de Boor 1978) in position and angles, so motion is C2, never leaves the hull of four neighbouring
// pieces, and is never faster than the pace. A small sum of sines stands for the hand or the robot's shaking.
#pragma once
#include <cstdint>
#include <vector>

#include "core/geometry/trajectory.hpp"

namespace loopsift {

/// World frame with z up. At yaw 0 the camera looks along +x, at yaw 90 along +y.
struct Waypoint {
  double x = 0, y = 0, z = 0;           ///< metres
  double yaw = 0, pitch = 0, roll = 0;  ///< degrees; pitch up; yaw is not wrapped: 360 is a full turn
};

struct Pace {
  double speed_mps = 0.5;       ///< along a straight line without turning
  double turn_rate_dps = 40.0;  ///< when turning in place
  double rate_hz = 30.0;        ///< poses per second
  double shake_m = 0.003;       ///< amplitude of the shaking
  double shake_deg = 0.2;
};

/// Camera poses (x right, y down, z forward) from time 0 along the whole way.
[[nodiscard]] Trajectory walk(const std::vector<Waypoint>& waypoints, const Pace& pace);

}  // namespace loopsift
