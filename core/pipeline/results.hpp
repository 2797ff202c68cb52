// SPDX-License-Identifier: MIT
// The files that a run leaves (but run.json, which the program writes). Thread: main, at the end. Allocates.
#pragma once
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/span.hpp"
#include "core/pipeline/back_end.hpp"
#include "core/pipeline/corrected_trajectory.hpp"

namespace loopsift {

/// Pose of each of the store's fragments in the best map. Those that the back end does not hold (yet) follow
/// the last one that it does.
[[nodiscard]] std::vector<Se3> map_poses(const BackEnd& back_end, Span<const Fragment> fragments);

/// Writes into folder `out` (which exists): trajectory_odometry.txt, trajectory.txt, proposals.log/.info,
/// accepted.log/.info, loops.csv, posegraph.g2o, map.ply. `fragments` are those of the store. The first
/// failure (no rights, disk full) is returned, naming the file; what can still be written is.
[[nodiscard]] Status write_results(const std::string& out, const BackEnd& back_end,
                                   Span<const OdometryPose> frames, Span<const Fragment> fragments);

/// What can be written without a back end, whose state is not known: trajectory_odometry.txt, and
/// trajectory.txt and map.ply as the odometry has them, moved by one correction.
[[nodiscard]] Status write_front_results(const std::string& out, const Se3& T_map_odom,
                                         Span<const OdometryPose> frames, Span<const Fragment> fragments);

}  // namespace loopsift
