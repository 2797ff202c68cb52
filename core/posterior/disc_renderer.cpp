// SPDX-License-Identifier: MIT
#include "core/posterior/disc_renderer.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/base/simd.hpp"

namespace loopsift {
namespace {

#define LOOPSIFT_INLINE inline __attribute__((always_inline))  // into both clones of the dispatched function

constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using HalfLanes = float __attribute__((vector_size(kLanes / 2 * sizeof(float))));
// Pixels of a small disc: at the size of score views most discs cover no more.
constexpr int kTileWidth = 4, kTileHeight = 2;

// A chunk's discs in the camera frame.
struct ProjectedChunk {
  alignas(64) float u[kChunkSize], v[kChunkSize];            // centre, pixels
  alignas(64) float inv[kChunkSize];                         // inverse depth at the centre
  alignas(64) float inv_du[kChunkSize], inv_dv[kChunkSize];  // its slope per pixel
  // |X(u,v) − p|² as a quadratic form, uu u² + uv u v + vv v²; inside the disc it is at most radius2
  alignas(64) float uu[kChunkSize], uv[kChunkSize], vv[kChunkSize], radius2[kChunkSize];
  // of the disc's bounding box, pixels; < 0: not visible
  alignas(64) float half_u[kChunkSize], half_v[kChunkSize];
};

// The pixels that its discs may cover, and which way each is splatted.
struct PlacedChunk {
  alignas(64) std::int32_t x[kChunkSize], y[kChunkSize];  // the first
  alignas(64) std::int32_t columns[kChunkSize], rows[kChunkSize];
  alignas(64) std::int32_t is_small[kChunkSize], is_large[kChunkSize];  // 0, 0: not visible
};

struct RenderView {
  float R[9], t[3];
  float fx, fy, inverse_fx, inverse_fy, cx, cy, width, height;
  float min_depth_m, max_depth_m;
};

// Vectorised over the chunk: transforms, projects, and finds the plane's inverse-depth slope and, to first
// order in the pixel offset, the distance on the disc.
LOOPSIFT_INLINE void project_chunk(const float* x, const float* y, const float* z, const float* nx,
                                   const float* ny, const float* nz, const float* radius, int n,
                                   const RenderView& view, ProjectedChunk* out) {
  const float* R = view.R;
  for (int k = 0; k < n; ++k) {
    const float px = R[0] * x[k] + R[1] * y[k] + R[2] * z[k] + view.t[0];
    const float py = R[3] * x[k] + R[4] * y[k] + R[5] * z[k] + view.t[1];
    const float pz = R[6] * x[k] + R[7] * y[k] + R[8] * z[k] + view.t[2];
    const float mx = R[0] * nx[k] + R[1] * ny[k] + R[2] * nz[k];
    const float my = R[3] * nx[k] + R[4] * ny[k] + R[5] * nz[k];
    const float mz = R[6] * nx[k] + R[7] * ny[k] + R[8] * nz[k];
    const float depth = std::max(pz, 1e-3F), inv = 1.0F / depth;
    const float a = px * inv, b = py * inv;
    const float d = mx * px + my * py + mz * pz;  // n·p: negative where the disc faces the camera
    const float limit = kGrazingCosine * kGrazingCosine * (px * px + py * py + pz * pz);
    const bool faces = (d < 0.0F) & (d * d > limit);
    const float inverse_d = 1.0F / (faces ? d : -1.0F);
    const float inv_du = mx * inverse_d * view.inverse_fx, inv_dv = my * inverse_d * view.inverse_fy;
    const float zu = -depth * depth * inv_du, zv = -depth * depth * inv_dv;  // dz per pixel
    const float xu = depth * view.inverse_fx + a * zu, yu = b * zu;          // d(x,y) per pixel in u
    const float xv = a * zv, yv = depth * view.inverse_fy + b * zv;          // and in v
    // The box about the disc's image reaches radius × the slope of u, and of v, along the plane.
    const float gu = mx - a * mz, gv = my - b * mz;
    const float half_u =
        std::max(0.5F, view.fx * inv * radius[k] * std::sqrt(std::max(0.0F, 1.0F + a * a - gu * gu)));
    const float half_v =
        std::max(0.5F, view.fy * inv * radius[k] * std::sqrt(std::max(0.0F, 1.0F + b * b - gv * gv)));
    const float u = view.fx * a + view.cx, v = view.fy * b + view.cy;
    const bool visible = faces & (pz > view.min_depth_m) & (pz < view.max_depth_m) & (u + half_u > -0.5F) &
                         (v + half_v > -0.5F) & (u - half_u < view.width) & (v - half_v < view.height);
    out->u[k] = u, out->v[k] = v, out->inv[k] = inv;
    out->inv_du[k] = inv_du, out->inv_dv[k] = inv_dv;
    out->uu[k] = xu * xu + yu * yu + zu * zu, out->vv[k] = xv * xv + yv * yv + zv * zv;
    out->uv[k] = 2.0F * (xu * xv + yu * yv + zu * zv), out->radius2[k] = radius[k] * radius[k];
    out->half_u[k] = visible ? half_u : -1.0F, out->half_v[k] = half_v;
  }
}

// The smallest integer that is not less; x ≥ 0.
LOOPSIFT_INLINE std::int32_t round_up(float x) {
  const auto whole = static_cast<std::int32_t>(x);
  return whole + static_cast<std::int32_t>(static_cast<float>(whole) < x);
}

LOOPSIFT_INLINE void place_chunk(const ProjectedChunk& p, int n, float width, float height,
                                 PlacedChunk* out) {
  const auto last_y = static_cast<std::int32_t>(height) - kTileHeight;
  const auto tiles_fit = static_cast<std::int32_t>(last_y >= 0);
  for (int k = 0; k < n; ++k) {
    const std::int32_t x0 = round_up(std::min(width, std::max(0.0F, p.u[k] - p.half_u[k])));
    const std::int32_t y0 = round_up(std::min(height, std::max(0.0F, p.v[k] - p.half_v[k])));
    const auto x1 = static_cast<std::int32_t>(std::min(width - 1.0F, std::max(0.0F, p.u[k] + p.half_u[k])));
    const auto y1 = static_cast<std::int32_t>(std::min(height - 1.0F, std::max(0.0F, p.v[k] + p.half_v[k])));
    const std::int32_t columns = x1 - x0 + 1, rows = y1 - y0 + 1;
    const auto visible = static_cast<std::int32_t>(p.half_u[k] >= 0.0F);
    const auto small = static_cast<std::int32_t>(columns <= kTileWidth) &
                       static_cast<std::int32_t>(rows <= kTileHeight) & tiles_fit;
    // A tile lies in the image's rows; where it begins before the disc does the quadratic form masks.
    out->x[k] = x0, out->y[k] = std::min(y0, small != 0 ? last_y : y0);
    out->columns[k] = columns, out->rows[k] = rows;
    out->is_small[k] = visible & small, out->is_large[k] = visible & (1 - small);
  }
}

// Past the disc the quadratic form masks, past the row the image's padding takes the writes.
LOOPSIFT_INLINE Lanes splat(const ProjectedChunk& p, int k, Lanes du, Lanes dv, Lanes before) {
  const Lanes value = p.inv[k] + p.inv_du[k] * du + p.inv_dv[k] * dv;
  const Lanes distance2 = (p.uu[k] * du + p.uv[k] * dv) * du + p.vv[k] * dv * dv;
  const auto at_centre = (du * du <= 0.25F) & (dv * dv <= 0.25F);
  const auto nearer = ((distance2 <= p.radius2[k]) | at_centre) & (value > before);
  return nearer ? value : before;
}

// Two rows of four pixels at once.
LOOPSIFT_INLINE void splat_tile(const ProjectedChunk& p, int k, int x, int y, const ImageView<float>& image) {
  constexpr Lanes kColumn = {0, 1, 2, 3, 0, 1, 2, 3}, kRow = {0, 0, 0, 0, 1, 1, 1, 1};
  HalfLanes first, second;
  std::memcpy(&first, image.row(y) + x, sizeof(first));
  std::memcpy(&second, image.row(y + 1) + x, sizeof(second));
  const Lanes before = __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
  const Lanes after = splat(p, k, kColumn + (static_cast<float>(x) - p.u[k]),
                            kRow + (static_cast<float>(y) - p.v[k]), before);
  first = __builtin_shufflevector(after, after, 0, 1, 2, 3);
  second = __builtin_shufflevector(after, after, 4, 5, 6, 7);
  std::memcpy(image.row(y) + x, &first, sizeof(first));
  std::memcpy(image.row(y + 1) + x, &second, sizeof(second));
}

// Eight pixels of a row at once.
LOOPSIFT_INLINE void splat_row(const ProjectedChunk& p, int k, int x, int y, const ImageView<float>& image) {
  constexpr Lanes kColumn = {0, 1, 2, 3, 4, 5, 6, 7};
  Lanes pixels;
  std::memcpy(&pixels, image.row(y) + x, sizeof(pixels));
  const Lanes dv = Lanes{} + (static_cast<float>(y) - p.v[k]);
  pixels = splat(p, k, kColumn + (static_cast<float>(x) - p.u[k]), dv, pixels);
  std::memcpy(image.row(y) + x, &pixels, sizeof(pixels));
}

// Discs of a kind one after the other, so that the processor can guess what comes next.
LOOPSIFT_SIMD void render_chunk(const float* x, const float* y, const float* z, const float* nx,
                                const float* ny, const float* nz, const float* radius, int n,
                                const RenderView& view, const ImageView<float>& image) {
  ProjectedChunk p;
  PlacedChunk at;
  project_chunk(x, y, z, nx, ny, nz, radius, n, view, &p);
  place_chunk(p, n, view.width, view.height, &at);
  std::uint8_t small[kChunkSize], large[kChunkSize];
  int smalls = 0, larges = 0;
  for (int k = 0; k < n; ++k) {
    small[smalls] = large[larges] = static_cast<std::uint8_t>(k);
    smalls += at.is_small[k];
    larges += at.is_large[k];
  }
  for (int s = 0; s < smalls; ++s) splat_tile(p, small[s], at.x[small[s]], at.y[small[s]], image);
  for (int l = 0; l < larges; ++l) {
    const int k = large[l];
    for (int row = 0; row < at.rows[k]; ++row)
      for (int column = 0; column < at.columns[k]; column += kLanes)
        splat_row(p, k, at.x[k] + column, at.y[k] + row, image);
  }
}

}  // namespace

// The frustum's four side planes, and the depth range.
bool in_sight(const Eigen::Vector3f& c, float r, const PinholeCamera& camera, float min_depth_m,
              float max_depth_m) {
  if (c.z() + r < min_depth_m || c.z() - r > max_depth_m) return false;
  const auto outside = [r](float along, float across, float f, float edge) {
    // Plane through the optical centre and the image edge at `edge` pixels from the principal point.
    return along * edge - across * f > r * std::sqrt(f * f + edge * edge);
  };
  const float left = -(camera.cx + 0.5F), right = static_cast<float>(camera.width) - 0.5F - camera.cx;
  const float top = -(camera.cy + 0.5F), bottom = static_cast<float>(camera.height) - 0.5F - camera.cy;
  return !outside(c.z(), c.x(), camera.fx, left) && !outside(-c.z(), -c.x(), camera.fx, right) &&
         !outside(c.z(), c.y(), camera.fy, top) && !outside(-c.z(), -c.y(), camera.fy, bottom);
}

void render_discs(const ScoreSurfels& surfels, const Se3& T_camera_fragment, const PinholeCamera& camera,
                  float min_depth_m, float max_depth_m, const ImageView<float>& inverse_depth) {
  assert(inverse_depth.stride >= padded_stride(inverse_depth.width));
  const Se3f T(T_camera_fragment);
  RenderView view{{},
                  {},
                  camera.fx,
                  camera.fy,
                  1.0F / camera.fx,
                  1.0F / camera.fy,
                  camera.cx,
                  camera.cy,
                  static_cast<float>(camera.width),
                  static_cast<float>(camera.height),
                  min_depth_m,
                  max_depth_m};
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>{view.R} = T.R;
  Eigen::Map<Eigen::Vector3f>{view.t} = T.t;
  for (const SurfelChunk& chunk : surfels.chunks) {
    if (!in_sight(T * chunk.center, chunk.radius, camera, min_depth_m, max_depth_m)) continue;
    const std::uint32_t o = chunk.begin;
    render_chunk(&surfels.x[o], &surfels.y[o], &surfels.z[o], &surfels.nx[o], &surfels.ny[o], &surfels.nz[o],
                 &surfels.radius[o], static_cast<int>(chunk.size), view, inverse_depth);
  }
}

void render_discs_plain(const ScoreSurfels& surfels, const Se3& T_camera_fragment,
                        const PinholeCamera& camera, float min_depth_m, float max_depth_m,
                        const ImageView<float>& inverse_depth) {
  const Se3f T(T_camera_fragment);
  for (std::size_t k = 0; k < surfels.size(); ++k) {
    const Eigen::Vector3f p = T * Eigen::Vector3f(surfels.x[k], surfels.y[k], surfels.z[k]);
    const Eigen::Vector3f n = T.R * Eigen::Vector3f(surfels.nx[k], surfels.ny[k], surfels.nz[k]);
    const float d = n.dot(p);
    if (p.z() <= min_depth_m || p.z() >= max_depth_m || d >= 0 || -d <= kGrazingCosine * p.norm()) continue;
    float u = 0, v = 0;
    if (!camera.project(p, &u, &v)) continue;
    for (int y = 0; y < inverse_depth.height; ++y) {
      for (int x = 0; x < inverse_depth.width; ++x) {
        const Eigen::Vector3f ray = camera.unproject(static_cast<float>(x), static_cast<float>(y), 1.0F);
        const float z = d / n.dot(ray);
        const bool center =
            std::abs(static_cast<float>(x) - u) <= 0.5F && std::abs(static_cast<float>(y) - v) <= 0.5F;
        if (!(z > 0) || (!center && (z * ray - p).norm() > surfels.radius[k])) continue;
        inverse_depth(x, y) = std::max(inverse_depth(x, y), 1.0F / z);
      }
    }
  }
}

}  // namespace loopsift
