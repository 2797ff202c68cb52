// SPDX-License-Identifier: MIT
// Each vectorised kernel against its plain form.
#include "core/frame/kernels.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>
#include <vector>

namespace loopsift {
namespace {

constexpr float kEdge = 0.03F;

// Depths around two surfaces with holes; the width is no multiple of a vector.
struct RandomDepth {
  RandomDepth(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w * h)) {
    std::mt19937 random(7);
    std::normal_distribution<float> noise(0.0F, 0.01F);
    for (float& z : values) {
      const auto kind = random() % 8;
      z = kind == 0 ? 0.0F : (kind < 5 ? 1.0F : 1.05F) + noise(random);
    }
  }
  [[nodiscard]] ImageView<const float> view() const { return {values.data(), width, height}; }
  int width, height;
  std::vector<float> values;
};

std::vector<float> zeros(int w, int h) { return std::vector<float>(static_cast<std::size_t>(w * h)); }

float plain_mean_of_nearest(const std::vector<float>& depths) {
  float nearest = 1e9F, sum = 0, count = 0;
  for (const float z : depths)
    if (z > 0) nearest = std::min(nearest, z);
  for (const float z : depths)
    if (z > 0 && z <= nearest * (1.0F + kEdge)) sum += z, count += 1;
  return count > 0 ? sum / count : 0.0F;
}

TEST(FrameKernels, HalvingEqualsThePlainForm) {
  const RandomDepth in(46, 18);
  std::vector<float> out = zeros(23, 9);
  halve_depth(in.view(), kEdge, {out.data(), 23, 9});
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 23; ++x) {
      const auto d = in.view();
      const float expected = plain_mean_of_nearest(
          {d(2 * x, 2 * y), d(2 * x + 1, 2 * y), d(2 * x, 2 * y + 1), d(2 * x + 1, 2 * y + 1)});
      ASSERT_NEAR(out[static_cast<std::size_t>(y * 23 + x)], expected, 1e-5F);
    }
}

TEST(FrameKernels, RawReductionEqualsThePlainForm) {
  std::mt19937 random(5);
  std::vector<std::uint16_t> raw(46 * 18);
  const std::uint16_t values[] = {0, 65535, 1000, 1010, 1020, 1100, 200, 9000};
  for (std::uint16_t& v : raw) v = values[random() % 8];
  const auto metres = [&](int x, int y) {
    const std::uint16_t v = raw[static_cast<std::size_t>(y * 46 + x)];
    const float z = static_cast<float>(v) * 0.001F;
    return v == 65535 || z < 0.3F || z > 4.5F ? 0.0F : z;
  };
  std::vector<float> out = zeros(23, 9);
  reduce_raw({raw.data(), 46, 18}, 2, 0.001F, {0.3F, 4.5F, kEdge}, {out.data(), 23, 9});
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 23; ++x)
      ASSERT_NEAR(out[static_cast<std::size_t>(y * 23 + x)],
                  plain_mean_of_nearest({metres(2 * x, 2 * y), metres(2 * x + 1, 2 * y),
                                         metres(2 * x, 2 * y + 1), metres(2 * x + 1, 2 * y + 1)}),
                  1e-5F);
}

TEST(FrameKernels, SmoothingEqualsThePlainForm) {
  const RandomDepth in(1045, 11);  // wider than one strip
  for (const int radius : {0, 1, 2}) {
    std::vector<float> out = zeros(in.width, in.height);
    smooth_depth(in.view(), radius, kEdge, {out.data(), in.width, in.height});
    for (int y = 0; y < in.height; ++y)
      for (int x = 0; x < in.width; ++x) {
        const float center = in.view()(x, y);
        float sum = 0, count = 0;
        for (int dy = -radius; dy <= radius; ++dy)
          for (int dx = -radius; dx <= radius; ++dx) {
            if (x + dx < 0 || y + dy < 0 || x + dx >= in.width || y + dy >= in.height) continue;
            const float z = in.view()(x + dx, y + dy);
            if (z > 0 && std::fabs(z - center) <= kEdge * center) sum += z, count += 1;
          }
        const bool border = x < radius || y < radius || x >= in.width - radius || y >= in.height - radius;
        const float expected = border ? center : (center > 0 ? sum / count : 0.0F);
        ASSERT_NEAR(out[static_cast<std::size_t>(y * in.width + x)], expected, 1e-5F) << x << ' ' << y;
      }
  }
}

TEST(FrameKernels, NormalsEqualTheCrossProductOfTheTangents) {
  const RandomDepth in(53, 17);
  const PinholeCamera camera{53, 17, 60, 55, 26, 8};
  std::vector<float> nx = zeros(53, 17), ny = nx, nz = nx;
  compute_normals(in.view(), camera, kEdge, nx.data(), ny.data(), nz.data());
  int known = 0;
  for (int y = 0; y < 17; ++y)
    for (int x = 0; x < 53; ++x) {
      const auto k = static_cast<std::size_t>(y * 53 + x);
      const Eigen::Vector3f got(nx[k], ny[k], nz[k]);
      const auto d = in.view();
      Eigen::Vector3f expected = Eigen::Vector3f::Zero();
      if (x > 0 && y > 0 && x < 52 && y < 16) {
        const float z = d(x, y), l = d(x - 1, y), r = d(x + 1, y), u = d(x, y - 1), b = d(x, y + 1);
        bool smooth = true;
        for (const float other : {l, r, u, b, z}) smooth &= other > 0 && std::fabs(other - z) <= kEdge * z;
        if (smooth) {
          const float zu = 0.5F * (r - l), zv = 0.5F * (b - u);
          const float a = (static_cast<float>(x) - camera.cx) / camera.fx;
          const float c = (static_cast<float>(y) - camera.cy) / camera.fy;
          const Eigen::Vector3f tu(z / camera.fx + a * zu, c * zu, zu),
              tv(a * zv, z / camera.fy + c * zv, zv);
          expected = -tu.cross(tv).normalized();
          ++known;
        }
      }
      ASSERT_LT((got - expected).norm(), 1e-3F) << x << ' ' << y;
    }
  EXPECT_GT(known, 20);
}

}  // namespace
}  // namespace loopsift
