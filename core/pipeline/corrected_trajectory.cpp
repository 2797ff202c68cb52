// SPDX-License-Identifier: MIT
#include "core/pipeline/corrected_trajectory.hpp"

namespace loopsift {
namespace {

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace

Trajectory corrected_trajectory(Span<const OdometryPose> frames, const PoseGraph& odometry,
                                const std::vector<Se3>& T_map_node) {
  if (odometry.nodes.empty()) return odometry_trajectory(frames);
  std::vector<Se3> T_map_odom;
  for (std::size_t n = 0; n < T_map_node.size(); ++n) {
    T_map_odom.push_back(T_map_node[n] * odometry.T_map_node[n].inverse());
  }
  std::vector<bool> goes_on(odometry.nodes.size(), false);  // from a node to the next without a loss
  for (const Edge& edge : odometry.odometry) goes_on[static_cast<std::size_t>(edge.a)] = true;
  Trajectory corrected;
  std::size_t n = 0;  // last node not after the frame
  for (const OdometryPose& frame : frames) {
    while (n + 1 < odometry.nodes.size() && odometry.nodes[n + 1].timestamp_ns <= frame.timestamp_ns) ++n;
    Se3 T_map_camera = T_map_odom[n] * frame.T_odom_camera;
    const std::int64_t begin = odometry.nodes[n].timestamp_ns;
    if (goes_on[n] && frame.timestamp_ns > begin) {
      const std::int64_t end = odometry.nodes[n + 1].timestamp_ns;
      const double s = static_cast<double>(frame.timestamp_ns - begin) / static_cast<double>(end - begin);
      T_map_camera = interpolate(T_map_camera, T_map_odom[n + 1] * frame.T_odom_camera, s);
    }
    corrected.poses.push_back({seconds(frame.timestamp_ns), T_map_camera});
  }
  return corrected;
}

Trajectory odometry_trajectory(Span<const OdometryPose> frames) {
  Trajectory trajectory;
  for (const OdometryPose& frame : frames) {
    trajectory.poses.push_back({seconds(frame.timestamp_ns), frame.T_odom_camera});
  }
  return trajectory;
}

}  // namespace loopsift
