// SPDX-License-Identifier: MIT
// Scenes of planes and spheres, ray-cast exactly: depth images whose truth is known.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "core/geometry/camera.hpp"
#include "core/geometry/raw_frame.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift::test {

struct Plane {
  Eigen::Vector3d normal;  // unit; n · p = offset
  double offset;
};

struct Sphere {
  Eigen::Vector3d center;
  double radius;
};

struct AnalyticScene {
  std::vector<Plane> planes;
  std::vector<Sphere> spheres;

  // A 4.2 × 2.5 × 5 m room, y down, with two spheres in it; from the origin wall, floor, side and spheres are
  // in sight.
  static AnalyticScene room() {
    using V = Eigen::Vector3d;
    return {{{V(1, 0, 0), -1.2},
             {V(-1, 0, 0), -3.0},
             {V(0, -1, 0), -0.7},
             {V(0, 1, 0), -1.8},
             {V(0, 0, -1), -2.6},
             {V(0, 0, 1), -2.4}},
            {{V(0.5, 0.4, 1.9), 0.45}, {V(-0.8, -0.2, 2.1), 0.35}}};
  }
  static AnalyticScene wall() { return {{{Eigen::Vector3d(0, 0, -1), -2.0}}, {}}; }

  // Distance along a ray to the nearest surface before it; infinity where there is none.
  [[nodiscard]] double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Plane& plane : planes) {
      const double along = plane.normal.dot(direction);
      if (along >= 0) continue;  // seen from behind
      const double t = (plane.offset - plane.normal.dot(origin)) / along;
      if (t > 0) nearest = std::min(nearest, t);
    }
    for (const Sphere& sphere : spheres) {
      const Eigen::Vector3d o = origin - sphere.center;
      const double a = direction.squaredNorm(), b = o.dot(direction);
      const double discriminant = b * b - a * (o.squaredNorm() - sphere.radius * sphere.radius);
      if (discriminant < 0) continue;
      const double t = (-b - std::sqrt(discriminant)) / a;
      if (t > 0) nearest = std::min(nearest, t);
    }
    return nearest;
  }

  // Distance from a point to the nearest surface.
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Plane& plane : planes)
      nearest = std::min(nearest, std::fabs(plane.normal.dot(p) - plane.offset));
    for (const Sphere& s : spheres) nearest = std::min(nearest, std::fabs((p - s.center).norm() - s.radius));
    return nearest;
  }
};

// A depth camera in a scene; owns the image that raw() views.
class SceneCamera {
 public:
  static constexpr double kUnitM = 0.0001;  // raw units of 0.1 mm: quantisation stays below what is tested

  SceneCamera(const PinholeCamera& camera, std::uint32_t seed)
      : camera_(camera),
        depth_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)),
        random_(seed) {}

  // white noise per pixel: sigma = floor + slope (z − 0.4)²
  RawFrame capture(const AnalyticScene& scene, const Se3& T_world_camera, double floor_m = 0,
                   double slope = 0) {
    std::normal_distribution<double> normal;
    for (int v = 0; v < camera_.height; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        const Eigen::Vector3d ray =
            camera_.unproject(static_cast<float>(u), static_cast<float>(v), 1.0F).cast<double>();
        double z = scene.cast(T_world_camera.translation(), T_world_camera.rotation() * ray);
        z += (floor_m + slope * (z - 0.4) * (z - 0.4)) * (floor_m > 0 ? normal(random_) : 0.0);
        const bool valid = z > 0.05 && z < 6.0;
        depth_[static_cast<std::size_t>(v * camera_.width + u)] =
            valid ? static_cast<std::uint16_t>(std::lround(z / kUnitM)) : std::uint16_t{0};
      }
    }
    return next();
  }
  // The same with colour: grey values of a pattern that fills space, so that every surface has it; times
  // gain.
  RawFrame capture_color(const AnalyticScene& scene, const Se3& T_world_camera, double floor_m = 0,
                         double slope = 0, double gain = 1) {
    RawFrame raw = capture(scene, T_world_camera, floor_m, slope);
    color_.resize(depth_.size());
    for (int v = 0; v < camera_.height; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        const Eigen::Vector3d ray =
            camera_.unproject(static_cast<float>(u), static_cast<float>(v), 1.0F).cast<double>();
        const Eigen::Vector3d direction = T_world_camera.rotation() * ray;
        const Eigen::Vector3d p =
            T_world_camera.translation() + scene.cast(T_world_camera.translation(), direction) * direction;
        const auto grey = static_cast<unsigned char>(std::clamp(gain * pattern(p), 0.0, 255.0));
        color_[static_cast<std::size_t>(v * camera_.width + u)] = {grey, grey, grey};
      }
    }
    raw.color = {color_.data(), camera_.width, camera_.height};
    return raw;
  }
  static double pattern(const Eigen::Vector3d& p) {
    return 110 + 30 * std::sin(7 * p.x() + 2 * p.y()) + 25 * std::sin(9 * p.y() - 3 * p.z()) +
           25 * std::sin(8 * p.z() + 3 * p.x());
  }
  // A covered lens.
  RawFrame black() {
    std::fill(depth_.begin(), depth_.end(), std::uint16_t{0});
    return next();
  }
  std::vector<std::uint16_t>& pixels() { return depth_; }

 private:
  RawFrame next() {
    RawFrame raw;
    raw.timestamp_ns = (++sequence_) * 33333333;
    raw.sequence = sequence_;
    raw.depth = {depth_.data(), camera_.width, camera_.height};
    return raw;
  }

  PinholeCamera camera_;
  std::vector<std::uint16_t> depth_;
  std::vector<Rgb8> color_;
  std::mt19937 random_;
  std::int64_t sequence_ = -1;
};

inline PinholeCamera small_camera() { return {320, 240, 290, 290, 159.5F, 119.5F}; }

// A pose moved by (x, y, z) and turned about the y axis.
inline Se3 shifted(double x, double y, double z, double yaw = 0) {
  return {so3_exp(Eigen::Vector3d(0, yaw, 0)), Eigen::Vector3d(x, y, z)};
}

}  // namespace loopsift::test
