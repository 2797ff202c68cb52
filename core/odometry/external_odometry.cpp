// SPDX-License-Identifier: MIT
#include "core/odometry/external_odometry.hpp"

#include <cmath>

namespace loopsift {

Matrix6d MotionNoise::information(const Se3& T_before_now) const {
  const double sigma_t = std::hypot(static_cast<double>(sigma_m_per_m) * T_before_now.translation().norm(),
                                    static_cast<double>(sigma_floor_m));
  const double sigma_r = std::hypot(static_cast<double>(sigma_rad_per_rad) * T_before_now.angle(),
                                    static_cast<double>(sigma_floor_rad));
  Vector6d information;
  information.head<3>().setConstant(1.0 / (sigma_t * sigma_t));
  information.tail<3>().setConstant(1.0 / (sigma_r * sigma_r));
  return information.asDiagonal();
}

TrackingResult PoseChain::found(const Se3& T_odom_camera) {
  TrackingResult result;
  result.status = tracking_ ? TrackingStatus::kTracked : TrackingStatus::kFirst;
  result.T_odom_camera = T_odom_camera;
  result.inlier_fraction = 1.0F;
  if (tracking_) result.information = noise_.information(T_odom_camera_.inverse() * T_odom_camera);
  T_odom_camera_ = T_odom_camera;
  tracking_ = true;
  return result;
}

TrackingResult PoseChain::missing() {
  TrackingResult result;
  result.reason = LostReason::kNoPose;
  result.T_odom_camera = T_odom_camera_;
  tracking_ = false;
  return result;
}

}  // namespace loopsift
