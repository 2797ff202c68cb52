// SPDX-License-Identifier: MIT
// A real lens as the tables of this folder need it: from a pixel of the ideal image to the pixel that the
// device delivers. Set-up only.
#pragma once
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/camera_calibration.hpp"

namespace loopsift {

/// That a calibration for `camera`'s image size does not fit images of width × height; begins with `what`.
[[nodiscard]] Error other_size(const PinholeCamera& camera, int width, int height, const std::string& what);

/// The lens for images of width × height: of the same shape (scaled), or an error that begins with `what`.
[[nodiscard]] Expected<LensCalibration> fit_lens(const LensCalibration& lens, int width, int height,
                                                 const std::string& what);

/// Where the device's image shows what the ideal one shows at (u, v), in pixels, mirroring included.
[[nodiscard]] Eigen::Vector2d device_pixel(const LensCalibration& lens, double u, double v);

/// The largest x² + y² of normalised ideal coordinates that the image holds. An error that begins with `what`
/// where the distortion folds the image over: such coefficients are wrong.
[[nodiscard]] Expected<double> largest_radius2(const LensCalibration& lens, const std::string& what);

}  // namespace loopsift
