// SPDX-License-Identifier: MIT
// What registration works on: a fragment's surfels thinned to one averaged point per voxel.
// In: surfels. Out: points with normals, in order of first occurrence (deterministic). Thread: back. Buffers
// are reused; after the first fragment of full size nothing allocates.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/fragment/fragment.hpp"

namespace loopsift {

struct RegistrationCloudOptions {
  float voxel_m = 0.05F;   ///< edge of a voxel
  int max_points = 12000;  ///< capacity; at most 65534. Voxels beyond it are left out (those seen last)
};

/// Points and unit normals of one surface, metres, fragment frame; both of the same size.
struct RegistrationCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
  [[nodiscard]] std::size_t size() const { return points.size(); }
  void clear() {
    points.clear();
    normals.clear();
  }
  void reserve(std::size_t count) {
    points.reserve(count);
    normals.reserve(count);
  }
};

/// Thins surfels to a voxel grid by averaging, weighted by confidence. Surfels that face away from the first
/// one in their voxel do not count (the other side of a thin thing); nor do those with NaN or without normal.
class VoxelThinner {
 public:
  explicit VoxelThinner(const RegistrationCloudOptions& options);
  void thin(const SurfelSpan& surfels, RegistrationCloud* cloud);

 private:
  struct Slot {
    std::int32_t x = 0, y = 0, z = 0;
    std::int32_t point = -1;  ///< index into the cloud; −1: free
  };
  /// The cloud's point of a voxel, made if there is room; −1 when there is not.
  int find_or_add(std::int32_t x, std::int32_t y, std::int32_t z);

  RegistrationCloudOptions options_;
  std::vector<Slot> slots_;  ///< open addressing, power of two, at most half full
  std::vector<float> weights_;
  int point_count_ = 0;
};

}  // namespace loopsift
