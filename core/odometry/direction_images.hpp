// SPDX-License-Identifier: MIT
// Small images of distance and brightness by direction, and how much two of them differ under a turn: what
// rotation_alignment.hpp searches with. Thread: any. Never allocates; vectorised with run-time dispatch.
#pragma once
#include <Eigen/Core>
#include <array>

#include "core/base/span.hpp"
#include "core/frame/frame.hpp"
#include "core/geometry/camera.hpp"

namespace loopsift {

/// Small images that a turn leaves as they are, but for their place.
struct DirectionImages {
  static constexpr float kNone = -1000.0F;  ///< no measurement
  static constexpr float kLeast = -500.0F;  ///< above it: a measurement
  PinholeCamera camera;
  std::array<Span<float>, 2> channel;  ///< logarithms of distance (metres) and brightness; kNone; rows on end
};

/// The most pixels that compare_turned takes.
inline constexpr int kMostTurnedPixels = 24 * 24;

/// No mean difference counts for less: a thousandth of what is compared.
inline constexpr float kLeastDifference = 1e-3F;

/// Mean absolute differences, less their mean, of the channels of kept and present under a turn, pixels
/// nearest; −1 for a channel of which less than half can be compared.
struct TurnDifference {
  std::array<float, 2> mean = {-1.0F, -1.0F};
};
[[nodiscard]] TurnDifference compare_turned(const DirectionImages& kept, const DirectionImages& present,
                                            const Eigen::Matrix3d& R_kept_present);

/// Draws the coarsest level of a frame; each pixel is the mean of step × step.
void draw_directions(const FrameLevel& level, int step, const DirectionImages& to);
/// Means over 2 × 2 of what is measured.
void halve_directions(const DirectionImages& from, const DirectionImages& to);

}  // namespace loopsift
