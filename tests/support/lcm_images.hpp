// SPDX-License-Identifier: MIT
// bot_core.images_t as other programs send it.
#pragma once
#include <zlib.h>

#include <bot_core/images_t.hpp>
#include <cstdint>
#include <cstring>
#include <vector>

namespace loopsift::test {

/// Depth pixel (x, y) is `value` + x; the colour's green is `value` % 256.
inline bot_core::image_t depth_image(int width, int height, std::uint16_t value, bool zipped) {
  std::vector<std::uint16_t> pixels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) pixels.push_back(static_cast<std::uint16_t>(value + x));
  bot_core::image_t image{};
  image.width = width;
  image.height = height;
  image.row_stride = 2 * width;
  image.pixelformat = bot_core::image_t::PIXEL_FORMAT_LE_GRAY16;
  const auto* raw = reinterpret_cast<const std::uint8_t*>(pixels.data());
  image.data.assign(raw, raw + 2 * pixels.size());
  if (zipped) {
    uLongf size = compressBound(image.data.size());
    std::vector<std::uint8_t> packed(size);
    compress(packed.data(), &size, raw, 2 * pixels.size());
    image.data.assign(packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size));
  }
  image.size = static_cast<std::int32_t>(image.data.size());
  return image;
}

inline bot_core::image_t rgb_image(int width, int height, std::uint8_t green) {
  bot_core::image_t image{};
  image.width = width;
  image.height = height;
  image.row_stride = 3 * width;
  image.pixelformat = bot_core::image_t::PIXEL_FORMAT_RGB;
  for (int k = 0; k < width * height; ++k) image.data.insert(image.data.end(), {10, green, 30});
  image.size = static_cast<std::int32_t>(image.data.size());
  return image;
}

inline bot_core::images_t images(std::int64_t utime_us, int width, int height, std::uint16_t value,
                                 bool zipped = true) {
  using bot_core::images_t;
  images_t message{};
  message.utime = utime_us;
  message.n_images = 2;
  message.image_types = {images_t::LEFT, zipped ? images_t::DEPTH_MM_ZIPPED : images_t::DEPTH_MM};
  message.images = {rgb_image(width, height, static_cast<std::uint8_t>(value)),
                    depth_image(width, height, value, zipped)};
  message.images[0].nmetadata = 1;
  message.images[0].metadata.resize(1);
  message.images[0].metadata[0].key = "exposure";
  return message;
}

inline std::vector<std::uint8_t> encode(const bot_core::images_t& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace loopsift::test
