// SPDX-License-Identifier: MIT
// Triangle meshes of rendered scenes and of ground-truth surfaces.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/image.hpp"

namespace loopsift {

/// Indexed triangles. Desk code: allocates.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;   ///< metres, world frame
  std::vector<Eigen::Vector3i> triangles;  ///< indices into vertices, counter-clockwise seen from outside
  std::vector<Rgb8> colors;                ///< one per vertex, or empty
};

}  // namespace loopsift
