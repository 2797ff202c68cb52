// SPDX-License-Identifier: MIT
// A device's controls (exposure, gain, laser power…) set from text. Set-up only; allocates.
#pragma once
#include <string>
#include <vector>

#include "drivers/v4l2/video_device.hpp"

namespace loopsift {

/// Sets each `name=value` in order; the name is the control's as `v4l2-ctl --list-ctrls` prints it, or its
/// number. Errors name the assignment: malformed, no such control (and which there are), out of range, not
/// to be set now.
[[nodiscard]] Status set_controls(const VideoDevice& device, const std::vector<std::string>& assignments);

}  // namespace loopsift
