// SPDX-License-Identifier: MIT
// Recordings behind the FrameSource interface. In: a folder of images (tum, 7scenes, redwood, sun3d) or a
// .klg file. Out: frames in order of time. A frame whose depth is missing, broken or of another size is kBad
// and reading goes on; one whose colour is broken comes without it, and message() says why.
#pragma once
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "drivers/frame_source.hpp"

namespace loopsift {

/// For messages: what may stand between `replay:` and the path.
inline constexpr const char* kReplayFormats = "tum, 7scenes, redwood, sun3d, klg";

/// Opens a recording and finds out its image sizes. Errors: an unknown format, a missing or empty folder,
/// lists that do not fit together, no usable intrinsics, a depth scale of zero, no image that can be read.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_replay(const std::string& format,
                                                                 const std::string& path,
                                                                 const SourceOptions& options);

}  // namespace loopsift
