// SPDX-License-Identifier: MIT
// bot_core.images_t read where it lies: bytes from anyone in, views of its images out. Any thread; never
// allocates, copies or trusts a length.
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/base/span.hpp"

namespace loopsift {

/// One image of the message; `data` is empty where there is none.
struct EncodedImage {
  int width = 0, height = 0;  ///< pixels, 1 … 8192
  int row_stride = 0;         ///< bytes; as sent, nothing is known of it
  std::int32_t format = 0;    ///< bot_core.image_t's PIXEL_FORMAT_*
  Span<const std::uint8_t> data;
};

/// The images that are of use: the first of each kind.
struct ImagesMessage {
  std::int64_t utime_us = 0;
  EncodedImage depth;         ///< DEPTH_MM or DEPTH_MM_ZIPPED
  bool depth_zipped = false;  ///< by zlib
  EncodedImage color;         ///< LEFT
};

/// Views into `bytes`. Null, or what is wrong (static text): another type, cut, lengths that do not fit, no
/// depth image.
[[nodiscard]] const char* parse_images(Span<const std::uint8_t> bytes, ImagesMessage* message);

}  // namespace loopsift
