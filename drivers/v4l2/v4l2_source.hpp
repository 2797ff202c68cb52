// SPDX-License-Identifier: MIT
// Depth and colour cameras through the kernel's V4L2, mapped buffers, one node and one kind of image per
// source. In: a device node. Out: RawFrames with depth alone (Z16 and 10 to 16 bit grey formats) or colour
// alone (YUYV, RGB, BGR, grey, MJPEG), each unpacked from the device's buffer straight into the frame's.
// Time stamps: the driver's, on CLOCK_MONOTONIC (see LiveClock). Frames that the device dropped are gaps in
// `sequence`. V4L2 knows no intrinsics and no depth unit: the camera comes from the options, the unit is a
// millimetre unless they say otherwise.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/list_devices.hpp"
#include "drivers/v4l2/video_system.hpp"

namespace loopsift {

/// `device`: a node, and options of its own after a question mark: "/dev/video2?format=YUYV&rate_hz=15". What
/// it does not name is taken from options.v4l2. Errors name the device: not there, no permission, busy, no
/// capture device, a format, size or control that it does not have or silently answers with another one, no
/// intrinsics for depth.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_v4l2(const std::string& device,
                                                               const SourceOptions& options);
/// The same through given system calls, which must outlive the source.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_v4l2(VideoSystem& system, const std::string& device,
                                                               const SourceOptions& options);

/// The nodes /dev/video0 … 63 that capture images, those among their formats that are read, with the sizes.
[[nodiscard]] std::vector<DeviceInfo> list_v4l2_devices();
[[nodiscard]] std::vector<DeviceInfo> list_v4l2_devices(VideoSystem& system);

}  // namespace loopsift
