// SPDX-License-Identifier: MIT
// A second look at a loop that improves the map: is it the best of its neighbourhood?
//
// Where nothing anchors the odometry, a loop that is wrong by less than the drift improves the map, and the
// score alone takes it. But then a motion next to it explains the two fragments better still. So a loop is
// challenged by its neighbours at the distance of the very correction that it makes: a true loop is far
// nearer to the truth than the map was, so each of them is worse; a near miss has neighbours that are better.
// The scale is the loop's own; no threshold.
#pragma once
#include <vector>

#include "core/base/span.hpp"
#include "core/posterior/map_scorer.hpp"
#include "core/proposal/loop.hpp"

namespace loopsift {

/// The neighbours of a loop's T_i_j: moved by as much as the loop moves fragment j's centre against the map,
/// along the three axes and the eight diagonals, and turned about that centre by as much as it turns fragment
/// j, about the three axes, each both ways. centroid_j: of fragment j, in its frame. T_i_j_map: the motion in
/// the map without the loop.
[[nodiscard]] std::vector<Se3> challengers(const Se3& T_i_j, const Se3& T_i_j_map,
                                           const Eigen::Vector3d& centroid_j);

/// True when no challenger explains the pair's measurements better (MapScorer::compare_pair). T_map_fragment:
/// the map without the loop.
[[nodiscard]] bool withstands_challenge(const MapScorer& scorer, const Loop& loop,
                                        Span<const Se3> T_map_fragment);

}  // namespace loopsift
