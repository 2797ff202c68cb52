// SPDX-License-Identifier: MIT
// Time-stamped poses and the files they come in. Desk and set-up code: allocates.
#pragma once
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift {

/// One pose of the camera in a world frame.
struct StampedPose {
  double time_s = 0;  ///< seconds; the frame's index when the file carries none (redwood .log)
  Se3 T_world_camera;
};

/// In order of time. `indexed` says that time_s holds frame numbers, not seconds.
struct Trajectory {
  std::vector<StampedPose> poses;
  bool indexed = false;

  /// The pose at a time by interpolation on SE(3) between neighbours at most max_gap_s apart. A pose
  /// within 0.1 ms, to which files round times, is taken as it is.
  [[nodiscard]] bool at(double time_s, double max_gap_s, Se3* T_world_camera) const;
};

/// One record of a redwood .log: three integers and a rigid transform.
struct LogRecord {
  int a = 0, b = 0, n = 0;
  Se3 T;
};

/// Reads TUM (`t tx ty tz qx qy qz qw`) or redwood .log, told apart by content. Errors name file and line:
/// NaN, a rotation that is none, time that goes back.
[[nodiscard]] Expected<Trajectory> read_trajectory(const std::string& path);
/// TUM format, 9 decimals, camera-to-world.
[[nodiscard]] Status write_trajectory_tum(const std::string& path, const Trajectory& trajectory);
/// Redwood .log, camera-to-world.
[[nodiscard]] Status write_trajectory_log(const std::string& path, const Trajectory& trajectory);

/// Rotations that are nearly orthonormal (published proposers write some scaled by 5 %) are brought to the
/// nearest true one; errors name file and line.
[[nodiscard]] Expected<std::vector<LogRecord>> read_log(const std::string& path);
[[nodiscard]] Status write_log(const std::string& path, const std::vector<LogRecord>& records);
/// Redwood .info: 6×6 in the order (t, q_xyz); returned in our tangent (t, ω), ω = 2 q_xyz. Records keep a,
/// b, n.
struct InfoRecord {
  int a = 0, b = 0, n = 0;
  Matrix6d information = Matrix6d::Identity();  ///< (t, ω) order
};
[[nodiscard]] Expected<std::vector<InfoRecord>> read_info(const std::string& path);
[[nodiscard]] Status write_info(const std::string& path, const std::vector<InfoRecord>& records);

}  // namespace loopsift
