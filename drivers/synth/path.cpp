// SPDX-License-Identifier: MIT
#include "drivers/synth/path.hpp"

#include <array>
#include <cmath>

namespace loopsift {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kPieceSeconds = 0.8;  // time from one control point to the next

using Control = Eigen::Matrix<double, 6, 1>;  // x y z, yaw pitch roll in radians

Control control_of(const Waypoint& w) {
  Control c;
  c << w.x, w.y, w.z, w.yaw * kDegree, w.pitch * kDegree, w.roll * kDegree;
  return c;
}

/// The polyline at equal steps of effort: metres, and radians weighted so that turning at the turn rate costs
/// as much as moving at full speed.
std::vector<Control> even_controls(const std::vector<Waypoint>& waypoints, const Pace& pace) {
  const double metres_per_radian = pace.speed_mps / (pace.turn_rate_dps * kDegree);
  const double step = pace.speed_mps * kPieceSeconds;
  std::vector<Control> controls = {control_of(waypoints.front())};
  double missing = step;  // effort to go until the next control point
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    const Control from = control_of(waypoints[i - 1]), way = control_of(waypoints[i]) - from;
    const double effort = std::hypot(way.head<3>().norm(), metres_per_radian * way.tail<3>().norm());
    double done = missing;
    for (; done <= effort; done += step) controls.push_back(from + done / effort * way);
    missing = done - effort;
  }
  return controls;
}

/// Uniform cubic B-spline on the piece between controls[i + 1] and controls[i + 2], s in [0, 1].
Control spline(const std::vector<Control>& controls, std::size_t i, double s) {
  const double r = 1.0 - s, s2 = s * s, s3 = s2 * s;
  return (r * r * r * controls[i] + (3.0 * s3 - 6.0 * s2 + 4.0) * controls[i + 1] +
          (-3.0 * s3 + 3.0 * s2 + 3.0 * s + 1.0) * controls[i + 2] + s3 * controls[i + 3]) /
         6.0;
}

Se3 pose_of(const Control& c) {
  const double cy = std::cos(c(3)), sy = std::sin(c(3)), cp = std::cos(c(4)), sp = std::sin(c(4));
  Eigen::Matrix3d R;
  R.col(0) << sy, -cy, 0.0;
  R.col(2) << cy * cp, sy * cp, sp;
  R.col(1) = R.col(2).cross(R.col(0));
  return {R * so3_exp({0.0, 0.0, c(5)}), c.head<3>()};
}

/// Two sines per degree of freedom, at frequencies that share no period.
Vector6d shake(double time_s, const Pace& pace) {
  constexpr std::array<double, 6> kHertz = {0.83, 1.09, 1.57, 0.71, 1.27, 0.97};
  Vector6d xi;
  for (int k = 0; k < 6; ++k) {
    const double w = 2.0 * kDegree * 180.0 * kHertz[static_cast<std::size_t>(k)] * time_s;
    const double amplitude = k < 3 ? pace.shake_m : pace.shake_deg * kDegree;
    xi(k) = amplitude * (0.7 * std::sin(w + k) + 0.3 * std::sin(2.31 * w + 2.0 * k));
  }
  return xi;
}

}  // namespace

Trajectory walk(const std::vector<Waypoint>& waypoints, const Pace& pace) {
  std::vector<Control> controls = even_controls(waypoints, pace);
  while (controls.size() < 4) controls.push_back(controls.back());
  Trajectory trajectory;
  for (std::size_t k = 0;; ++k) {
    const double time_s = static_cast<double>(k) / pace.rate_hz;
    const double piece = time_s / kPieceSeconds;
    const auto i = static_cast<std::size_t>(piece);
    if (i + 3 >= controls.size()) break;
    const Se3 T = pose_of(spline(controls, i, piece - static_cast<double>(i)));
    trajectory.poses.push_back({time_s, T * Se3::exp(shake(time_s, pace))});
  }
  return trajectory;
}

}  // namespace loopsift
