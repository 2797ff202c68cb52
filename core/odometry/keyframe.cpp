// SPDX-License-Identifier: MIT
#include "core/odometry/keyframe.hpp"

#include <algorithm>

namespace loopsift {

Keyframe::Keyframe(const PinholeCamera& working, int levels, Arena& arena) {
  PinholeCamera camera = working;
  for (std::size_t l = 0; l < static_cast<std::size_t>(levels); ++l) {
    const int w = camera.width, h = camera.height;
    const auto pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    Storage& s = storage_[l];
    s.depth = arena.carve<float>("odometry/keyframe", pixels);
    s.intensity = arena.carve<float>("odometry/keyframe", pixels);
    if (l == 0)
      for (Span<float>& normal : normals_) normal = arena.carve<float>("odometry/keyframe", pixels);
    levels_[l] = {camera, {s.depth.data(), w, h}, {s.intensity.data(), w, h}};
    camera = camera.block_averaged(2);
  }
}

void Keyframe::keep(const Frame& frame, const Se3& T_odom_key) {
  T_odom_key_ = T_odom_key;
  level_count_ = frame.level_count;
  valid_ = 0;
  has_intensity_ = !frame.levels[0].intensity.empty();
  disparity_coefficients_ = frame.disparity_coefficients;
  const FrameLevel& finest = frame.levels[0];
  std::copy_n(finest.nx.data, finest.nx.size(), normals_[0].data());
  std::copy_n(finest.ny.data, finest.ny.size(), normals_[1].data());
  std::copy_n(finest.nz.data, finest.nz.size(), normals_[2].data());
  for (std::size_t l = 0; l < static_cast<std::size_t>(level_count_); ++l) {
    const FrameLevel& from = frame.levels[l];
    const Storage& to = storage_[l];
    if (has_intensity_) std::copy_n(from.intensity.data, from.intensity.size(), to.intensity.data());
    for (std::size_t k = 0; k < to.depth.size(); ++k) {
      const bool smooth = from.nz.data[k] != 0.0F;  // a normal toward the camera has nz < 0
      to.depth[k] = smooth ? from.depth_m.data[k] : 0.0F;
      if (l == 0 && to.depth[k] > 0.0F) ++valid_;
    }
  }
}

}  // namespace loopsift
