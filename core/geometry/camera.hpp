// SPDX-License-Identifier: MIT
// Projection models. A model maps a point of the camera frame (x right, y down, z forward) to a pixel and
// back; code that renders or tracks is written against these four members, so that a spherical model (LiDAR
// range images) stands beside the pinhole. Pixel centres are at integer coordinates. Never allocates.
#pragma once
#include <Eigen/Core>
#include <cmath>

namespace loopsift {

/// z-depth camera without distortion. width, height in pixels; fx, fy, cx, cy in pixels.
struct PinholeCamera {
  int width = 0;
  int height = 0;
  float fx = 0, fy = 0, cx = 0, cy = 0;

  /// The depth that this model stores for a point: z.
  [[nodiscard]] float depth(const Eigen::Vector3f& p_camera) const { return p_camera.z(); }
  /// False where the point is not in front of the camera; the pixel may lie outside the image.
  [[nodiscard]] bool project(const Eigen::Vector3f& p_camera, float* u, float* v) const {
    if (!(p_camera.z() > 1e-6F)) return false;
    const float inverse_z = 1.0F / p_camera.z();
    *u = fx * p_camera.x() * inverse_z + cx;
    *v = fy * p_camera.y() * inverse_z + cy;
    return true;
  }
  /// The point at the given depth behind pixel (u, v).
  [[nodiscard]] Eigen::Vector3f unproject(float u, float v, float depth_m) const {
    return {(u - cx) / fx * depth_m, (v - cy) / fy * depth_m, depth_m};
  }
  [[nodiscard]] bool contains(float u, float v) const {
    return u >= -0.5F && v >= -0.5F && u < static_cast<float>(width) - 0.5F &&
           v < static_cast<float>(height) - 0.5F;
  }
  [[nodiscard]] bool is_valid() const {
    return width > 0 && height > 0 && fx > 0 && fy > 0 && std::isfinite(fx) && std::isfinite(fy) &&
           std::isfinite(cx) && std::isfinite(cy);
  }
  /// The camera of an image that keeps every `step`-th pixel, starting at `offset` in both directions: the
  /// principal point shifts by the sampling offset.
  [[nodiscard]] PinholeCamera subsampled(int step, int offset) const {
    const auto s = static_cast<float>(step), o = static_cast<float>(offset);
    return {(width - offset + step - 1) / step,
            (height - offset + step - 1) / step,
            fx / s,
            fy / s,
            (cx - o) / s,
            (cy - o) / s};
  }
  /// The camera of an image whose pixels are the means of step × step blocks.
  [[nodiscard]] PinholeCamera block_averaged(int step) const {
    const auto s = static_cast<float>(step);
    const float o = 0.5F * (s - 1.0F);
    return {width / step, height / step, fx / s, fy / s, (cx - o) / s, (cy - o) / s};
  }
};

/// Range-image model: columns are azimuth, rows elevation (radians per pixel), depth is the distance from the
/// centre.
struct SphericalCamera {
  int width = 0;
  int height = 0;
  float azimuth_left = 0;         ///< azimuth of column 0, positive to the right of the z axis
  float azimuth_per_pixel = 0;    ///< radians
  float elevation_top = 0;        ///< elevation of row 0, positive downward
  float elevation_per_pixel = 0;  ///< radians

  [[nodiscard]] float depth(const Eigen::Vector3f& p_camera) const { return p_camera.norm(); }
  [[nodiscard]] bool project(const Eigen::Vector3f& p_camera, float* u, float* v) const {
    const float range = p_camera.norm();
    if (!(range > 1e-6F)) return false;
    *u = (std::atan2(p_camera.x(), p_camera.z()) - azimuth_left) / azimuth_per_pixel;
    *v = (std::asin(p_camera.y() / range) - elevation_top) / elevation_per_pixel;
    return true;
  }
  [[nodiscard]] Eigen::Vector3f unproject(float u, float v, float depth_m) const {
    const float azimuth = azimuth_left + u * azimuth_per_pixel,
                elevation = elevation_top + v * elevation_per_pixel;
    return depth_m * Eigen::Vector3f(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                                     std::cos(elevation) * std::cos(azimuth));
  }
  [[nodiscard]] bool contains(float u, float v) const {
    return u >= -0.5F && v >= -0.5F && u < static_cast<float>(width) - 0.5F &&
           v < static_cast<float>(height) - 0.5F;
  }
};

}  // namespace loopsift
