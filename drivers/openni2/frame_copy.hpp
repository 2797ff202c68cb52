// SPDX-License-Identifier: MIT
// The one copy of a frame: from OpenNI2's buffer to ours, rows unpadded and, where the device mirrors its
// images, turned round. Never allocates.
#pragma once
#include <openni2/OpenNI.h>

#include "core/geometry/image.hpp"
#include "core/geometry/raw_frame.hpp"

namespace loopsift::openni2 {

/// False when the frame is not of the target's size and format (depth: 16 bits; colour: RGB or grey, 8 bits);
/// the target is then undefined.
[[nodiscard]] bool copy_depth(const openni::VideoFrameRef& from, bool mirrored,
                              const ImageView<std::uint16_t>& to);
[[nodiscard]] bool copy_color(const openni::VideoFrameRef& from, bool mirrored, const ImageView<Rgb8>& to);

}  // namespace loopsift::openni2
