// SPDX-License-Identifier: MIT
#include "core/frame/kernels.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/simd.hpp"

namespace loopsift {
namespace {

constexpr float kFar = 1e6F;  // stands for "no depth" where the nearest is sought

// Mean of those of four depths (kFar: none) that lie on the nearest one's surface; 0 when there is none.
inline float mean_of_nearest(float a, float b, float c, float d, float edge_fraction) {
  const float nearest = std::min(std::min(a, b), std::min(c, d));
  const float limit = nearest * (1.0F + edge_fraction);
  const float wa = a <= limit ? 1.0F : 0.0F, wb = b <= limit ? 1.0F : 0.0F;
  const float wc = c <= limit ? 1.0F : 0.0F, wd = d <= limit ? 1.0F : 0.0F;
  const float mean = (wa * a + wb * b + wc * c + wd * d) / (wa + wb + wc + wd);
  return nearest < kFar ? mean : 0.0F;
}

inline float metres_or_far(std::uint16_t raw, float unit_m, float min_m, float max_m) {
  const float z = static_cast<float>(raw) * unit_m;
  const bool valid = raw != 0 && raw != 65535 && z >= min_m && z <= max_m;
  return valid ? z : kFar;
}

inline float or_far(float z) { return z > 0.0F ? z : kFar; }

LOOPSIFT_SIMD void reduce_row(const std::uint16_t* top, const std::uint16_t* bottom, int width, float unit_m,
                              DepthRange range, float* __restrict out) {
  for (int x = 0; x < width; ++x) {
    const float a = metres_or_far(top[2 * x], unit_m, range.min_m, range.max_m);
    const float b = metres_or_far(top[2 * x + 1], unit_m, range.min_m, range.max_m);
    const float c = metres_or_far(bottom[2 * x], unit_m, range.min_m, range.max_m);
    const float d = metres_or_far(bottom[2 * x + 1], unit_m, range.min_m, range.max_m);
    out[x] = mean_of_nearest(a, b, c, d, range.edge_fraction);
  }
}

LOOPSIFT_SIMD void convert_row(const std::uint16_t* raw, int width, float unit_m, DepthRange range,
                               float* __restrict out) {
  for (int x = 0; x < width; ++x) {
    const float z = metres_or_far(raw[x], unit_m, range.min_m, range.max_m);
    out[x] = z < kFar ? z : 0.0F;
  }
}

LOOPSIFT_SIMD void halve_row(const float* top, const float* bottom, int width, float edge_fraction,
                             float* __restrict out) {
  for (int x = 0; x < width; ++x) {
    out[x] = mean_of_nearest(or_far(top[2 * x]), or_far(top[2 * x + 1]), or_far(bottom[2 * x]),
                             or_far(bottom[2 * x + 1]), edge_fraction);
  }
}

// Adds one row of the window to sum and count for the pixels [begin, end).
LOOPSIFT_SIMD void add_window_row(const float* center, const float* row, int begin, int end, int radius,
                                  float edge_fraction, float* __restrict sum, float* __restrict count) {
  for (int dx = -radius; dx <= radius; ++dx) {
    const float* shifted = row + dx;
    for (int x = begin; x < end; ++x) {
      const float z = shifted[x], limit = edge_fraction * center[x];
      const float w = std::fabs(z - center[x]) <= limit && z > 0.0F ? 1.0F : 0.0F;
      sum[x] += w * z;
      count[x] += w;
    }
  }
}

LOOPSIFT_SIMD void normals_row(const float* up, const float* center, const float* down, int width, float fx,
                               float fy, float cx, float v_offset, float edge_fraction, float* __restrict nx,
                               float* __restrict ny, float* __restrict nz) {
  for (int x = 1; x < width - 1; ++x) {
    const float z = center[x], l = center[x - 1], r = center[x + 1], u = up[x], d = down[x];
    const float zu = 0.5F * (r - l), zv = 0.5F * (d - u);
    const float ax = fx * zu, ay = fy * zv;
    const float az = -(z + (static_cast<float>(x) - cx) * zu + v_offset * zv);
    const float limit = edge_fraction * z;
    const float steepest =
        std::max(std::max(std::fabs(l - z), std::fabs(r - z)), std::max(std::fabs(u - z), std::fabs(d - z)));
    const float nearest = std::min(std::min(std::min(l, r), std::min(u, d)), z);
    const float inverse = 1.0F / std::sqrt(ax * ax + ay * ay + az * az + 1e-20F);
    const float scale = nearest > 0.0F && steepest <= limit ? inverse : 0.0F;
    nx[x] = ax * scale;
    ny[x] = ay * scale;
    nz[x] = az * scale;
  }
}

constexpr int kStrip = 512;  // columns whose sums stay in the first cache level

void smooth_row(const ImageView<const float>& depth, int y, int radius, float edge_fraction, float* out) {
  const float* center = depth.row(y);
  for (int begin = radius; begin < depth.width - radius; begin += kStrip) {
    const int end = std::min(begin + kStrip, depth.width - radius);
    float sum[kStrip] = {}, count[kStrip] = {};
    for (int dy = -radius; dy <= radius; ++dy) {
      add_window_row(center + begin, depth.row(y + dy) + begin, 0, end - begin, radius, edge_fraction, sum,
                     count);
    }
    for (int x = begin; x < end; ++x) {
      out[x] = center[x] > 0.0F ? sum[x - begin] / count[x - begin] : 0.0F;
    }
  }
}

}  // namespace

void reduce_raw(const ImageView<const std::uint16_t>& raw, int step, float unit_m, const DepthRange& range,
                const ImageView<float>& out) {
  for (int y = 0; y < out.height; ++y) {
    if (step == 1) {
      convert_row(raw.row(y), out.width, unit_m, range, out.row(y));
    } else {
      reduce_row(raw.row(2 * y), raw.row(2 * y + 1), out.width, unit_m, range, out.row(y));
    }
  }
}

void halve_depth(const ImageView<const float>& depth, float edge_fraction, const ImageView<float>& out) {
  for (int y = 0; y < out.height; ++y)
    halve_row(depth.row(2 * y), depth.row(2 * y + 1), out.width, edge_fraction, out.row(y));
}

void smooth_depth(const ImageView<const float>& depth, int radius, float edge_fraction,
                  const ImageView<float>& out) {
  for (int y = 0; y < depth.height; ++y) {
    const bool border = y < radius || y >= depth.height - radius || depth.width <= 2 * radius;
    const int copied = border || radius == 0 ? depth.width : radius;
    std::copy_n(depth.row(y), copied, out.row(y));
    if (copied == depth.width) continue;
    std::copy_n(depth.row(y) + depth.width - radius, radius, out.row(y) + depth.width - radius);
    smooth_row(depth, y, radius, edge_fraction, out.row(y));
  }
}

void compute_normals(const ImageView<const float>& depth, const PinholeCamera& camera, float edge_fraction,
                     float* nx, float* ny, float* nz) {
  for (int y = 0; y < depth.height; ++y) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y) * depth.width;
    for (float* n : {nx + at, ny + at, nz + at}) n[0] = n[depth.width - 1] = 0.0F;
    if (y == 0 || y == depth.height - 1) {
      for (float* n : {nx + at, ny + at, nz + at}) std::fill_n(n, depth.width, 0.0F);
    } else {
      normals_row(depth.row(y - 1), depth.row(y), depth.row(y + 1), depth.width, camera.fx, camera.fy,
                  camera.cx, static_cast<float>(y) - camera.cy, edge_fraction, nx + at, ny + at, nz + at);
    }
  }
}

int count_valid(const ImageView<const float>& depth) {
  int valid = 0;
  for (int y = 0; y < depth.height; ++y) {
    const float* row = depth.row(y);
    for (int x = 0; x < depth.width; ++x) valid += row[x] > 0.0F ? 1 : 0;
  }
  return valid;
}

}  // namespace loopsift
