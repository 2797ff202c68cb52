// SPDX-License-Identifier: MIT
#include "core/frame/intensity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/simd.hpp"

namespace loopsift {
namespace {

constexpr int kStrip = 512;  // colour columns whose sums stay in the first cache level
static_assert(sizeof(Rgb8) == 3, "colour is read as bytes");

// Adds 4 · luminance of one row; 64 rows of at most 1020 fit.
LOOPSIFT_SIMD void add_luminance(const unsigned char* __restrict rgb, int count,
                                 std::uint16_t* __restrict sums) {
  for (int i = 0; i < count; ++i) {
    const unsigned sum = rgb[3 * i] + 2U * rgb[3 * i + 1] + rgb[3 * i + 2];
    sums[i] = static_cast<std::uint16_t>(sums[i] + sum);
  }
}

LOOPSIFT_SIMD void halve_row(const float* top, const float* bottom, int width, float* __restrict out) {
  for (int x = 0; x < width; ++x)
    out[x] = 0.25F * (top[2 * x] + top[2 * x + 1] + bottom[2 * x] + bottom[2 * x + 1]);
}

}  // namespace

void reduce_color(const ImageView<const Rgb8>& color, const ImageView<float>& out) {
  const int step_x = color.width / out.width, step_y = color.height / out.height;
  const int per_strip = (kStrip - 1) * out.width / color.width;
  const float scale = 0.25F / static_cast<float>(step_x * step_y);
  for (int y = 0; y < out.height; ++y) {
    const int v0 = y * color.height / out.height;
    for (int begin = 0; begin < out.width; begin += per_strip) {
      const int count = std::min(per_strip, out.width - begin);
      std::uint16_t sums[kStrip] = {};
      const int u0 = begin * color.width / out.width;
      const int span = std::min(kStrip, color.width - u0);
      for (int v = v0; v < v0 + step_y; ++v) add_luminance(&color.row(v)[u0].r, span, sums);
      for (int x = 0; x < count; ++x) {
        const int at = (begin + x) * color.width / out.width - u0;
        int sum = 0;
        for (int k = 0; k < step_x; ++k) sum += sums[at + k];
        out(begin + x, y) = std::log(static_cast<float>(sum) * scale + kDarkLevel);
      }
    }
  }
}

void halve_intensity(const ImageView<const float>& intensity, const ImageView<float>& out) {
  for (int y = 0; y < out.height; ++y)
    halve_row(intensity.row(2 * y), intensity.row(2 * y + 1), out.width, out.row(y));
}

}  // namespace loopsift
