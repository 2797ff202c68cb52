// SPDX-License-Identifier: MIT
// The pixel formats that we read, and how a row of each becomes depth or colour. Names and layouts: the
// kernel's "Image Formats" (Documentation/userspace-api/media/v4l/pixfmt.rst). Never allocates but for names.
#pragma once
#include <cstdint>
#include <string>

#include "core/base/span.hpp"
#include "drivers/codec/pixel_rows.hpp"

namespace loopsift {

/// Exactly one of the row functions is set, none for MJPEG.
struct PixelFormat {
  std::uint32_t code;  ///< the kernel's V4L2_PIX_FMT_…
  bool is_depth;
  int group_pixels, group_bytes;  ///< the smallest piece that a row is made of; 0: compressed
  void (*depth_row)(const std::uint8_t* row, int width, std::uint16_t* out);
  void (*color_row)(const std::uint8_t* row, int width, YuvRange range, Rgb8* out);

  [[nodiscard]] bool compressed() const { return group_bytes == 0; }
  /// What a row of `width` pixels takes at least.
  [[nodiscard]] std::size_t row_bytes(int width) const {
    return compressed() ? 0
                        : static_cast<std::size_t>((width + group_pixels - 1) / group_pixels * group_bytes);
  }
};

/// All of them, the one to take first when a device has several first.
[[nodiscard]] Span<const PixelFormat> known_pixel_formats();
/// Null if we do not read it.
[[nodiscard]] const PixelFormat* find_pixel_format(std::uint32_t code);
/// "YUYV"; without the spaces at the end; "Y16-BE" for the big-endian form, as v4l2-ctl prints it.
[[nodiscard]] std::string fourcc_name(std::uint32_t code);

}  // namespace loopsift
