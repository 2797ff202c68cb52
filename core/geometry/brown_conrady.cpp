// SPDX-License-Identifier: MIT
#include "core/geometry/brown_conrady.hpp"

#include <Eigen/LU>

namespace loopsift {

Eigen::Vector2d BrownConrady::distort(const Eigen::Vector2d& ideal) const {
  const double x = ideal.x(), y = ideal.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

Eigen::Matrix2d BrownConrady::jacobian(const Eigen::Vector2d& ideal) const {
  const double x = ideal.x(), y = ideal.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));  // d radial / d(r²), times 2
  const double mixed = x * y * slope + 2 * p1 * x + 2 * p2 * y;
  Eigen::Matrix2d J;
  J << radial + x * x * slope + 2 * p1 * y + 6 * p2 * x, mixed, mixed,
      radial + y * y * slope + 6 * p1 * y + 2 * p2 * x;
  return J;
}

bool BrownConrady::undistort(const Eigen::Vector2d& real, Eigen::Vector2d* ideal) const {
  constexpr int kIterations = 20;
  constexpr double kEnough = 1e-10;
  *ideal = real;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector2d error = real - distort(*ideal);
    if (error.squaredNorm() < kEnough * kEnough) return true;
    const Eigen::Matrix2d J = jacobian(*ideal);
    if (!(J.determinant() > 0)) return false;
    *ideal += J.inverse() * error;
  }
  return false;
}

}  // namespace loopsift
