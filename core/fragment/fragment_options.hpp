// SPDX-License-Identifier: MIT
// Settings of fusion and of fragments.
#pragma once
#include "core/base/result.hpp"

namespace loopsift {

struct FragmentOptions {
  int frames_per_fragment = 50;  ///< at most; a fragment closes earlier where one of the next three says so
  float max_travel_m = 0;        ///< way of the camera; 0: no limit
  float max_turn_rad = 0;        ///< sum of the camera's turns; 0: no limit
  float max_drift_m = 0;         ///< standard deviation of the position since the first frame; 0: no limit
  int views_per_fragment = 2;    ///< frames kept for scoring, evenly spread
  int view_step = 16;            ///< raw pixels per view pixel in each direction
  int active_capacity = 100000;  ///< surfels of the fragment being built
  int max_surfels = 40000;       ///< of a closed fragment; a larger one is thinned more coarsely
  float thin_cell_m = 0.02F;     ///< closed fragments keep about one surfel per cube of this edge and side
  float merge_distance_sigmas = 3.0F;  ///< a measurement within this many σ(z) of a surfel is of that surfel
  float noise_floor_m = 0.0012F;       ///< σ(z) as in OdometryOptions
  float noise_slope = 0.003F;          ///< per metre
  float min_normal_cosine = 0.5F;      ///< two sides of a thin thing have normals farther apart: never merged
  float min_view_cosine = 0.2F;        ///< measurements at more grazing angles are not fused
  int min_frames_seen = 3;             ///< surfels seen in fewer frames are dropped at closing
  int max_unconfirmed_frames =
      10;  ///< a surfel seen in fewer frames than that must be confirmed within these
};
[[nodiscard]] Status validate(const FragmentOptions& options);

}  // namespace loopsift
