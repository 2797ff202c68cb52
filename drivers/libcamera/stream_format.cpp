// SPDX-License-Identifier: MIT
#include "drivers/libcamera/stream_format.hpp"

#include <libcamera/formats.h>

namespace loopsift {
namespace {

namespace formats = libcamera::formats;

const std::uint8_t* row_of(const CameraImage& image, int y) {
  return image.plane + static_cast<std::size_t>(y) * image.stride_bytes;
}

template <void (*Convert)(const std::uint8_t*, int, Rgb8*)>
void direct(const CameraImage& image, int y, Rgb8* out) {
  Convert(row_of(image, y), image.width, out);
}

void yuyv(const CameraImage& image, int y, Rgb8* out) {
  yuyv_to_rgb(row_of(image, y), image.width, image.range, out);
}

void nv12(const CameraImage& image, int y, Rgb8* out) {
  const std::uint8_t* chroma = image.chroma + static_cast<std::size_t>(y / 2) * image.stride_bytes;
  nv12_to_rgb(row_of(image, y), chroma, image.width, image.range, out);
}

constexpr StreamPixelFormat kFormats[] = {
    {formats::BGR888, 3, 1, direct<rgb_to_rgb>},
    {formats::RGB888, 3, 1, direct<bgr_to_rgb>},
    {formats::XBGR8888, 4, 1, direct<rgbx_to_rgb>},
    {formats::XRGB8888, 4, 1, direct<bgrx_to_rgb>},
    {formats::ABGR8888, 4, 1, direct<rgbx_to_rgb>},
    {formats::ARGB8888, 4, 1, direct<bgrx_to_rgb>},
    {formats::NV12, 1, 2, nv12},
    {formats::YUYV, 2, 1, yuyv},
};

}  // namespace

Span<const StreamPixelFormat> known_stream_formats() {
  return {kFormats, sizeof kFormats / sizeof kFormats[0]};
}

const StreamPixelFormat* find_stream_format(const libcamera::PixelFormat& format) {
  for (const StreamPixelFormat& known : kFormats)
    if (known.format == format) return &known;
  return nullptr;
}

}  // namespace loopsift
