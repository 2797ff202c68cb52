// SPDX-License-Identifier: MIT
#include "core/odometry/trajectory_odometry.hpp"

#include <utility>

namespace loopsift {

Expected<TrajectoryOdometry> TrajectoryOdometry::open(const std::string& path,
                                                      const TrajectoryOdometryOptions& options) {
  Expected<Trajectory> trajectory = read_trajectory(path);
  if (!trajectory) return trajectory.error();
  if (trajectory->poses.empty())
    return Error{ErrorCode::kFormat, path + ": holds no pose; give a TUM trajectory or a redwood .log"};
  return TrajectoryOdometry(std::move(*trajectory), options);
}

TrajectoryOdometry::TrajectoryOdometry(Trajectory trajectory, const TrajectoryOdometryOptions& options)
    : trajectory_(std::move(trajectory)), max_gap_s_(options.max_gap_s), chain_(options) {}

TrackingResult TrajectoryOdometry::track(FrameId frame, std::int64_t timestamp_ns) {
  const double time_s = trajectory_.indexed ? frame.value : 1e-9 * static_cast<double>(timestamp_ns);
  Se3 T_odom_camera;
  const bool known = trajectory_.at(time_s, trajectory_.indexed ? 1.0 : max_gap_s_, &T_odom_camera);
  return known ? chain_.found(T_odom_camera) : chain_.missing();
}

}  // namespace loopsift
