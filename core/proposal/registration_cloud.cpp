// SPDX-License-Identifier: MIT
#include "core/proposal/registration_cloud.hpp"

#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {

std::size_t power_of_two_above(std::size_t n) {
  std::size_t power = 16;
  while (power < n) power *= 2;
  return power;
}

/// Teschner et al. 2003.
std::size_t hash(std::int32_t x, std::int32_t y, std::int32_t z) {
  const std::uint32_t h = static_cast<std::uint32_t>(x) * 73856093U ^
                          static_cast<std::uint32_t>(y) * 19349669U ^
                          static_cast<std::uint32_t>(z) * 83492791U;
  return h ^ (h >> 15U);
}

}  // namespace

VoxelThinner::VoxelThinner(const RegistrationCloudOptions& options)
    : options_(options), slots_(power_of_two_above(2 * static_cast<std::size_t>(options.max_points))) {
  weights_.reserve(static_cast<std::size_t>(options.max_points));
}

int VoxelThinner::find_or_add(std::int32_t x, std::int32_t y, std::int32_t z) {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t s = hash(x, y, z) & mask;; s = (s + 1) & mask) {
    Slot& slot = slots_[s];
    if (slot.point >= 0) {
      if (slot.x == x && slot.y == y && slot.z == z) return slot.point;
      continue;
    }
    if (point_count_ >= options_.max_points) return -1;
    slot = {x, y, z, point_count_++};
    return slot.point;
  }
}

void VoxelThinner::thin(const SurfelSpan& surfels, RegistrationCloud* cloud) {
  std::fill(slots_.begin(), slots_.end(), Slot());
  weights_.clear();
  cloud->clear();
  cloud->reserve(
      static_cast<std::size_t>(options_.max_points));  // whatever comes after, both lists stay alike
  point_count_ = 0;
  const float inverse_voxel = 1.0F / options_.voxel_m;
  constexpr float kFarthestVoxel = 1e9F;
  for (std::size_t k = 0; k < surfels.size(); ++k) {
    const Eigen::Vector3f p(surfels.x[k], surfels.y[k], surfels.z[k]);
    const Eigen::Vector3f n(surfels.nx[k], surfels.ny[k], surfels.nz[k]);
    const float weight = surfels.weight[k];
    const Eigen::Array3f voxel = (p * inverse_voxel).array().floor();
    if (!(voxel.abs().maxCoeff() < kFarthestVoxel) || !(n.squaredNorm() > 0.25F) || !(weight > 0)) continue;
    const int point = find_or_add(static_cast<std::int32_t>(voxel.x()), static_cast<std::int32_t>(voxel.y()),
                                  static_cast<std::int32_t>(voxel.z()));
    if (point < 0) continue;
    const auto i = static_cast<std::size_t>(point);
    if (i == cloud->size()) {
      cloud->points.push_back(weight * p);
      cloud->normals.push_back(weight * n);
      weights_.push_back(weight);
    } else if (cloud->normals[i].dot(n) > 0) {
      cloud->points[i] += weight * p;
      cloud->normals[i] += weight * n;
      weights_[i] += weight;
    }
  }
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    cloud->points[i] /= weights_[i];
    cloud->normals[i].normalize();
  }
}

}  // namespace loopsift
