// SPDX-License-Identifier: MIT
// Cameras of the Kinect and Xtion kind through OpenNI2, and its recordings (.oni). In: a device or a file.
// Out: depth, with the colour image taken within half a frame of it. Thread: one reader; OpenNI2 receives
// on threads of its own. Open allocates; read does not, but for
// OpenNI2 itself, which takes a node of a list from the heap for each image that it gets back.
// docs/drivers.md.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/list_devices.hpp"

namespace loopsift {

/// `address`: empty for the first device, a path that ends in .oni, or a device's own URI as OpenNI2 lists
/// it. A device's time stamps are mapped to CLOCK_MONOTONIC (or not: OpenNi2Options::host_time), a
/// recording's are taken as they are. Errors: no such device or file (kNotFound), a device in use or without
/// the rights for it (kIo), a file that is no recording or not a whole one (kFormat), a mode that the device
/// has not (kUnsupported, naming those that it has), no intrinsics (kFormat).
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_openni2(const std::string& address,
                                                                  const SourceOptions& options);

/// The devices that are connected, with their modes.
[[nodiscard]] std::vector<DeviceInfo> list_openni2_devices();

}  // namespace loopsift
