// SPDX-License-Identifier: MIT
// Lens distortion after Brown (Close-Range Camera Calibration, Photogrammetric Engineering 37, 1971) and
// Conrady (1919), in the form and with the names that OpenCV and ROS use for five coefficients. Maps
// normalised image coordinates (x/z, y/z) of an ideal pinhole camera to those of the real one. Never
// allocates.
#pragma once
#include <Eigen/Core>

namespace loopsift {

struct BrownConrady {
  double k1 = 0, k2 = 0, k3 = 0;  ///< radial: r², r⁴, r⁶
  double p1 = 0, p2 = 0;          ///< tangential

  [[nodiscard]] bool is_identity() const { return k1 == 0 && k2 == 0 && k3 == 0 && p1 == 0 && p2 == 0; }

  /// x′ = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 xy + p2 (r² + 2x²), y′ likewise with p1 (r² + 2y²) + 2 p2 xy.
  [[nodiscard]] Eigen::Vector2d distort(const Eigen::Vector2d& ideal) const;
  /// ∂(x′, y′) / ∂(x, y).
  [[nodiscard]] Eigen::Matrix2d jacobian(const Eigen::Vector2d& ideal) const;
  /// The inverse of distort, by Newton's method from `real` itself. False where it finds none: the model
  /// folds over, or `real` lies outside of what it reaches.
  [[nodiscard]] bool undistort(const Eigen::Vector2d& real, Eigen::Vector2d* ideal) const;
};

}  // namespace loopsift
