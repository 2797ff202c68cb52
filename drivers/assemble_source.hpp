// SPDX-License-Identifier: MIT
// What open_source puts around a driver: the colour of another source, and the calibration of the sensor.
// Set-up only: allocates.
#pragma once
#include <memory>

#include "drivers/frame_source.hpp"

namespace loopsift {

/// The options for the driver of the depth image: intrinsics and depth scale that nobody set are the
/// calibration's.
[[nodiscard]] SourceOptions depth_options(const SourceOptions& options);
/// The options for the driver of camera.color_source: the colour camera's image size, no depth.
[[nodiscard]] SourceOptions color_options(const SourceOptions& options);

/// Reads the correction's factors where there are some, and applies the calibration. Errors as of
/// CalibratedSource::create; a factor file that cannot be read.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> calibrate(std::unique_ptr<FrameSource> source,
                                                               const CameraCalibration& calibration);

}  // namespace loopsift
