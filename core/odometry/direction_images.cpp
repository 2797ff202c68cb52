// SPDX-License-Identifier: MIT
#include "core/odometry/direction_images.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/simd.hpp"
#include "core/odometry/normal_equations.hpp"

namespace loopsift {
namespace {

// Pixels of the present image to (homogeneous) pixels of the kept one: K R K⁻¹, rows first.
struct Homography {
  float h[9];
  Homography(const PinholeCamera& kept, const PinholeCamera& present, const Eigen::Matrix3d& R) : h{} {
    Eigen::Matrix3d from = Eigen::Matrix3d::Identity(), to = Eigen::Matrix3d::Identity();
    from(0, 0) = 1.0 / static_cast<double>(present.fx);
    from(1, 1) = 1.0 / static_cast<double>(present.fy);
    from(0, 2) = -static_cast<double>(present.cx) * from(0, 0);
    from(1, 2) = -static_cast<double>(present.cy) * from(1, 1);
    to(0, 0) = static_cast<double>(kept.fx);
    to(1, 1) = static_cast<double>(kept.fy);
    to(0, 2) = static_cast<double>(kept.cx);
    to(1, 2) = static_cast<double>(kept.cy);
    const Eigen::Matrix3d H = to * R * from;
    for (int k = 0; k < 9; ++k) h[k] = static_cast<float>(H(k / 3, k % 3));
  }
};

// Per pixel, and whether both images have it. Zero past the end.
struct Differences {
  alignas(32) float d[kMostTurnedPixels] = {}, ok[kMostTurnedPixels] = {};
};

// Nearest pixel of the kept image for each of a row; −1: out of sight.
LOOPSIFT_SIMD void nearest_of_row(const Homography& H, int y, int width, int kept_width, int kept_height,
                                  std::int32_t* __restrict partner) {
  const float* h = H.h;
  const auto v0 = static_cast<float>(y);
  const auto right = static_cast<float>(kept_width), bottom = static_cast<float>(kept_height);
  for (int x = 0; x < width; ++x) {
    const auto u0 = static_cast<float>(x);
    const float z = h[6] * u0 + h[7] * v0 + h[8];
    const float inverse_z = 1.0F / std::max(z, 1e-3F);
    const float u = (h[0] * u0 + h[1] * v0 + h[2]) * inverse_z + 0.5F;
    const float v = (h[3] * u0 + h[4] * v0 + h[5]) * inverse_z + 0.5F;
    const bool inside = (z > 1e-3F) & (u >= 0.0F) & (v >= 0.0F) & (u < right) & (v < bottom);
    const float su = inside ? u : 0.0F, sv = inside ? v : 0.0F;
    const std::int32_t at = static_cast<std::int32_t>(sv) * kept_width + static_cast<std::int32_t>(su);
    partner[x] = inside ? at : -1;
  }
}

// Differences where both are measured (else 0), their sum and number.
LOOPSIFT_SIMD void subtract(const float* kept, const float* present, const std::int32_t* partner, int count,
                            Differences& __restrict out) {
  for (int i = 0; i < count; ++i) {
    const float a = kept[partner[i] < 0 ? 0 : partner[i]], b = present[i];
    const bool both = (partner[i] >= 0) & (a > DirectionImages::kLeast) & (b > DirectionImages::kLeast);
    out.d[i] = both ? a - b : 0.0F;
    out.ok[i] = both ? 1.0F : 0.0F;
  }
}

// Σ ok, Σ d and Σ ok |d − middle|, in lanes; d and ok are zero past their end.
LOOPSIFT_SIMD void sum_up(const Differences& all, int count, float middle, float (*__restrict sums)[kLanes]) {
  for (int i = 0; i < count; i += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      sums[0][l] += all.ok[i + l];
      sums[1][l] += all.d[i + l];
      sums[2][l] += all.ok[i + l] * std::fabs(all.d[i + l] - middle);
    }
  }
}

float mean_difference(const Differences& all, int count) {
  float sums[3][kLanes] = {};
  double total[3] = {};
  sum_up(all, count, 0.0F, sums);
  add_sums(sums, 3, total);
  if (2.0 * total[0] < count) return -1.0F;
  const double mean = total[1] / total[0];
  float around[3][kLanes] = {};
  double total_around[3] = {};
  sum_up(all, count, static_cast<float>(mean), around);
  add_sums(around, 3, total_around);
  return std::max(static_cast<float>(total_around[2] / total_around[0]), kLeastDifference);
}

}  // namespace

TurnDifference compare_turned(const DirectionImages& kept, const DirectionImages& present,
                              const Eigen::Matrix3d& R_kept_present) {
  const Homography H(kept.camera, present.camera, R_kept_present);
  const int width = present.camera.width, count = width * present.camera.height;
  assert(count <= kMostTurnedPixels);
  std::int32_t partner[kMostTurnedPixels];
  Differences all;
  for (int y = 0; y < present.camera.height; ++y)
    nearest_of_row(H, y, width, kept.camera.width, kept.camera.height, partner + y * width);
  TurnDifference difference;
  for (std::size_t c = 0; c < difference.mean.size(); ++c) {
    subtract(kept.channel[c].data(), present.channel[c].data(), partner, count, all);
    difference.mean[c] = mean_difference(all, count);
  }
  return difference;
}

void draw_directions(const FrameLevel& level, int step, const DirectionImages& to) {
  const PinholeCamera &c = to.camera, &fine = level.camera;
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      float sum[2] = {}, n[2] = {};
      for (int v = y * step; v < (y + 1) * step; ++v) {
        for (int u = x * step; u < (x + 1) * step; ++u) {
          const float z = level.depth_m(u, v);
          if (z > 0) {
            sum[0] += z * fine.unproject(static_cast<float>(u), static_cast<float>(v), 1.0F).norm();
            n[0] += 1.0F;
          }
          if (level.intensity.empty()) continue;
          sum[1] += level.intensity(u, v);
          n[1] += 1.0F;
        }
      }
      const auto at = static_cast<std::size_t>(y * c.width + x);
      to.channel[0][at] = n[0] > 0 ? std::log(sum[0] / n[0]) : DirectionImages::kNone;
      to.channel[1][at] = n[1] > 0 ? sum[1] / n[1] : DirectionImages::kNone;
    }
  }
}

void halve_directions(const DirectionImages& from, const DirectionImages& to) {
  for (std::size_t channel = 0; channel < from.channel.size(); ++channel) {
    for (int y = 0; y < to.camera.height; ++y) {
      for (int x = 0; x < to.camera.width; ++x) {
        float sum = 0, n = 0;
        for (int k = 0; k < 4; ++k) {
          const int at = (2 * y + k / 2) * from.camera.width + 2 * x + k % 2;
          const float value = from.channel[channel][static_cast<std::size_t>(at)];
          if (value <= DirectionImages::kLeast) continue;
          sum += value;
          n += 1.0F;
        }
        to.channel[channel][static_cast<std::size_t>(y * to.camera.width + x)] =
            n > 0 ? sum / n : DirectionImages::kNone;
      }
    }
  }
}

}  // namespace loopsift
