// SPDX-License-Identifier: MIT
#include "drivers/openni2/frame_copy.hpp"

#include <cstring>
#include <type_traits>

namespace loopsift::openni2 {
namespace {

// Whether the frame holds `to`'s pixels, `pixel_bytes` each, row by row.
template <class T>
bool fits(const openni::VideoFrameRef& from, std::size_t pixel_bytes, const ImageView<T>& to) {
  if (from.getWidth() != to.width || from.getHeight() != to.height || from.getStrideInBytes() < 0) {
    return false;
  }
  const auto width = static_cast<std::size_t>(to.width), height = static_cast<std::size_t>(to.height);
  const auto stride = static_cast<std::size_t>(from.getStrideInBytes());
  return stride >= width * pixel_bytes && from.getDataSize() >= 0 &&
         static_cast<std::size_t>(from.getDataSize()) >= (height - 1) * stride + width * pixel_bytes;
}

// Each pixel of type From becomes one of `to` by `convert`; rows of the same type are copied whole.
template <class From, class To, class Convert>
void copy_rows(const openni::VideoFrameRef& from, bool mirrored, const ImageView<To>& to, Convert convert) {
  const auto stride = static_cast<std::size_t>(from.getStrideInBytes());
  const auto width = static_cast<std::size_t>(to.width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(to.height); ++y) {
    const std::uint8_t* bytes = static_cast<const std::uint8_t*>(from.getData()) + y * stride;
    To* row = to.row(static_cast<int>(y));
    if (std::is_same_v<From, To> && !mirrored) {
      std::memcpy(row, bytes, width * sizeof(To));
      continue;
    }
    for (std::size_t x = 0; x < width; ++x) {
      From pixel;
      std::memcpy(&pixel, bytes + (mirrored ? width - 1 - x : x) * sizeof(From), sizeof(From));
      row[x] = convert(pixel);
    }
  }
}

}  // namespace

bool copy_depth(const openni::VideoFrameRef& from, bool mirrored, const ImageView<std::uint16_t>& to) {
  if (!fits(from, sizeof(std::uint16_t), to)) return false;
  copy_rows<std::uint16_t>(from, mirrored, to, [](std::uint16_t depth) { return depth; });
  return true;
}

bool copy_color(const openni::VideoFrameRef& from, bool mirrored, const ImageView<Rgb8>& to) {
  if (from.getVideoMode().getPixelFormat() == openni::PIXEL_FORMAT_RGB888) {
    if (!fits(from, sizeof(Rgb8), to)) return false;
    copy_rows<Rgb8>(from, mirrored, to, [](const Rgb8& color) { return color; });
    return true;
  }
  if (from.getVideoMode().getPixelFormat() != openni::PIXEL_FORMAT_GRAY8) return false;
  if (!fits(from, sizeof(std::uint8_t), to)) return false;
  copy_rows<std::uint8_t>(from, mirrored, to, [](std::uint8_t grey) { return Rgb8{grey, grey, grey}; });
  return true;
}

}  // namespace loopsift::openni2
