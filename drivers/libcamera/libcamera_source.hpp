// SPDX-License-Identifier: MIT
// Colour cameras through libcamera, among them those on MIPI ports that give no usable image through V4L2
// alone. In: a camera. Out: RawFrames with colour alone, converted straight from the camera's buffer. Time
// stamps: the camera's, on CLOCK_MONOTONIC (see LiveClock). Frames that the camera dropped are gaps in
// `sequence`. After open no call allocates on the reader's thread; libcamera's own threads do.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/list_devices.hpp"

namespace loopsift {

/// `camera`: an index into libcamera's list ("0"), or a camera's id. Errors name the camera: not there, in
/// use, a format that it has not.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_libcamera(const std::string& camera,
                                                                    const SourceOptions& options);

/// Every camera that libcamera sees, with those of its formats that are read.
[[nodiscard]] std::vector<DeviceInfo> list_libcamera_devices();

}  // namespace loopsift
