// SPDX-License-Identifier: MIT
#include "core/pipeline/slew.hpp"

#include <algorithm>

namespace loopsift {
namespace {

double part(double distance, double max_rate, double dt_s) {
  if (max_rate <= 0 || distance <= 0) return 1.0;
  return std::clamp(max_rate * dt_s / distance, 0.0, 1.0);
}

}  // namespace

const Se3& Slew::follow(const Se3& T_map_odom, const Se3& T_odom_camera, double dt_s) {
  const Vector6d jump = ((T_map_odom_ * T_odom_camera).inverse() * T_map_odom * T_odom_camera).log();
  const double s = std::min(part(jump.head<3>().norm(), options_.max_m_per_s, dt_s),
                            part(jump.tail<3>().norm(), options_.max_rad_per_s, dt_s));
  T_map_odom_ =
      s < 1.0 ? T_map_odom_ * T_odom_camera * Se3::exp(s * jump) * T_odom_camera.inverse() : T_map_odom;
  return T_map_odom_;
}

}  // namespace loopsift
