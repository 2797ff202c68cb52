// SPDX-License-Identifier: MIT
// How far the odometry may have drifted between each fragment and the newest one. Thread: back. Allocates.
#pragma once
#include <vector>

#include "core/posegraph/pose_graph.hpp"

namespace loopsift {

/// By fragment: the standard deviation of its position relative to the newest fragment's, per axis, metres,
/// at most 1 m (also where the chain is broken). First order: the covariances of the edges in between summed,
/// rotations at the distance of the two. Loops are not looked at, so it is an upper bound.
[[nodiscard]] std::vector<float> drift_to_newest(const PoseGraph& graph);

}  // namespace loopsift
