// SPDX-License-Identifier: MIT
// Odometry that is not the built-in one: `file:TRAJECTORY`, or `lcm:CHANNEL` with the poses of a body that
// the camera sits on. Set-up only. Allocates.
#pragma once
#include <memory>

#include "core/odometry/external_odometry.hpp"
#include "core/odometry/stream_odometry.hpp"
#include "core/odometry/trajectory_odometry.hpp"
#include "drivers/lcm/lcm_in_options.hpp"

namespace loopsift {

/// Poses that come over LCM. Gaps and noise are those of odometry.file.
struct LcmOdometryOptions {
  StreamOdometryOptions stream;
  double camera_x_m = 0;  ///< where the camera sits on the body, which has X forward, Y left, Z up …
  double camera_y_m = 0;
  double camera_z_m = 0;
  double camera_roll_rad = 0;  ///< … and how it is turned: about X, then Y, then Z of the body
  double camera_pitch_rad = 0;
  double camera_yaw_rad = 0;
};

/// Opens `uri`. Null for `builtin`. camera_clock: frames are stamped by this host's monotonic clock, as live
/// cameras' are, and not by who sends the poses. Errors: a file that is no trajectory, LCM cannot be opened.
[[nodiscard]] Expected<std::unique_ptr<ExternalOdometry>> open_odometry(const std::string& uri,
                                                                        const TrajectoryOdometryOptions& file,
                                                                        const LcmOdometryOptions& lcm,
                                                                        const LcmInOptions& lcm_in,
                                                                        bool camera_clock);

}  // namespace loopsift
