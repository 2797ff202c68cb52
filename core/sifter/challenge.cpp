// SPDX-License-Identifier: MIT
#include "core/sifter/challenge.hpp"

#include <algorithm>
#include <cmath>

namespace loopsift {

std::vector<Se3> challengers(const Se3& T_i_j, const Se3& T_i_j_map, const Eigen::Vector3d& centroid_j) {
  const double distance = (T_i_j * centroid_j - T_i_j_map * centroid_j).norm();
  const double angle = (T_i_j.inverse() * T_i_j_map).angle();
  std::vector<Se3> motions;
  const auto moved = [&](const Eigen::Vector3d& direction) {
    motions.push_back(T_i_j * Se3(Eigen::Matrix3d::Identity(), distance * direction.normalized()));
  };
  const auto turned = [&](const Eigen::Vector3d& axis) {
    const Eigen::Matrix3d R = so3_exp(angle * axis);
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

bool withstands_challenge(const MapScorer& scorer, const Loop& loop, Span<const Se3> T_map_fragment) {
  const Se3 T_i_j_map = T_map_fragment[loop.i.index()].inverse() * T_map_fragment[loop.j.index()];
  const std::vector<Se3> motions = challengers(loop.T_i_j, T_i_j_map, scorer.centroid(loop.j));
  return std::none_of(motions.begin(), motions.end(), [&](const Se3& challenger) {
    return scorer.compare_pair(loop.i, loop.j, loop.T_i_j, challenger) > 0;
  });
}

}  // namespace loopsift
