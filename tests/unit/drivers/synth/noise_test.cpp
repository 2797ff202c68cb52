// SPDX-License-Identifier: MIT
#include "drivers/synth/noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "drivers/synth/random.hpp"

namespace loopsift {
namespace {

const PinholeCamera kCamera{160, 120, 585.0F, 585.0F, 79.5F, 59.5F};

RenderedFrame flat(float depth, float cosine = 1.0F) {
  RenderedFrame frame;
  frame.width = kCamera.width;
  frame.height = kCamera.height;
  frame.depth.assign(160 * 120, depth);
  frame.cosine.assign(160 * 120, cosine);
  return frame;
}

std::vector<std::uint16_t> measure(const NoiseSettings& settings, const RenderedFrame& frame,
                                   std::uint64_t number = 0) {
  std::vector<std::uint16_t> out(frame.depth.size());
  NoiseModel(kCamera, settings).apply_depth(frame, number, {out.data(), frame.width, frame.height});
  return out;
}

NoiseSettings undistorted() {
  NoiseSettings settings;
  settings.distortion = false;
  return settings;
}

double fraction_valid(const std::vector<std::uint16_t>& raw) {
  return 1.0 - static_cast<double>(std::count(raw.begin(), raw.end(), 0)) / static_cast<double>(raw.size());
}

/// The smallest difference between two values that occur.
int step_at(float depth) {
  const auto raw = measure(undistorted(), flat(depth));
  const std::set<int> values(raw.begin(), raw.end());
  int step = 65535;
  for (auto a = values.begin(), b = std::next(a); b != values.end(); ++a, ++b)
    if (*a > 0) step = std::min(step, *b - *a);
  return step;
}

TEST(Random, GaussianHasZeroMeanAndUnitVariance) {
  double sum = 0, squares = 0;
  constexpr int kCount = 200000;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const double g = gaussian(static_cast<std::uint32_t>(mix(3, i)));
    sum += g;
    squares += g * g;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.01);
  EXPECT_NEAR(squares / kCount, 1.0, 0.02);
}

TEST(NoiseModel, ExactWhenSwitchedOff) {
  NoiseSettings settings = undistorted();
  settings.noise = false;
  for (const std::uint16_t raw : measure(settings, flat(7.1234F))) ASSERT_EQ(raw, 7123);
  settings.depth_unit_m = 0.0002;
  for (const std::uint16_t raw : measure(settings, flat(7.1234F))) ASSERT_EQ(raw, 35617);
  for (const std::uint16_t raw : measure(settings, flat(14.0F))) ASSERT_EQ(raw, 0);  // beyond 16 bits
}

TEST(NoiseModel, DepthStepsGrowWithTheSquareOfDepth) {
  // One step of 1/8 pixel: z² / (8 f b) = z² · 2.85 mm at f = 585, b = 0.075.
  EXPECT_NEAR(step_at(1.0F), 2.85, 1.0);
  EXPECT_NEAR(step_at(2.0F), 11.4, 1.5);
  EXPECT_NEAR(step_at(4.0F), 45.6, 2.5);
}

TEST(NoiseModel, ErrorGrowsWithTheSquareOfDepthAndHasNoBias) {
  const auto statistics = [](float depth) {
    double sum = 0, squares = 0, count = 0;
    for (const std::uint16_t raw : measure(undistorted(), flat(depth))) {
      if (raw == 0) continue;
      const double e = 0.001 * raw - static_cast<double>(depth);
      sum += e;
      squares += e * e;
      ++count;
    }
    return std::make_pair(sum / count, std::sqrt(squares / count));
  };
  const auto near = statistics(1.03F), far = statistics(3.03F);
  EXPECT_NEAR(far.second / near.second, 9.0 * 0.96, 3.0);
  EXPECT_LT(far.second, 0.02);
  EXPECT_LT(std::abs(far.first), 0.008);
}

TEST(NoiseModel, RangeLimitsAndGrazingAngles) {
  EXPECT_EQ(fraction_valid(measure(undistorted(), flat(0.3F))), 0.0);
  EXPECT_EQ(fraction_valid(measure(undistorted(), flat(5.0F))), 0.0);
  EXPECT_EQ(fraction_valid(measure(undistorted(), flat(2.0F))), 1.0);
  EXPECT_EQ(fraction_valid(measure(undistorted(), flat(2.0F, 0.05F))), 0.0);
  EXPECT_NEAR(fraction_valid(measure(undistorted(), flat(2.0F, 0.175F))), 0.5, 0.05);
}

TEST(NoiseModel, ShadowOnOneSideOfANearObject) {
  RenderedFrame frame = flat(3.0F);
  for (int v = 0; v < 120; ++v)
    for (int u = 40; u < 80; ++u) frame.depth[static_cast<std::size_t>(v * 160 + u)] = 1.0F;
  const auto raw = measure(undistorted(), frame);
  const auto valid_in_column = [&](int u) {
    int valid = 0;
    for (int v = 0; v < 120; ++v) valid += raw[static_cast<std::size_t>(v * 160 + u)] > 0;
    return valid;
  };
  // Its width is f b (1/1 − 1/3) = 29 pixels, right of the object.
  for (const int u : {82, 95, 105}) EXPECT_EQ(valid_in_column(u), 0) << u;
  for (const int u : {10, 30, 60, 115}) EXPECT_EQ(valid_in_column(u), 120) << u;
  EXPECT_LT(valid_in_column(39), 100);  // a depth edge without a shadow loses some
  EXPECT_GT(valid_in_column(39), 20);
}

TEST(NoiseModel, DistortionIsFixedSmoothAndGrowsWithDepth) {
  NoiseSettings settings;
  settings.noise = false;
  settings.depth_unit_m = 0.0001;
  const NoiseModel model(kCamera, settings);
  const auto near = measure(settings, flat(1.0F)), far = measure(settings, flat(2.0F), 17);
  float largest = 0;
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) {
      const float p = model.distortion(u, v);
      largest = std::max(largest, std::abs(p));
      const auto i = static_cast<std::size_t>(v * 160 + u);
      ASSERT_NEAR(1e-4F * static_cast<float>(near[i]) - 1.0F, 0.005F * p, 1e-4F);
      ASSERT_NEAR(1e-4F * static_cast<float>(far[i]) - 2.0F, 0.02F * p, 1e-4F);
      if (u > 0) {
        ASSERT_LT(std::abs(p - model.distortion(u - 1, v)), 0.1F);
      }
    }
  EXPECT_FLOAT_EQ(largest, 1.0F);
}

TEST(NoiseModel, SeedAndFrameDecideTheNoise) {
  NoiseSettings settings;
  const auto first = measure(settings, flat(2.0F), 5);
  EXPECT_EQ(first, measure(settings, flat(2.0F), 5));
  EXPECT_NE(first, measure(settings, flat(2.0F), 6));
  settings.seed = 2;
  EXPECT_NE(first, measure(settings, flat(2.0F), 5));
}

}  // namespace
}  // namespace loopsift
