// SPDX-License-Identifier: MIT
// A slanted, textured plane seen through two real lenses: what each device would deliver, and what an ideal
// depth camera would.
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/camera_calibration.hpp"
#include "core/geometry/image.hpp"

namespace loopsift::test {

struct DistortedScene {
  CameraCalibration calibration;
  double unit_m = 0.001;

  DistortedScene() {
    calibration.file = "test.toml";
    calibration.depth.camera = {160, 120, 145.0F, 146.0F, 79.0F, 60.5F};
    calibration.depth.distortion.k1 = -0.25;
    calibration.depth.distortion.k2 = 0.08;
    calibration.depth.distortion.p1 = 0.004;
    calibration.color.camera = {200, 150, 165.0F, 165.0F, 101.0F, 73.0F};
    calibration.color.distortion.k1 = 0.18;
    calibration.color.distortion.k2 = -0.3;
    calibration.color.distortion.p2 = -0.003;
    calibration.T_color_depth = Se3(so3_exp({0.01, -0.03, 0.02}), Eigen::Vector3d(-0.025, 0.002, -0.004));
  }

  /// The plane n · p = d of the depth frame, in front of both cameras.
  static constexpr double kD = 1.5;
  static Eigen::Vector3d normal() { return {0.3, -0.2, 0.95}; }
  /// Smooth, so that half a pixel is a few grey levels.
  static double texture(const Eigen::Vector3d& p) {
    return 128 + 60 * std::sin(4 * p.x()) + 50 * std::cos(5 * p.y() + 1);
  }
  /// Where the ray of normalised coordinates n in a camera at T_camera_depth meets the plane, depth frame.
  static Eigen::Vector3d meet(const Eigen::Vector2d& n, const Se3& T_camera_depth) {
    const Se3 T_depth_camera = T_camera_depth.inverse();
    const Eigen::Vector3d direction = T_depth_camera.rotation() * Eigen::Vector3d(n.x(), n.y(), 1);
    const Eigen::Vector3d origin = T_depth_camera.translation();
    return origin + (kD - normal().dot(origin)) / normal().dot(direction) * direction;
  }
  static Eigen::Vector2d normalized(const PinholeCamera& c, double u, double v) {
    return {(u - static_cast<double>(c.cx)) / static_cast<double>(c.fx),
            (v - static_cast<double>(c.cy)) / static_cast<double>(c.fy)};
  }
  /// What the lens looks at through a pixel of the image that it delivers.
  static Eigen::Vector2d looks_at(const LensCalibration& lens, int u, int v) {
    const int column = lens.mirrored ? lens.camera.width - 1 - u : u;
    Eigen::Vector2d ideal(NAN, NAN);
    (void)lens.distortion.undistort(normalized(lens.camera, column, v), &ideal);
    return ideal;
  }

  [[nodiscard]] std::vector<std::uint16_t> device_depth() const {
    const PinholeCamera& c = calibration.depth.camera;
    std::vector<std::uint16_t> image;
    for (int v = 0; v < c.height; ++v)
      for (int u = 0; u < c.width; ++u)
        image.push_back(static_cast<std::uint16_t>(
            std::lround(meet(looks_at(calibration.depth, u, v), {}).z() / unit_m)));
    return image;
  }
  [[nodiscard]] std::vector<Rgb8> device_color(const LensCalibration& lens, const Se3& T_camera_depth) const {
    std::vector<Rgb8> image;
    for (int v = 0; v < lens.camera.height; ++v) {
      for (int u = 0; u < lens.camera.width; ++u) {
        const auto grey =
            static_cast<unsigned char>(std::lround(texture(meet(looks_at(lens, u, v), T_camera_depth))));
        image.push_back({grey, static_cast<unsigned char>(255 - grey), 7});
      }
    }
    return image;
  }
  [[nodiscard]] Eigen::Vector3d ideal_point(int u, int v) const {
    return meet(normalized(calibration.depth.camera, u, v), {});
  }
};

}  // namespace loopsift::test
