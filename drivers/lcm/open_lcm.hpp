// SPDX-License-Identifier: MIT
// Opens `lcm:CHANNEL`; drivers/lcm/lcm_source.hpp says what it is.
#pragma once
#include <memory>
#include <string>

#include "drivers/frame_source.hpp"

namespace loopsift {

/// Waits for the first message, which says the images' sizes. Errors: LCM cannot be opened; nothing, or
/// nothing of use, comes within LcmInOptions::open_timeout_s.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_lcm(const std::string& channel,
                                                              const SourceOptions& options);

}  // namespace loopsift
