// SPDX-License-Identifier: MIT
// Points of a PLY file in another form: without normals, or as text. Desk code: one pass, holds no map in
// memory.
#pragma once
#include <cstddef>
#include <string>

#include "core/base/result.hpp"

namespace loopsift::tool {

struct MapConversion {
  bool drop_normals = false;  ///< leave out nx ny nz
  bool text = false;          ///< ascii instead of binary little-endian
};

/// Copies the vertices of a binary little-endian PLY and returns their number; other elements are left out,
/// comments kept. Errors name the file: not there, no PLY of that kind, a vertex property that is a list, cut
/// short, cannot be written.
[[nodiscard]] Expected<std::size_t> convert_map(const std::string& from, const std::string& to,
                                                const MapConversion& conversion);

}  // namespace loopsift::tool
