// SPDX-License-Identifier: MIT
#include "drivers/codec/pixel_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace loopsift {
namespace {

bool same(const Rgb8& a, const Rgb8& b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

// ITU-R BT.601 in real numbers.
Rgb8 reference(int y, int cb, int cr, YuvRange range) {
  const bool full = range == YuvRange::kFull;
  const double luma = full ? y / 255.0 : (y - 16) / 219.0;
  const double pb = (cb - 128) / (full ? 255.0 : 224.0), pr = (cr - 128) / (full ? 255.0 : 224.0);
  const auto byte = [](double v) {
    return static_cast<unsigned char>(std::lround(std::clamp(v, 0.0, 1.0) * 255));
  };
  return {byte(luma + 1.402 * pr), byte(luma - 0.344136 * pb - 0.714136 * pr), byte(luma + 1.772 * pb)};
}

class YuvRows : public ::testing::TestWithParam<YuvRange> {};

TEST_P(YuvRows, FollowTheStandardWithinTwoSteps) {
  for (int y = 0; y < 256; y += 15)
    for (int cb = 0; cb < 256; cb += 15)
      for (int cr = 0; cr < 256; cr += 15) {
        const auto byte = [](int v) { return static_cast<std::uint8_t>(v); };
        const std::uint8_t yuyv[4] = {byte(y), byte(cb), byte(y), byte(cr)};
        const std::uint8_t luma[1] = {byte(y)}, chroma[2] = {byte(cb), byte(cr)};
        Rgb8 a, b;
        yuyv_to_rgb(yuyv, 1, GetParam(), &a);
        nv12_to_rgb(luma, chroma, 1, GetParam(), &b);
        const Rgb8 expected = reference(y, cb, cr, GetParam());
        ASSERT_NEAR(a.r, expected.r, 2) << y << ' ' << cb << ' ' << cr;
        ASSERT_NEAR(a.g, expected.g, 2) << y << ' ' << cb << ' ' << cr;
        ASSERT_NEAR(a.b, expected.b, 2) << y << ' ' << cb << ' ' << cr;
        ASSERT_TRUE(same(a, b));
      }
}

INSTANTIATE_TEST_SUITE_P(Both, YuvRows, ::testing::Values(YuvRange::kLimited, YuvRange::kFull),
                         [](const auto& test) { return test.param == YuvRange::kFull ? "Full" : "Limited"; });

TEST(PixelRows, PairsShareTheirChromaAndAnOddWidthEndsInHalfAPair) {
  const std::uint8_t yuyv[8] = {10, 100, 20, 150, 30, 200, 40, 50}, luma[3] = {10, 20, 30},
                     chroma[4] = {100, 150, 200, 50};
  std::vector<Rgb8> a(3), b(3), pair(2);
  yuyv_to_rgb(yuyv, 3, YuvRange::kFull, a.data());
  nv12_to_rgb(luma, chroma, 3, YuvRange::kFull, b.data());
  for (std::size_t x = 0; x < 3; ++x) {
    EXPECT_TRUE(same(a[x], b[x])) << x;
    EXPECT_TRUE(same(a[x], reference(luma[x], chroma[x / 2 * 2], chroma[x / 2 * 2 + 1], YuvRange::kFull)))
        << x;
  }
}

TEST(PixelRows, OrdersOfBytes) {
  const std::uint8_t bytes[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  Rgb8 out[2];
  rgb_to_rgb(bytes, 2, out);
  EXPECT_TRUE(same(out[1], {4, 5, 6}));
  bgr_to_rgb(bytes, 2, out);
  EXPECT_TRUE(same(out[1], {6, 5, 4}));
  rgbx_to_rgb(bytes, 2, out);
  EXPECT_TRUE(same(out[1], {5, 6, 7}));
  bgrx_to_rgb(bytes, 2, out);
  EXPECT_TRUE(same(out[1], {7, 6, 5}));
  grey_to_rgb(bytes, 2, out);
  EXPECT_TRUE(same(out[1], {2, 2, 2}));
}

}  // namespace
}  // namespace loopsift
