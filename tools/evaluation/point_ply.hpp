// SPDX-License-Identifier: MIT
// Points out of PLY files, whatever else these hold. Desk code: allocates.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/base/result.hpp"

namespace loopsift {

/// The x, y, z of the vertices, in the file's unit and frame. Reads ascii and binary_little_endian; the
/// vertices come first, other properties may be of any scalar type. Errors name the file: not there, not a
/// PLY, big-endian, no x y z, fewer points than its header says (with their number), a value that is not
/// finite.
[[nodiscard]] Expected<std::vector<Eigen::Vector3f>> read_ply_points(const std::string& path);

/// The named properties of the vertices, one column for each name. Reads and refuses the same files.
[[nodiscard]] Expected<std::vector<std::vector<float>>> read_ply_columns(
    const std::string& path, const std::vector<std::string>& names);

/// Consecutive surfels of a map.ply that are of one fragment.
struct PlyFragment {
  double first_frame_s = 0;  ///< when it begins
  std::size_t surfels = 0;
};
/// From the header (core/fragment/surfel_ply.hpp), in order; empty when it does not say. Errors: the file is
/// not there, or no PLY.
[[nodiscard]] Expected<std::vector<PlyFragment>> read_ply_fragments(const std::string& path);

}  // namespace loopsift
