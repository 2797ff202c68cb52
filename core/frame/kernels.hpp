// SPDX-License-Identifier: MIT
// The per-pixel work of FramePreprocessor, one function per pass over memory. All depths in metres, 0
// invalid; no allocation; vectorised with run-time dispatch.
#pragma once
#include <cstdint>

#include "core/geometry/camera.hpp"
#include "core/geometry/image.hpp"

namespace loopsift {

struct DepthRange {
  float min_m, max_m;
  float edge_fraction;  ///< of the depth; see FrameOptions
};

/// Raw depth to metres, reduced by step (1 or 2). A 2 × 2 block becomes the mean of those of its pixels that
/// lie within the edge fraction of its nearest one: never of two surfaces. 0, 65535 and what is out of range
/// is left out.
void reduce_raw(const ImageView<const std::uint16_t>& raw, int step, float unit_m, const DepthRange& range,
                const ImageView<float>& out);
/// The same reduction by 2 from metres.
void halve_depth(const ImageView<const float>& depth, float edge_fraction, const ImageView<float>& out);
/// Mean over the (2 radius + 1)² neighbours on the same surface; the border of `radius` pixels is copied.
void smooth_depth(const ImageView<const float>& depth, int radius, float edge_fraction,
                  const ImageView<float>& out);
/// Unit normals toward the camera from central differences; 0, 0, 0 at the border, without depth and across
/// edges. With z(u, v): n ∝ (fx z_u, fy z_v, −(z + (u−cx) z_u + (v−cy) z_v)), the cross product of the
/// tangents.
void compute_normals(const ImageView<const float>& depth, const PinholeCamera& camera, float edge_fraction,
                     float* nx, float* ny, float* nz);
/// Pixels with a depth.
int count_valid(const ImageView<const float>& depth);

}  // namespace loopsift
