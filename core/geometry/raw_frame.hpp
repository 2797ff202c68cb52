// SPDX-License-Identifier: MIT
// What a driver hands over: one depth image with its time stamp, and the colour image that belongs to it if
// there is one.
#pragma once
#include <cstdint>

#include "core/base/span.hpp"
#include "core/geometry/image.hpp"

namespace loopsift {

/// Buffers belong to the consumer, sized from SourceInfo before the first frame; a driver decodes straight
/// into them.
struct RawFrame {
  std::int64_t timestamp_ns =
      0;  ///< device time of the depth image, nanoseconds; strictly increasing in a source
  std::int64_t sequence = -1;  ///< the source's own frame number; gaps are frames lost before us
  std::int32_t session =
      0;  ///< how often the source was opened anew before; between two of them nothing was seen
  std::int64_t captured_ns = 0;  ///< steady host clock when the frame arrived, for capture-to-pose latency
  Span<std::uint16_t> depth_buffer;  ///< capacity: depth_camera.width × height
  Span<Rgb8> color_buffer;           ///< capacity: color width × height; empty when colour is not wanted
  ImageView<std::uint16_t> depth;  ///< raw device units; 0 and 65535 are invalid; metres = raw × depth_unit_m
  ImageView<Rgb8> color;           ///< empty() when this frame has no colour
};

}  // namespace loopsift
