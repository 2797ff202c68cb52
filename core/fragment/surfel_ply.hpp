// SPDX-License-Identifier: MIT
// The map as a file for viewers. Binary little-endian PLY, one vertex per surfel in this order: float x y z
// (metres, map frame), float nx ny nz, uchar red green blue, float radius (metres), float confidence. The
// surfels come fragment by fragment; the header says where each ends, in lines
// `comment fragment ID surfels COUNT first_frame_s SECONDS`. Desk and shut-down code; streams, so that memory
// stays small.
#pragma once
#include <string>

#include "core/base/result.hpp"
#include "core/fragment/fragment.hpp"

namespace loopsift {

/// T_map_fragment has one pose per fragment. Errors name the path: it cannot be created, or the disk is full.
[[nodiscard]] Status write_surfel_ply(const std::string& path, Span<const Fragment> fragments,
                                      Span<const Se3> T_map_fragment);

}  // namespace loopsift
