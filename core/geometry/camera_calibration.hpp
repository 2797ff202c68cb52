// SPDX-License-Identifier: MIT
// What is known of one sensor: both lenses, how they stand to each other, and how its depth errs. Made by
// load_camera_file (firmware_app/camera_file.hpp), used by drivers/calibration. Plain values.
#pragma once
#include <string>

#include "core/geometry/brown_conrady.hpp"
#include "core/geometry/camera.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift {

struct LensCalibration {
  PinholeCamera camera;  ///< of the image as it is once unmirrored; members that nobody gave are 0
  BrownConrady distortion;
  bool mirrored = false;  ///< the device delivers left and right swapped
};

/// The depth of a device, to what it should have been: z ← (c0 + c1 z + c2 z² + c3 z³) · f(u, v).
struct DepthCorrection {
  double c0_m = 0, c1 = 1, c2_per_m = 0, c3_per_m2 = 0;
  /// 16-bit grey PNG of the depth image's size, in the device's pixels as delivered: 32768 · f. Empty: f = 1.
  std::string factor_file;
  [[nodiscard]] bool is_identity() const {
    return c0_m == 0 && c1 == 1 && c2_per_m == 0 && c3_per_m2 == 0 && factor_file.empty();
  }
  [[nodiscard]] double polynomial(double depth_m) const {
    return c0_m + depth_m * (c1 + depth_m * (c2_per_m + depth_m * c3_per_m2));
  }
};

struct CameraCalibration {
  std::string file;  ///< where this comes from, for messages; empty: nothing was given
  LensCalibration depth;
  double depth_scale = 0;  ///< raw units per metre; 0: as the source has it
  DepthCorrection correction;
  /// Of the colour camera. Without intrinsics the colour image is aligned: it shows, pixel for pixel and
  /// through the same lens, what the depth image shows (devices that register by themselves).
  LensCalibration color;
  Se3 T_color_depth;
  [[nodiscard]] bool color_is_aligned() const { return color.camera.fx == 0; }
};

}  // namespace loopsift
