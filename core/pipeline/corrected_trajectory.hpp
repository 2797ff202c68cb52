// SPDX-License-Identifier: MIT
// From the graph's optimised nodes to a pose for every frame. Thread: back, or the desk. Allocates.
#pragma once
#include <cstdint>
#include <vector>

#include "core/base/span.hpp"
#include "core/geometry/trajectory.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {

/// A frame's pose in the odometry's world.
struct OdometryPose {
  std::int64_t timestamp_ns = 0;
  Se3 T_odom_camera;
};

/// Each frame corrected by what the two nodes around it in time say, blended on SE(3) by time, so that the
/// trajectory has no step where fragments meet. Before the first and after the last node of a piece that was
/// tracked without a loss the nearest one's correction holds. `odometry` has the graph with the odometry's
/// poses, T_map_node the corrected ones (by node).
[[nodiscard]] Trajectory corrected_trajectory(Span<const OdometryPose> frames, const PoseGraph& odometry,
                                              const std::vector<Se3>& T_map_node);
/// The frames as they are.
[[nodiscard]] Trajectory odometry_trajectory(Span<const OdometryPose> frames);

}  // namespace loopsift
