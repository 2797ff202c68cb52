// SPDX-License-Identifier: MIT
#include "drivers/codec/pixel_rows.hpp"

#include <algorithm>
#include <cstring>

namespace loopsift {
namespace {

/// R = (luma·(Y − black) + red_v·V) / 256 and so on, with U = Cb − 128 and V = Cr − 128.
struct Coefficients {
  int black, luma, red_v, green_u, green_v, blue_u;
};
constexpr Coefficients kLimitedRange{16, 298, 409, -100, -208, 516};
constexpr Coefficients kFullRange{0, 256, 359, -88, -183, 454};

const Coefficients& coefficients(YuvRange range) {
  return range == YuvRange::kFull ? kFullRange : kLimitedRange;
}

unsigned char to_byte(int times_256) {
  return static_cast<unsigned char>(std::clamp((times_256 + 128) >> 8, 0, 255));
}

Rgb8 to_rgb(const Coefficients& c, int y, int cb, int cr) {
  const int luma = c.luma * (y - c.black), u = cb - 128, v = cr - 128;
  return {to_byte(luma + c.red_v * v), to_byte(luma + c.green_u * u + c.green_v * v),
          to_byte(luma + c.blue_u * u)};
}

}  // namespace

void yuyv_to_rgb(const std::uint8_t* row, int width, YuvRange range, Rgb8* out) {
  const Coefficients c = coefficients(range);
  for (int x = 0; x < width; ++x) {
    const std::uint8_t* pair = row + 4 * (x / 2);
    out[x] = to_rgb(c, row[2 * x], pair[1], pair[3]);
  }
}

void nv12_to_rgb(const std::uint8_t* luma, const std::uint8_t* chroma, int width, YuvRange range, Rgb8* out) {
  const Coefficients c = coefficients(range);
  for (int x = 0; x < width; ++x) {
    const std::uint8_t* pair = chroma + 2 * (x / 2);
    out[x] = to_rgb(c, luma[x], pair[0], pair[1]);
  }
}

void grey_to_rgb(const std::uint8_t* row, int width, Rgb8* out) {
  for (int x = 0; x < width; ++x) out[x] = {row[x], row[x], row[x]};
}

void rgb_to_rgb(const std::uint8_t* row, int width, Rgb8* out) {
  static_assert(sizeof(Rgb8) == 3, "a row of pixels is a row of bytes");
  std::memcpy(&out->r, row, 3 * static_cast<std::size_t>(width));
}

void bgr_to_rgb(const std::uint8_t* row, int width, Rgb8* out) {
  for (int x = 0; x < width; ++x) out[x] = {row[3 * x + 2], row[3 * x + 1], row[3 * x]};
}

void rgbx_to_rgb(const std::uint8_t* row, int width, Rgb8* out) {
  for (int x = 0; x < width; ++x) out[x] = {row[4 * x], row[4 * x + 1], row[4 * x + 2]};
}

void bgrx_to_rgb(const std::uint8_t* row, int width, Rgb8* out) {
  for (int x = 0; x < width; ++x) out[x] = {row[4 * x + 2], row[4 * x + 1], row[4 * x]};
}

}  // namespace loopsift
