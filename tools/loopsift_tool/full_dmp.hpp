// SPDX-License-Identifier: MIT
// The dense map posterior as published: every frame at full resolution against the map of all fragments, the
// frame's own among them, with every surfel at its own radius. The reference for the reduced form of
// core/posterior. Zhang & Chen, "A metric for evaluating 3D reconstruction and mapping performance with no
// ground truthing" (2021). Desk code: the map is held in memory (28 bytes per surfel), frames are not.
#pragma once
#include "core/base/result.hpp"
#include "drivers/frame_source.hpp"
#include "tools/loopsift_tool/dmp_figures.hpp"
#include "tools/loopsift_tool/given_odometry.hpp"

namespace loopsift::tool {

struct FullDmpOptions {
  int fragment_frames = 50;   ///< fused rigidly together
  float min_depth_m = 0.3F;   ///< measured and predicted depth outside [min, max] does not count
  float max_depth_m = 15.0F;  ///< as published
  HeatmapOptions heatmaps;
};

/// Fuses all frames of `to_fuse` that have a pose, then scores those of `to_score`, the same recording opened
/// anew, several at a time (OpenMP). Deterministic. Errors: no frame with a pose, a source that is lost, a
/// picture that cannot be written.
[[nodiscard]] Expected<DmpFigures> full_dmp(FrameSource& to_fuse, FrameSource& to_score,
                                            const GivenOdometry& odometry, const FullDmpOptions& options);

}  // namespace loopsift::tool
