// SPDX-License-Identifier: MIT
// Which of a device's image formats to use. Set-up only; allocates.
#pragma once
#include <openni2/OpenNI.h>

#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/openni2/openni2_options.hpp"

namespace loopsift::openni2 {

/// "640x480 30 Hz, 1 mm".
[[nodiscard]] std::string to_text(const openni::VideoMode& mode);
/// Of a sensor that a device has; each once.
[[nodiscard]] std::vector<std::string> mode_texts(const openni::SensorInfo& sensor);

/// Metres per raw unit; 0 for a format that is no depth in a fixed unit.
[[nodiscard]] double depth_unit_m(openni::PixelFormat format);
/// Whether copy_color() reads it.
[[nodiscard]] bool is_color(openni::PixelFormat format);

/// The depth mode of this size, rate and unit. An Error of kUnsupported lists what there is.
[[nodiscard]] Expected<openni::VideoMode> choose_depth_mode(const openni::SensorInfo& sensor, int width,
                                                            int height, const OpenNi2Options& options);
/// A colour mode of this rate: of the same size if there is one, else of the nearest; RGB before grey.
[[nodiscard]] Expected<openni::VideoMode> choose_color_mode(const openni::SensorInfo& sensor, int width,
                                                            int height, const OpenNi2Options& options);

}  // namespace loopsift::openni2
