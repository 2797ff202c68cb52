// SPDX-License-Identifier: MIT
#include "drivers/v4l2/pixel_format.hpp"

#include <linux/videodev2.h>

#include <cstring>

namespace loopsift {
namespace {

// MIPI's packed 12 bits; not in every kernel's header.
constexpr std::uint32_t kY12P = v4l2_fourcc('Y', '1', '2', 'P');
constexpr std::uint32_t kBigEndian = std::uint32_t{1} << 31;

// 10, 12, 14 and 16 bits in two bytes, low byte first, as this host has them.
void words(const std::uint8_t* row, int width, std::uint16_t* out) {
  std::memcpy(out, row, 2 * static_cast<std::size_t>(width));
}

void words_big_endian(const std::uint8_t* row, int width, std::uint16_t* out) {
  for (int x = 0; x < width; ++x) out[x] = static_cast<std::uint16_t>(row[2 * x] << 8 | row[2 * x + 1]);
}

// Four pixels: the upper eight bits of each, then the lower two of all, the first pixel's lowest.
void mipi10(const std::uint8_t* row, int width, std::uint16_t* out) {
  for (int x = 0; x < width; ++x) {
    const std::uint8_t* group = row + x / 4 * 5;
    out[x] = static_cast<std::uint16_t>(group[x % 4] << 2 | (group[4] >> 2 * (x % 4) & 0x3));
  }
}

// Two pixels: the upper eight bits of each, then the lower four of both, the first pixel's lowest.
void mipi12(const std::uint8_t* row, int width, std::uint16_t* out) {
  for (int x = 0; x < width; ++x) {
    const std::uint8_t* group = row + x / 2 * 3;
    out[x] = static_cast<std::uint16_t>(group[x % 2] << 4 | (group[2] >> 4 * (x % 2) & 0xF));
  }
}

// One stream of bits, each pixel's highest first: four pixels in five bytes.
void bits10(const std::uint8_t* row, int width, std::uint16_t* out) {
  for (int x = 0; x < width; ++x) {
    const std::uint8_t* first = row + x / 4 * 5 + x % 4;
    const int both = first[0] << 8 | first[1];
    out[x] = static_cast<std::uint16_t>(both >> (6 - 2 * (x % 4)) & 0x3FF);
  }
}

template <void (*Convert)(const std::uint8_t*, int, Rgb8*)>
void without_range(const std::uint8_t* row, int width, YuvRange /*range*/, Rgb8* out) {
  Convert(row, width, out);
}

constexpr PixelFormat kFormats[] = {
    {V4L2_PIX_FMT_Z16, true, 1, 2, words, nullptr},
    {V4L2_PIX_FMT_Y16, true, 1, 2, words, nullptr},
    {V4L2_PIX_FMT_Y16_BE, true, 1, 2, words_big_endian, nullptr},
    {V4L2_PIX_FMT_Y14, true, 1, 2, words, nullptr},
    {V4L2_PIX_FMT_Y12, true, 1, 2, words, nullptr},
    {kY12P, true, 2, 3, mipi12, nullptr},
    {V4L2_PIX_FMT_Y10, true, 1, 2, words, nullptr},
    {V4L2_PIX_FMT_Y10P, true, 4, 5, mipi10, nullptr},
    {V4L2_PIX_FMT_Y10BPACK, true, 4, 5, bits10, nullptr},
    {V4L2_PIX_FMT_RGB24, false, 1, 3, nullptr, without_range<rgb_to_rgb>},
    {V4L2_PIX_FMT_BGR24, false, 1, 3, nullptr, without_range<bgr_to_rgb>},
    {V4L2_PIX_FMT_YUYV, false, 2, 4, nullptr, yuyv_to_rgb},
    {V4L2_PIX_FMT_MJPEG, false, 0, 0, nullptr, nullptr},
    {V4L2_PIX_FMT_JPEG, false, 0, 0, nullptr, nullptr},
    {V4L2_PIX_FMT_GREY, false, 1, 1, nullptr, without_range<grey_to_rgb>},
};

}  // namespace

Span<const PixelFormat> known_pixel_formats() { return {kFormats, sizeof kFormats / sizeof kFormats[0]}; }

const PixelFormat* find_pixel_format(std::uint32_t code) {
  for (const PixelFormat& format : kFormats)
    if (format.code == code) return &format;
  return nullptr;
}

std::string fourcc_name(std::uint32_t code) {
  std::string name;
  for (int shift = 0; shift < 32; shift += 8) name += static_cast<char>((code & ~kBigEndian) >> shift & 0xFF);
  while (!name.empty() && name.back() == ' ') name.pop_back();
  return (code & kBigEndian) != 0 ? name + "-BE" : name;
}

}  // namespace loopsift
