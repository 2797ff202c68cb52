// SPDX-License-Identifier: MIT
// Trajectories and loops out of other systems' g2o graphs. Vertices, in order of id, are the recording's
// frames in order; with a `PATH.times` beside the graph (as ours have) those frames that have their times; or
// the fragments, where there are exactly as many. Edges between consecutive vertices are odometry, all others
// loops. Desk code: allocates.
#pragma once
#include <string>
#include <vector>

#include "core/fragment/fragment.hpp"
#include "core/geometry/trajectory.hpp"
#include "core/posegraph/pose_graph.hpp"
#include "core/proposal/loop.hpp"

namespace loopsift::tool {

/// By the ending.
[[nodiscard]] bool is_g2o(const std::string& path);

/// Whether its vertices have times.
[[nodiscard]] bool has_times(const PoseGraph& graph);

/// The poses of all vertices: by time where the graph has times, else by frame number.
[[nodiscard]] Trajectory trajectory_of(const PoseGraph& graph);

/// The graph's loops as loops between fragments: each edge carried to the first cameras of the fragments that
/// its ends lie in, its information with it. Edges inside a fragment say nothing to the sifter and are left
/// out. `path` is for messages. Error: a vertex that is no frame of any fragment.
[[nodiscard]] Expected<std::vector<Loop>> loops_of(const PoseGraph& graph, const std::string& path,
                                                   Span<const Fragment> fragments);

}  // namespace loopsift::tool
