// SPDX-License-Identifier: MIT
// libcamera's pixel formats that we read. Their names give the order of bits in a little-endian word: RGB888
// lies in memory as B, G, R. Never allocates.
#pragma once
#include <libcamera/pixel_format.h>

#include <cstdint>

#include "core/base/span.hpp"
#include "drivers/codec/pixel_rows.hpp"

namespace loopsift {

/// An image in a camera's buffer: one plane, and for NV12 a second with the chroma of each pair of rows.
struct CameraImage {
  const std::uint8_t* plane = nullptr;
  const std::uint8_t* chroma = nullptr;
  std::size_t stride_bytes = 0;  ///< of both
  int width = 0, height = 0;
  YuvRange range = YuvRange::kLimited;
};

struct StreamPixelFormat {
  libcamera::PixelFormat format;
  int bytes_per_pixel;  ///< of the first plane
  int planes;
  void (*row)(const CameraImage& image, int y, Rgb8* out);
};

/// The one to take first, if a camera has several, first.
[[nodiscard]] Span<const StreamPixelFormat> known_stream_formats();
/// Null if we do not read it.
[[nodiscard]] const StreamPixelFormat* find_stream_format(const libcamera::PixelFormat& format);

}  // namespace loopsift
