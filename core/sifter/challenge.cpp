// SPDX-License-Identifier: MIT
#include "core/sifter/challenge.hpp"

#include <cmath>

namespace loopsift {
namespace {

constexpr double kImageStep_rad = 0.1;
constexpr double kDescentStep = 2.0 / 3.0;  // of the image step
constexpr int kMostMoves = 8;               // of a descent; more are no way to a best near by

}  // namespace

ChallengeStep image_step(const MapScorer& scorer) {
  return {kImageStep_rad * scorer.typical_depth(), kImageStep_rad};
}

ChallengeStep correction_step(const Se3& T_i_j, const Se3& T_i_j_map, const Eigen::Vector3d& centroid_j) {
  return {(T_i_j * centroid_j - T_i_j_map * centroid_j).norm(), (T_i_j.inverse() * T_i_j_map).angle()};
}

std::vector<Se3> challengers(const Se3& T_i_j, const ChallengeStep& step, const Eigen::Vector3d& centroid_j) {
  std::vector<Se3> motions;
  const auto moved = [&](const Eigen::Vector3d& direction) {
    motions.push_back(T_i_j * Se3(Eigen::Matrix3d::Identity(), step.distance_m * direction.normalized()));
  };
  const auto turned = [&](const Eigen::Vector3d& axis) {
    const Eigen::Matrix3d R = so3_exp(step.angle_rad * axis);
    motions.push_back(T_i_j * Se3(R, centroid_j - R * centroid_j));
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      moved(sign * Eigen::Vector3d::Unit(axis));
      turned(sign * Eigen::Vector3d::Unit(axis));
    }
  }
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) moved({x, y, z});
    }
  }
  return motions;
}

bool is_at_its_best(const MapScorer& scorer, const Loop& loop) {
  const Eigen::Vector3d centroid_j = scorer.centroid(loop.j);
  const ChallengeStep whole = image_step(scorer);
  const ChallengeStep step{kDescentStep * whole.distance_m, kDescentStep * whole.angle_rad};
  Se3 T_i_j = loop.T_i_j;
  for (int moves = 0; moves < kMostMoves; ++moves) {
    const std::vector<Se3> next = challengers(T_i_j, step, centroid_j);
    const int better = scorer.better_for_pair(loop.i, loop.j, T_i_j, next);
    if (better < 0) return true;
    T_i_j = next[static_cast<std::size_t>(better)];
    const ChallengeStep away = correction_step(T_i_j, loop.T_i_j, centroid_j);
    if (away.distance_m > whole.distance_m || away.angle_rad > whole.angle_rad) return false;
  }
  return false;
}

bool withstands_challenge(const MapScorer& scorer, const Loop& loop, Span<const Se3> T_map_fragment,
                          bool joined) {
  const Se3 T_i_j_map = T_map_fragment[loop.i.index()].inverse() * T_map_fragment[loop.j.index()];
  const Eigen::Vector3d centroid_j = scorer.centroid(loop.j);
  const ChallengeStep near = image_step(scorer), far = correction_step(loop.T_i_j, T_i_j_map, centroid_j);
  const auto beats = [&](const std::vector<Se3>& motions) {
    return scorer.explains_pair_best(loop.i, loop.j, loop.T_i_j, motions);
  };
  if (!beats(challengers(loop.T_i_j, near, centroid_j))) return false;
  const bool far_ones_count = joined && far.distance_m > near.distance_m;
  if (far_ones_count && !beats(challengers(loop.T_i_j, far, centroid_j))) return false;
  return is_at_its_best(scorer, loop);
}

}  // namespace loopsift
