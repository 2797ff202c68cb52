// SPDX-License-Identifier: MIT
#include "drivers/calibration/lens.hpp"

#include <algorithm>
#include <cstdint>

namespace loopsift {
namespace {

Eigen::Array2d focal(const PinholeCamera& c) {
  return {static_cast<double>(c.fx), static_cast<double>(c.fy)};
}

Eigen::Array2d center(const PinholeCamera& c) {
  return {static_cast<double>(c.cx), static_cast<double>(c.cy)};
}

/// Pixel to normalised coordinates.
Eigen::Vector2d normalized(const PinholeCamera& c, double u, double v) {
  return (Eigen::Array2d(u, v) - center(c)) / focal(c);
}

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace

Error other_size(const PinholeCamera& camera, int width, int height, const std::string& what) {
  return {ErrorCode::kFormat, what + " is for images of " + size_text(camera.width, camera.height) +
                                  ", but the device gives " + size_text(width, height) +
                                  ": choose that mode, or give a calibration of this one"};
}

Expected<LensCalibration> fit_lens(const LensCalibration& lens, int width, int height,
                                   const std::string& what) {
  const PinholeCamera& from = lens.camera;
  if (from.width <= 0 || std::int64_t{from.width} * height != std::int64_t{from.height} * width) {
    return other_size(from, width, height, what);
  }
  const float scale = static_cast<float>(width) / static_cast<float>(from.width);
  LensCalibration fitted = lens;
  // Pixel centres are at integers, so the image's corner is at (−0.5, −0.5).
  fitted.camera = {width,
                   height,
                   from.fx * scale,
                   from.fy * scale,
                   (from.cx + 0.5F) * scale - 0.5F,
                   (from.cy + 0.5F) * scale - 0.5F};
  return fitted;
}

Eigen::Vector2d device_pixel(const LensCalibration& lens, double u, double v) {
  const PinholeCamera& c = lens.camera;
  Eigen::Vector2d at(u, v);
  if (!lens.distortion.is_identity()) {
    at = lens.distortion.distort(normalized(c, u, v)).array() * focal(c) + center(c);
  }
  if (lens.mirrored) at.x() = c.width - 1 - at.x();
  return at;
}

Expected<double> largest_radius2(const LensCalibration& lens, const std::string& what) {
  const PinholeCamera& c = lens.camera;
  double largest = 0;
  constexpr int kSteps = 8;  // along each side
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const double u = i * (c.width - 1.0) / kSteps, v = j * (c.height - 1.0) / kSteps;
      Eigen::Vector2d ideal;
      if (!lens.distortion.undistort(normalized(c, u, v), &ideal) ||
          !(lens.distortion.jacobian(ideal).determinant() > 0)) {
        return Error{ErrorCode::kFormat, what + ": the distortion folds the image over at pixel " +
                                             std::to_string(static_cast<int>(u)) + ", " +
                                             std::to_string(static_cast<int>(v)) +
                                             "; check k1 k2 p1 p2 k3, their order and signs"};
      }
      largest = std::max(largest, ideal.squaredNorm());
    }
  }
  return largest;
}

}  // namespace loopsift
