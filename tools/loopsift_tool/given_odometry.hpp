// SPDX-License-Identifier: MIT
// Somebody else's trajectory as the odometry of a recording. In: a TUM trajectory (by time), a redwood .log
// (by frame number) or a .g2o (see g2o_input.hpp), and, where it is known, the information of each motion.
// Out: the pose of a frame and the information of the motion to it. Desk code: allocates when opened, one
// thread.
#pragma once
#include <cstdint>
#include <string>

#include "core/odometry/trajectory_odometry.hpp"
#include "tools/loopsift_tool/odometry_information.hpp"

namespace loopsift::tool {

/// A frame's pose, and what is known about the motion from the posed frame before it.
struct GivenPose {
  Se3 T_odom_camera;
  Matrix6d information = Matrix6d::Zero();  ///< (t, ω), right perturbation; zero for the first frame
};

class GivenOdometry {
 public:
  /// info_path may be empty: each motion's information is then TrajectoryOdometryOptions' assumption about
  /// drift, as it is for the motions that the file says nothing about. Errors name file and line or record:
  /// NaN, no rotation, time that goes back, and those of OdometryInformation.
  [[nodiscard]] static Expected<GivenOdometry> open(const std::string& trajectory_path,
                                                    const std::string& info_path);

  /// The pose of a frame; false where the trajectory has none (TUM poses more than 0.1 s apart are not
  /// interpolated). Frames come in order. A gap is bridged: the trajectory goes on in the same world.
  [[nodiscard]] bool pose(FrameId frame, std::int64_t timestamp_ns, GivenPose* pose);

  /// "PATH has poses for frames 0 to 999" or "… from 12.500 s to 60.100 s", for messages.
  [[nodiscard]] std::string extent() const;

 private:
  GivenOdometry(std::string path, const Trajectory& trajectory);

  TrajectoryOdometryOptions options_;
  std::string path_;
  Trajectory trajectory_;
  TrajectoryOdometry odometry_;
  OdometryInformation information_;
  FramePlace last_posed_;
};

}  // namespace loopsift::tool
