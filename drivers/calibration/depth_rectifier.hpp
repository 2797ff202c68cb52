// SPDX-License-Identifier: MIT
// Depth images without distortion, mirroring and systematic error. In: what the device delivers. Out: what an
// ideal camera with the same intrinsics would have delivered, by the nearest device pixel (depths of two
// surfaces are never mixed). Tables are made in the constructor (6 bytes per pixel and 128 KiB, 2 bytes per
// pixel more with factors); one pass per image. Allocates in the constructor only. Any one thread.
#pragma once
#include <cstdint>
#include <vector>

#include "core/geometry/camera_calibration.hpp"
#include "core/geometry/image.hpp"

namespace loopsift {

class DepthRectifier {
 public:
  /// lens: fitted to the image (lens.hpp). factors: as DepthCorrection::factor_file, one per device pixel, or
  /// empty.
  DepthRectifier(const LensCalibration& lens, const DepthCorrection& correction, double unit_m,
                 const std::vector<std::uint16_t>& factors);

  /// Whether rectify() would change nothing: then there are no tables, and it must not be called.
  [[nodiscard]] bool is_identity() const { return source_.empty(); }
  /// Both of the lens's size, not overlapping. What the device does not show, has no depth, or is corrected
  /// to less than 0 or more than fits becomes 0.
  void rectify(const ImageView<const std::uint16_t>& device, const ImageView<std::uint16_t>& out) const;

 private:
  void map_pixels(const LensCalibration& lens);
  void map_depths(const DepthCorrection& correction, double unit_m);

  std::vector<std::int32_t> source_;      // device pixel of each pixel; −1: none
  std::vector<std::uint16_t> corrected_;  // of each raw depth
  std::vector<std::uint16_t> factors_;    // of each pixel, or empty
};

}  // namespace loopsift
