// SPDX-License-Identifier: MIT
// Rows of uncompressed camera formats to interleaved RGB. In: one row as the device stores it, of the length
// that each function says. Out: `width` pixels. Any thread; never allocates. YCbCr follows ITU-R BT.601,
// which cameras of standard definition use; the integer coefficients are its own, in 1/256.
#pragma once
#include <cstdint>

#include "core/geometry/image.hpp"

namespace loopsift {

/// What luma and chroma span: 16…235 and 16…240, or 0…255 as in JPEG.
enum class YuvRange { kLimited, kFull };

/// Y0 Cb Y1 Cr for two pixels: 4 bytes per started pair.
void yuyv_to_rgb(const std::uint8_t* row, int width, YuvRange range, Rgb8* out);
/// NV12: one byte of `luma` per pixel, and a pair Cb Cr of `chroma` per started pair of pixels, shared by two
/// rows.
void nv12_to_rgb(const std::uint8_t* luma, const std::uint8_t* chroma, int width, YuvRange range, Rgb8* out);
void grey_to_rgb(const std::uint8_t* row, int width, Rgb8* out);
/// 3 bytes per pixel.
void rgb_to_rgb(const std::uint8_t* row, int width, Rgb8* out);
void bgr_to_rgb(const std::uint8_t* row, int width, Rgb8* out);
/// 4 bytes per pixel; the fourth is not looked at.
void rgbx_to_rgb(const std::uint8_t* row, int width, Rgb8* out);
void bgrx_to_rgb(const std::uint8_t* row, int width, Rgb8* out);

}  // namespace loopsift
