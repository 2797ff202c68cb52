// SPDX-License-Identifier: MIT
// A second look at a loop that improves the map: is it the best of its neighbourhood?
//
// Where nothing anchors the odometry, a loop that is wrong by less than the drift improves the map, and the
// score alone takes it. But then some motion next to it explains the two fragments better still. So a loop is
// challenged by its neighbours, and believed only when each of them explains what the pair's views measured
// worse than it does; and a descent from it must not lead away. On labelled loops (191 true ones with errors
// of 1–2 cm and 0.5–1°, 85 false ones that improve the map with those accepted before) the first refused all
// but one of the false and 9 of the true, by the sign alone. With both, no wrong loop was accepted in 143
// sets of loops.
#pragma once
#include <vector>

#include "core/base/span.hpp"
#include "core/posterior/map_scorer.hpp"
#include "core/proposal/loop.hpp"

namespace loopsift {

/// How far a loop's challengers stand from it.
struct ChallengeStep {
  double distance_m = 0;
  double angle_rad = 0;
};

/// A tenth of a radian, and a tenth of the measured depth: both shift the image by the same amount, small
/// against what a wrong loop is off, large against what a registration is.
[[nodiscard]] ChallengeStep image_step(const MapScorer& scorer);
/// The step by which the loop itself moves fragment j (its centroid, in its frame) in the map.
[[nodiscard]] ChallengeStep correction_step(const Se3& T_i_j, const Se3& T_i_j_map,
                                            const Eigen::Vector3d& centroid_j);

/// T_i_j moved by the step's distance along the three axes and the eight diagonals, and turned about fragment
/// j's centroid by the step's angle about the three axes, each both ways: 20 motions.
[[nodiscard]] std::vector<Se3> challengers(const Se3& T_i_j, const ChallengeStep& step,
                                           const Eigen::Vector3d& centroid_j);

/// Whether the best motion near the loop is the loop, but for a registration's error: a descent from it, from
/// challenger to best challenger by two thirds of the image step, ends no farther away than the image step.
[[nodiscard]] bool is_at_its_best(const MapScorer& scorer, const Loop& loop);

/// True when the loop is at its best, and every challenger explains the pair's measurements worse
/// (MapScorer::explains_pair_best): those at the image step, and those at the correction that the loop makes
/// where that is larger. False, too, where the fragments share no pixel. T_map_fragment: the map without the
/// loop. joined: whether edges join the two in it; after a loss of tracking the map knows nothing about their
/// motion, and what the loop makes of it is no correction.
[[nodiscard]] bool withstands_challenge(const MapScorer& scorer, const Loop& loop,
                                        Span<const Se3> T_map_fragment, bool joined);

}  // namespace loopsift
