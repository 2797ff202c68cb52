// SPDX-License-Identifier: MIT
#include "drivers/libcamera/stream_format.hpp"

#include <gtest/gtest.h>
#include <libcamera/formats.h>

#include <vector>

namespace loopsift {
namespace {

Rgb8 pixel(const libcamera::PixelFormat& format, const CameraImage& image, int x, int y) {
  const StreamPixelFormat* known = find_stream_format(format);
  EXPECT_NE(known, nullptr);
  std::vector<Rgb8> row(static_cast<std::size_t>(image.width));
  known->row(image, y, row.data());
  return row[static_cast<std::size_t>(x)];
}

void expect_color(const Rgb8& color, int r, int g, int b) {
  EXPECT_EQ(color.r, r);
  EXPECT_EQ(color.g, g);
  EXPECT_EQ(color.b, b);
}

TEST(StreamFormat, OrdersOfBytesAreThoseInMemory) {
  std::vector<std::uint8_t> bytes(2 * 12, 0);  // two rows of two pixels and some padding
  for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = static_cast<std::uint8_t>(k);
  const CameraImage image{bytes.data(), nullptr, 12, 2, 2};
  expect_color(pixel(libcamera::formats::BGR888, image, 1, 1), 15, 16, 17);
  expect_color(pixel(libcamera::formats::RGB888, image, 1, 1), 17, 16, 15);
  expect_color(pixel(libcamera::formats::XBGR8888, image, 1, 1), 16, 17, 18);
  expect_color(pixel(libcamera::formats::XRGB8888, image, 1, 1), 18, 17, 16);
}

TEST(StreamFormat, Nv12RowsShareTheirChroma) {
  const std::uint8_t luma[4 * 4] = {10, 20, 0, 0, 30, 40, 0, 0, 50, 60, 0, 0, 70, 80, 0, 0};
  const std::uint8_t chroma[2 * 4] = {128, 128, 0, 0, 128, 255, 0, 0};
  const CameraImage image{luma, chroma, 4, 2, 4, YuvRange::kFull};
  expect_color(pixel(libcamera::formats::NV12, image, 1, 0), 20, 20, 20);
  expect_color(pixel(libcamera::formats::NV12, image, 0, 1), 30, 30, 30);
  EXPECT_GT(pixel(libcamera::formats::NV12, image, 0, 2).r, 200);
  EXPECT_GT(pixel(libcamera::formats::NV12, image, 1, 3).r, 200);
}

TEST(StreamFormat, EachIsFoundByItself) {
  for (const StreamPixelFormat& known : known_stream_formats())
    EXPECT_EQ(find_stream_format(known.format), &known);
  EXPECT_EQ(find_stream_format(libcamera::formats::MJPEG), nullptr);
}

}  // namespace
}  // namespace loopsift
