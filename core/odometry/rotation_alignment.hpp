// SPDX-License-Identifier: MIT
// How far the camera turned between two frames, found from nothing but the two: for turns that leave the
// motion model and the reach of Gauss–Newton behind. A turn moves images over the sphere of directions and
// leaves the distance and the brightness in each direction as they are, so that logarithms of both are
// compared where R d falls in the earlier image, d a direction of the later one: min over R of Σ_c n_c log Σ
// |kept_c(π(R d)) − present_c(d) − e_c|, e_c the mean difference (a change of exposure, a step forward).
// First over all turns that leave half of the image in sight, on 20 × 15 pixels, then by Gauss–Newton on
// SO(3) on 40 × 30, as the rotation estimates of Kintinuous and ElasticFusion (Whelan et al. 2013, 2015) do;
// theirs have no search and no depth. In: frames. Out: a rotation for Odometry::track to try. Capacity: one
// frame, from the arena. Thread: front. No allocation after construction; vectorised with run-time dispatch.
#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/base/arena.hpp"
#include "core/frame/frame.hpp"
#include "core/odometry/direction_images.hpp"

namespace loopsift {

class RotationAlignment {
 public:
  /// coarsest is the camera of the coarsest level of the frames to come.
  RotationAlignment(const PinholeCamera& coarsest, Arena& arena);
  /// The frame that later ones are compared with.
  void keep(const Frame& frame);
  /// R_kept_camera of the frame; nothing where too little can be compared. Turns are looked for around the
  /// guess.
  [[nodiscard]] std::optional<Eigen::Matrix3d> find(const Frame& frame, const Eigen::Matrix3d& R_kept_guess);

 private:
  static constexpr std::size_t kLevels = 2;  // 0: for Gauss–Newton, 1: half of it, for the search
  using Pyramid = std::array<DirectionImages, kLevels>;
  void draw(const Frame& frame, const Pyramid& to) const;
  [[nodiscard]] Eigen::Matrix3d search(const Eigen::Matrix3d& R_kept_guess, TurnDifference* best) const;

  int step_ = 1;  // pixels of the frame's coarsest level per pixel of level 0
  Pyramid kept_, present_;
  bool has_kept_ = false;
};

}  // namespace loopsift
