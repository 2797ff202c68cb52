// SPDX-License-Identifier: MIT
// Odometry from a file: poses that someone else tracked, with the same result type.
// In: a Trajectory (TUM or redwood .log). Out: TrackingResult per frame. Thread: front. Allocates when opened
// only.
#pragma once
#include <cstdint>
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/trajectory.hpp"
#include "core/odometry/odometry.hpp"

namespace loopsift {

struct TrajectoryOdometryOptions {
  double max_gap_s = 0.1;           ///< poses farther apart are not interpolated
  float sigma_m_per_m = 0.02F;      ///< assumed drift per metre of path, for the information
  float sigma_rad_per_rad = 0.02F;  ///< the same for rotation
  float sigma_floor_m = 0.001F;     ///< per frame
  float sigma_floor_rad = 0.001F;   ///< per frame
};

class TrajectoryOdometry {
 public:
  /// Errors: those of read_trajectory, and a file without poses.
  [[nodiscard]] static Expected<TrajectoryOdometry> open(const std::string& path,
                                                         const TrajectoryOdometryOptions& options);
  TrajectoryOdometry(Trajectory trajectory, const TrajectoryOdometryOptions& options);
  /// The pose of a frame: by its number when the trajectory is indexed, else by its time stamp. kLost
  /// (kNoPose) where the trajectory has none; kFirst at the first pose and after a loss.
  TrackingResult track(FrameId frame, std::int64_t timestamp_ns);

 private:
  [[nodiscard]] Matrix6d motion_information(const Se3& T_before_now) const;

  Trajectory trajectory_;
  TrajectoryOdometryOptions options_;
  Se3 T_odom_camera_;
  bool tracking_ = false;
};

}  // namespace loopsift
