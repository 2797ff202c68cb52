// SPDX-License-Identifier: MIT
// Trajectories in the formats that benchmarks use. Desk code: allocates.
//
//   TUM      `t tx ty tz qx qy qz qw`, seconds
//   KITTI    twelve numbers, the upper 3×4 of the pose by rows; the line is the frame
//   EuRoC    data.csv of a ground truth in ASL form: `ns,px,py,pz,qw,qx,qy,qz` and whatever follows
//   redwood  .log: `k k k+1` and the 4×4 pose by rows; k is the frame
//
// All poses are taken as T_world_camera. (EuRoC's are of the sensor that the file is of: its ground truth is
// the IMU's. Evaluating an estimate of the camera against it needs the extrinsics applied first.)
#pragma once
#include <optional>
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/trajectory.hpp"

namespace loopsift {

enum class TrajectoryFormat { kTum, kKitti, kEuroc, kRedwood };

/// "tum", "kitti", "euroc" or "redwood"; the error lists them.
[[nodiscard]] Expected<TrajectoryFormat> trajectory_format(const std::string& name);

/// The format is told by the first line of data unless given. A folder is taken for EuRoC's and its
/// `data.csv` looked for as it is, under `state_groundtruth_estimate0` and under
/// `mav0/state_groundtruth_estimate0`. Errors name file and line: a line of another format, a number that is
/// none or not finite, no rotation, time that goes back, no pose at all.
[[nodiscard]] Expected<Trajectory> read_any_trajectory(const std::string& path,
                                                       std::optional<TrajectoryFormat> format = {});

/// Writes in the given format. A trajectory by frame number has no seconds: TUM and EuRoC then get
/// frame / rate_hz. KITTI and redwood drop the times.
[[nodiscard]] Status write_any_trajectory(const std::string& path, const Trajectory& trajectory,
                                          TrajectoryFormat format, double rate_hz);

}  // namespace loopsift
