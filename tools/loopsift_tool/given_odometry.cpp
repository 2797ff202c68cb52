// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/given_odometry.hpp"

#include <cstdio>
#include <utility>

#include "tools/loopsift_tool/g2o_input.hpp"

namespace loopsift::tool {

namespace {

Expected<Trajectory> read_any(const std::string& path) {
  if (!is_g2o(path)) return read_trajectory(path);
  const Expected<PoseGraph> graph = read_g2o(path);
  if (!graph) return graph.error();
  return trajectory_of(*graph);
}

}  // namespace

GivenOdometry::GivenOdometry(std::string path, const Trajectory& trajectory)
    : path_(std::move(path)), trajectory_(trajectory), odometry_(trajectory, options_) {}

Expected<GivenOdometry> GivenOdometry::open(const std::string& trajectory_path,
                                            const std::string& info_path) {
  const Expected<Trajectory> trajectory = read_any(trajectory_path);
  if (!trajectory) return trajectory.error();
  GivenOdometry odometry(trajectory_path, *trajectory);
  if (info_path.empty()) return odometry;
  Expected<OdometryInformation> information = OdometryInformation::read(info_path, *trajectory);
  if (!information) return information.error();
  odometry.information_ = std::move(*information);
  return odometry;
}

bool GivenOdometry::pose(FrameId frame, std::int64_t timestamp_ns, GivenPose* pose) {
  const double time_s = trajectory_.indexed ? frame.value : 1e-9 * static_cast<double>(timestamp_ns);
  Se3 T_odom_camera;
  // Asked first, so that the odometry never sees a frame without a pose and takes it for a loss.
  if (!trajectory_.at(time_s, trajectory_.indexed ? 1.0 : options_.max_gap_s, &T_odom_camera)) return false;
  const TrackingResult tracked = odometry_.track(frame, timestamp_ns);
  *pose = {tracked.T_odom_camera, tracked.information};
  const FramePlace place{frame.value, 1e-9 * static_cast<double>(timestamp_ns)};
  (void)information_.between(last_posed_, place, &pose->information);
  last_posed_ = place;
  return true;
}

std::string GivenOdometry::extent() const {
  const double first = trajectory_.poses.front().time_s, last = trajectory_.poses.back().time_s;
  char text[96];
  std::snprintf(
      text, sizeof text,
      trajectory_.indexed ? " has poses for frames %.0f to %.0f" : " has poses from %.3f s to %.3f s", first,
      last);
  return path_ + text;
}

}  // namespace loopsift::tool
