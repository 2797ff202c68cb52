// SPDX-License-Identifier: MIT
#include "core/odometry/trajectory_odometry.hpp"

#include <cmath>
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
    : trajectory_(std::move(trajectory)), options_(options) {}

TrackingResult TrajectoryOdometry::track(FrameId frame, std::int64_t timestamp_ns) {
  const double time_s = trajectory_.indexed ? frame.value : 1e-9 * static_cast<double>(timestamp_ns);
  const double max_gap = trajectory_.indexed ? 1.0 : options_.max_gap_s;
  TrackingResult result;
  Se3 T_odom_camera;
  if (!trajectory_.at(time_s, max_gap, &T_odom_camera)) {
    tracking_ = false;
    result.reason = LostReason::kNoPose;
    result.T_odom_camera = T_odom_camera_;
    return result;
  }
  result.status = tracking_ ? TrackingStatus::kTracked : TrackingStatus::kFirst;
  result.T_odom_camera = T_odom_camera;
  result.inlier_fraction = 1.0F;
  if (tracking_) result.information = motion_information(T_odom_camera_.inverse() * T_odom_camera);
  T_odom_camera_ = T_odom_camera;
  tracking_ = true;
  return result;
}

Matrix6d TrajectoryOdometry::motion_information(const Se3& T_before_now) const {
  const double sigma_t =
      std::hypot(static_cast<double>(options_.sigma_m_per_m) * T_before_now.translation().norm(),
                 static_cast<double>(options_.sigma_floor_m));
  const double sigma_r = std::hypot(static_cast<double>(options_.sigma_rad_per_rad) * T_before_now.angle(),
                                    static_cast<double>(options_.sigma_floor_rad));
  Vector6d information;
  information.head<3>().setConstant(1.0 / (sigma_t * sigma_t));
  information.tail<3>().setConstant(1.0 / (sigma_r * sigma_r));
  return information.asDiagonal();
}

}  // namespace loopsift
