// SPDX-License-Identifier: MIT
// Kernels of colour and of the depth's correction against their plain forms.
#include "core/frame/intensity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/frame/disparity_correction.hpp"

namespace loopsift {
namespace {

TEST(Intensity, ReductionEqualsThePlainForm) {
  struct Size {
    int width, height, out_width, out_height;
  };
  // Whole blocks, uneven ones, one to one, and a row longer than a strip.
  for (const Size& s :
       {Size{64, 48, 16, 12}, Size{50, 37, 16, 12}, Size{33, 9, 33, 9}, Size{1400, 4, 600, 2}}) {
    std::mt19937 random(3);
    std::vector<Rgb8> color(static_cast<std::size_t>(s.width * s.height));
    for (Rgb8& c : color)
      c = {static_cast<unsigned char>(random()), static_cast<unsigned char>(random()),
           static_cast<unsigned char>(random())};
    std::vector<float> out(static_cast<std::size_t>(s.out_width * s.out_height));
    reduce_color(ImageView<const Rgb8>(color.data(), s.width, s.height),
                 {out.data(), s.out_width, s.out_height});
    const int step_x = s.width / s.out_width, step_y = s.height / s.out_height;
    for (int y = 0; y < s.out_height; ++y) {
      for (int x = 0; x < s.out_width; ++x) {
        double sum = 0;
        for (int j = 0; j < step_y; ++j)
          for (int i = 0; i < step_x; ++i) {
            const Rgb8 c = color[static_cast<std::size_t>((y * s.height / s.out_height + j) * s.width +
                                                          x * s.width / s.out_width + i)];
            sum += 0.25 * (c.r + 2 * c.g + c.b);
          }
        const double expected = std::log(sum / (step_x * step_y) + static_cast<double>(kDarkLevel));
        ASSERT_NEAR(out[static_cast<std::size_t>(y * s.out_width + x)], expected, 1e-4)
            << s.width << " " << x << " " << y;
      }
    }
  }
}

TEST(Intensity, HalvingTakesTheMeanOfFour) {
  const std::vector<float> in = {1, 3, 5, 7, 2, 4, 6, 9};
  std::vector<float> out(2);
  halve_intensity(ImageView<const float>(in.data(), 4, 2), {out.data(), 2, 1});
  EXPECT_FLOAT_EQ(out[0], 2.5F);
  EXPECT_FLOAT_EQ(out[1], 6.75F);
}

TEST(DisparityCorrection, AddsToTheInverseDepth) {
  DisparityCoefficients c;
  c << 0.01, 0, 0, 0, 0, 0, 0, 0, 0.02;
  const int w = 20, h = 10;
  std::vector<float> disparity(w * h), depth(w * h, 2.0F);
  depth[5] = 0.0F;
  draw_disparity(c, {disparity.data(), w, h});
  correct_depth(ImageView<const float>(disparity.data(), w, h), {depth.data(), w, h});
  EXPECT_EQ(depth[5], 0.0F) << "no depth stays none";
  for (int v = 1; v < h; ++v)
    for (int u = 0; u < w; ++u) {
      const double x = (2.0 * u + 1) / w - 1, y = (2.0 * v + 1) / h - 1;
      const double expected = 1 / (0.5 + 0.01 * x + 0.02 * y * y * y);
      ASSERT_NEAR(depth[static_cast<std::size_t>(v * w + u)], expected, 1e-5);
    }
}

}  // namespace
}  // namespace loopsift
