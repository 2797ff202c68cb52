// SPDX-License-Identifier: MIT
// A small furnished corner, sampled as surfels: nothing in it is symmetric, so that a registration has one
// answer.
#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "core/fragment/fragment.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift::test {

/// Owns surfels.
struct SurfelCloud {
  std::vector<float> x, y, z, nx, ny, nz, radius, weight;
  std::vector<std::uint32_t> rgb;
  std::vector<std::uint16_t> first_frame, last_frame;

  void add(const Eigen::Vector3d& p, const Eigen::Vector3d& n, float w = 1.0F) {
    x.push_back(static_cast<float>(p.x()));
    y.push_back(static_cast<float>(p.y()));
    z.push_back(static_cast<float>(p.z()));
    nx.push_back(static_cast<float>(n.x()));
    ny.push_back(static_cast<float>(n.y()));
    nz.push_back(static_cast<float>(n.z()));
    radius.push_back(0.02F);
    weight.push_back(w);
    rgb.push_back(0);
    first_frame.push_back(0);
    last_frame.push_back(0);
  }
  [[nodiscard]] SurfelSpan span() {
    SurfelSpan s;
    s.x = x, s.y = y, s.z = z, s.nx = nx, s.ny = ny, s.nz = nz;
    s.radius = radius, s.weight = weight, s.rgb = rgb;
    s.first_frame = first_frame, s.last_frame = last_frame;
    return s;
  }
  [[nodiscard]] std::size_t size() const { return x.size(); }
};

using Keep = std::function<bool(const Eigen::Vector3d&)>;

/// Adds surfels in a camera's frame, T_camera_world given, where `keep` holds of the world point.
class SurfaceSampler {
 public:
  SurfaceSampler(const Se3& T_camera_world, Keep keep, SurfelCloud* out)
      : T_(T_camera_world), keep_(std::move(keep)), out_(out) {}

  /// The parallelogram corner + s a + t b, s, t ∈ [0, 1]; the normal is a × b.
  void patch(const Eigen::Vector3d& corner, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const int na = static_cast<int>(a.norm() / kSpacing), nb = static_cast<int>(b.norm() / kSpacing);
    for (int i = 0; i <= na; ++i)
      for (int j = 0; j <= nb; ++j) put(corner + a * i / na + b * j / nb, a.cross(b).normalized());
  }
  /// A box with its lowest corner given, turned by yaw about z; the bottom is left out.
  void box(const Eigen::Vector3d& corner, const Eigen::Vector3d& size, double yaw) {
    const Eigen::Matrix3d R = so3_exp({0, 0, yaw});
    const Eigen::Vector3d ex = R.col(0) * size.x(), ey = R.col(1) * size.y(), ez = R.col(2) * size.z();
    patch(corner + ez, ex, ey);
    patch(corner, ex, ez);
    patch(corner + ey, ez, ex);
    patch(corner, ez, ey);
    patch(corner + ex, ey, ez);
  }
  void sphere(const Eigen::Vector3d& centre, double radius) {
    const int rings = static_cast<int>(3.14159 * radius / kSpacing);
    for (int i = 0; i <= rings; ++i) {
      const double theta = 3.14159265 * i / rings;
      const int steps = 1 + static_cast<int>(6.2832 * radius * std::sin(theta) / kSpacing);
      for (int k = 0; k < steps; ++k) {
        const double phi = 6.2831853 * k / steps;
        const Eigen::Vector3d n(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                                std::cos(theta));
        put(centre + radius * n, n);
      }
    }
  }

 private:
  static constexpr double kSpacing = 0.025;
  void put(const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    if (keep_(p)) out_->add(T_ * p, T_.rotation() * n);
  }
  Se3 T_;
  Keep keep_;
  SurfelCloud* out_;
};

/// The corner of a room with furniture, seen from T_world_camera; `keep` cuts out what a fragment saw.
inline SurfelCloud furnished_corner(
    const Se3& T_world_camera, const Keep& keep = [](const Eigen::Vector3d&) { return true; }) {
  SurfelCloud cloud;
  SurfaceSampler sample(T_world_camera.inverse(), keep, &cloud);
  sample.patch({0, 0, 0}, {3, 0, 0}, {0, 2.4, 0});
  sample.patch({0, 0, 0}, {0, 0, 1.4}, {3, 0, 0});
  sample.patch({0, 0, 0}, {0, 2.4, 0}, {0, 0, 1.4});
  sample.box({0.4, 0.3, 0}, {0.5, 0.35, 0.6}, 0.3);
  sample.box({1.5, 0.5, 0}, {0.3, 0.7, 0.35}, -0.5);
  sample.box({2.2, 1.4, 0}, {0.6, 0.4, 0.8}, 0.9);
  sample.box({0.5, 1.5, 0}, {0.25, 0.25, 1.0}, 0.2);
  sample.sphere({1.2, 1.6, 0.3}, 0.3);
  sample.sphere({2.3, 0.5, 0.2}, 0.2);
  sample.sphere({1.1, 0.15, 0.9}, 0.15);
  return cloud;
}

/// One horizontal plane.
inline SurfelCloud flat_floor() {
  SurfelCloud cloud;
  SurfaceSampler sample(
      Se3(), [](const Eigen::Vector3d&) { return true; }, &cloud);
  sample.patch({0, 0, 0}, {3, 0, 0}, {0, 2.5, 0});
  return cloud;
}

inline Se3 motion(double tx, double ty, double tz, double wx, double wy, double wz) {
  Vector6d xi;
  xi << tx, ty, tz, wx, wy, wz;
  return Se3::exp(xi);
}

}  // namespace loopsift::test
