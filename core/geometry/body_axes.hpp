// SPDX-License-Identifier: MIT
// Camera axes (x right, y down, z forward) and those of a robot's body (X forward, Y left, Z up). Never
// allocates.
#pragma once
#include "core/geometry/se3.hpp"

namespace loopsift {

/// Turns camera axes into body axes: body X is the camera's z, body Y its −x, body Z its −y.
[[nodiscard]] inline Eigen::Matrix3d camera_to_body_axes() {
  return (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
}

/// The pose of a camera in a world with a camera's axes, from that of the body which carries it in a world
/// with a body's axes. T_body_mount: where the camera sits on the body, with a body's axes.
[[nodiscard]] inline Se3 camera_pose(const Se3& T_local_body, const Se3& T_body_mount) {
  const Se3 axes(camera_to_body_axes(), Eigen::Vector3d::Zero());
  return axes.inverse() * T_local_body * T_body_mount * axes;
}

}  // namespace loopsift
