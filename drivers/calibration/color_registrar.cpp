// SPDX-License-Identifier: MIT
#include "drivers/calibration/color_registrar.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/simd.hpp"

namespace loopsift {

ColorRegistrar::ColorRegistrar(const PinholeCamera& depth, const LensCalibration& color, double color_radius2,
                               const Se3& T_color_depth, double unit_m)
    : unit_m_(static_cast<float>(unit_m)),
      depth_m_(static_cast<std::size_t>(depth.width)),
      source_(static_cast<std::size_t>(depth.width)) {
  Eigen::Matrix3f inverse_K = Eigen::Matrix3f::Identity();
  inverse_K(0, 0) = 1.0F / depth.fx;
  inverse_K(1, 1) = 1.0F / depth.fy;
  inverse_K(0, 2) = -depth.cx / depth.fx;
  inverse_K(1, 2) = -depth.cy / depth.fy;
  H_color_depth_ = T_color_depth.rotation().cast<float>() * inverse_K;
  RowProjection& p = projection_;
  Eigen::Map<Eigen::Vector3f>(&p.dx) = H_color_depth_.col(0);
  Eigen::Map<Eigen::Vector3f>(&p.tx) = T_color_depth.translation().cast<float>();
  p.radius2 = static_cast<float>(color_radius2);
  p.k1 = static_cast<float>(color.distortion.k1);
  p.k2 = static_cast<float>(color.distortion.k2);
  p.k3 = static_cast<float>(color.distortion.k3);
  p.p1 = static_cast<float>(color.distortion.p1);
  p.p2 = static_cast<float>(color.distortion.p2);
  p.fx = color.camera.fx;
  p.fy = color.camera.fy;
  p.cx = color.camera.cx;
  p.cy = color.camera.cy;
  p.last_column = static_cast<float>(color.camera.width - 1);
  p.last_row = static_cast<float>(color.camera.height - 1);
  if (color.mirrored) {
    p.mirror_scale = -1.0F;
    p.mirror_offset = p.last_column;
  }
  p.stride = color.camera.width;
}

LOOPSIFT_SIMD void ColorRegistrar::project_row(const RowProjection& p, const float* __restrict depth_m,
                                               int count, std::int32_t* __restrict source) {
  for (int i = 0; i < count; ++i) {
    const auto u = static_cast<float>(i);
    const float w = depth_m[i] > 0.0F ? 1.0F / depth_m[i] : 0.0F;
    const float z = std::max(p.z + u * p.dz + p.tz * w, 1e-3F);
    float x = (p.x + u * p.dx + p.tx * w) / z;
    float y = (p.y + u * p.dy + p.ty * w) / z;
    const float wide2 = x * x + y * y;
    const float shrink = wide2 > p.radius2 ? std::sqrt(p.radius2 / wide2) : 1.0F;
    x *= shrink;
    y *= shrink;
    const float r2 = x * x + y * y;
    const float radial = 1.0F + r2 * (p.k1 + r2 * (p.k2 + r2 * p.k3));
    const float xd = x * radial + 2.0F * p.p1 * x * y + p.p2 * (r2 + 2.0F * x * x);
    const float yd = y * radial + p.p1 * (r2 + 2.0F * y * y) + 2.0F * p.p2 * x * y;
    const float column = std::min(std::max(p.fx * xd + p.cx, 0.0F), p.last_column);
    const float row = std::min(std::max(p.fy * yd + p.cy, 0.0F), p.last_row);
    source[i] = static_cast<std::int32_t>(row + 0.5F) * p.stride +
                static_cast<std::int32_t>(p.mirror_scale * column + p.mirror_offset + 0.5F);
  }
}

void ColorRegistrar::fill_depths(const std::uint16_t* depth) {
  float last = 0.0F;
  for (std::size_t u = 0; u < depth_m_.size(); ++u) {
    if (depth[u] != 0 && depth[u] != 65535) last = static_cast<float>(depth[u]) * unit_m_;
    depth_m_[u] = last;
  }
}

void ColorRegistrar::register_color(const ImageView<const std::uint16_t>& depth,
                                    const ImageView<const Rgb8>& color, const ImageView<Rgb8>& out) {
  assert(static_cast<std::size_t>(depth.width) == source_.size() && depth.size() == out.size());
  assert(color.width == projection_.stride && color.stride == color.width);
  for (int v = 0; v < depth.height; ++v) {
    fill_depths(depth.row(v));
    Eigen::Map<Eigen::Vector3f>(&projection_.x) =
        H_color_depth_ * Eigen::Vector3f(0.0F, static_cast<float>(v), 1.0F);
    project_row(projection_, depth_m_.data(), depth.width, source_.data());
    Rgb8* const to = out.row(v);
    for (int u = 0; u < depth.width; ++u) to[u] = color.data[source_[static_cast<std::size_t>(u)]];
  }
}

}  // namespace loopsift
