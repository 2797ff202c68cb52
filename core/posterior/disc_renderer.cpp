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

#define LOOPSIFT_INLINE inline __attribute__((always_inline))  // into each clone of the dispatched function

constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using IntLanes = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));
using HalfLanes = float __attribute__((vector_size(kLanes / 2 * sizeof(float))));
// Pixels of a tile. At the size of score views hardly a disc covers more, and half of them cover one pixel.
constexpr int kTileWidth = 4, kTileHeight = 2;

// How a disc is drawn: bits in a byte each, see sets_of().
constexpr std::int32_t kDot = 1, kTile = 1 << 8, kLarge = 1 << 16;

// A chunk's discs in the image. du, dv pixels from its centre a disc has inverse depth inv + inv_du du +
// inv_dv dv, and the point there lies at the root of uu du² + uv du dv + vv dv² from the disc's centre.
struct ProjectedChunk {
  alignas(64) float inv[kChunkSize], inv_du[kChunkSize], inv_dv[kChunkSize];
  alignas(64) float uu[kChunkSize], uv[kChunkSize], vv[kChunkSize], radius2[kChunkSize];
  // The first of the pixels that it may cover: its place in the image's memory, its du and dv, and the
  // inverse depth of the disc there (0: is not on the disc).
  alignas(64) std::int32_t offset[kChunkSize];
  alignas(64) float du[kChunkSize], dv[kChunkSize], first[kChunkSize];
  alignas(64) std::int32_t columns[kChunkSize], rows[kChunkSize];
  alignas(64) std::int32_t kind[kChunkSize];  // 0: not visible
};

struct RenderView {
  float R[9], t[3];
  float fx, fy, inverse_fx, inverse_fy, cx, cy, width, height;
  float min_depth_m, max_depth_m;
  // The larger of a literal and a value is two instructions to GCC, of two values one.
  float zero = 0.0F, half = 0.5F, minus_one = -1.0F, tiny = 1e-3F;
};

// The smallest integer that is not less; x ≥ 0.
LOOPSIFT_INLINE std::int32_t round_up(float x) {
  const auto whole = static_cast<std::int32_t>(x);
  return whole + static_cast<std::int32_t>(static_cast<float>(whole) < x);
}

LOOPSIFT_INLINE std::int32_t as_int(bool condition) { return static_cast<std::int32_t>(condition); }

// A disc's plane in the camera frame and its place in the image, to first order in the pixel offset.
struct DiscInImage {
  float u, v, half_u, half_v;  // centre, and half of the box about it, pixels
  float inv, inv_du, inv_dv, uu, uv, vv;
  bool in_sight;  // faces the camera, within the range of depth
};

LOOPSIFT_INLINE DiscInImage project(float x, float y, float z, float nx, float ny, float nz, float radius,
                                    const RenderView& view) {
  const float* R = view.R;
  const float px = R[0] * x + R[1] * y + R[2] * z + view.t[0];
  const float py = R[3] * x + R[4] * y + R[5] * z + view.t[1];
  const float pz = R[6] * x + R[7] * y + R[8] * z + view.t[2];
  const float mx = R[0] * nx + R[1] * ny + R[2] * nz;
  const float my = R[3] * nx + R[4] * ny + R[5] * nz;
  const float mz = R[6] * nx + R[7] * ny + R[8] * nz;
  const float depth = std::max(view.tiny, pz), inv = 1.0F / depth;
  const float a = px * inv, b = py * inv;
  const float d = mx * px + my * py + mz * pz;  // n·p: negative where the disc faces the camera
  const float limit = kGrazingCosine * kGrazingCosine * (px * px + py * py + pz * pz);
  const bool faces = (d < 0.0F) & (d * d > limit);
  const bool in_sight = faces & (pz > view.min_depth_m) & (pz < view.max_depth_m);
  const float inverse_d = 1.0F / (faces ? d : -1.0F);
  const float inv_du = mx * inverse_d * view.inverse_fx, inv_dv = my * inverse_d * view.inverse_fy;
  const float zu = -depth * depth * inv_du, zv = -depth * depth * inv_dv;  // dz per pixel
  const float xu = depth * view.inverse_fx + a * zu, yu = b * zu;          // d(x,y) per pixel in u
  const float xv = a * zv, yv = depth * view.inverse_fy + b * zv;          // and in v
  // The box about the disc's image reaches radius × the slope of u, and of v, along the plane.
  const float gu = mx - a * mz, gv = my - b * mz;
  const float slope_u = view.fx * inv * std::sqrt(std::max(view.zero, 1.0F + a * a - gu * gu));
  const float slope_v = view.fy * inv * std::sqrt(std::max(view.zero, 1.0F + b * b - gv * gv));
  return {view.fx * a + view.cx,
          view.fy * b + view.cy,
          std::max(view.half, radius * slope_u),
          std::max(view.half, radius * slope_v),
          inv,
          inv_du,
          inv_dv,
          xu * xu + yu * yu + zu * zu,
          2.0F * (xu * xv + yu * yv + zu * zv),
          xv * xv + yv * yv + zv * zv,
          in_sight};
}

// Which pixels the disc may cover, and how it is drawn.
LOOPSIFT_INLINE void place(const DiscInImage& disc, float radius, const RenderView& view, std::int32_t stride,
                           int k, ProjectedChunk* out) {
  const float last_u = view.width - 1.0F, last_v = view.height - 1.0F;
  const std::int32_t x0 = round_up(std::min(view.width, std::max(view.zero, disc.u - disc.half_u)));
  const std::int32_t y0 = round_up(std::min(view.height, std::max(view.zero, disc.v - disc.half_v)));
  const auto x1 = static_cast<std::int32_t>(std::min(last_u, std::max(view.minus_one, disc.u + disc.half_u)));
  const auto y1 = static_cast<std::int32_t>(std::min(last_v, std::max(view.minus_one, disc.v + disc.half_v)));
  const std::int32_t columns = x1 - x0 + 1, rows = y1 - y0 + 1;
  const auto last_tile = static_cast<std::int32_t>(view.height) - kTileHeight;
  const std::int32_t visible = as_int(disc.in_sight) & as_int(columns > 0) & as_int(rows > 0);
  const std::int32_t dot = as_int(columns == 1) & as_int(rows == 1);
  const std::int32_t tile =
      as_int(columns <= kTileWidth) & as_int(rows <= kTileHeight) & as_int(last_tile >= 0) & (1 - dot);
  // A tile lies in the image's rows; where it begins before the disc does the quadratic form masks.
  const std::int32_t y = tile != 0 ? std::min(y0, last_tile) : y0;
  const float du = static_cast<float>(x0) - disc.u, dv = static_cast<float>(y) - disc.v;
  const float radius2 = radius * radius;
  const bool on_disc = (disc.uu * du + disc.uv * dv) * du + disc.vv * dv * dv <= radius2;
  const bool at_centre = (du * du <= 0.25F) & (dv * dv <= 0.25F);
  out->inv[k] = disc.inv, out->inv_du[k] = disc.inv_du, out->inv_dv[k] = disc.inv_dv;
  out->uu[k] = disc.uu, out->uv[k] = disc.uv, out->vv[k] = disc.vv, out->radius2[k] = radius2;
  out->offset[k] = y * stride + x0, out->du[k] = du, out->dv[k] = dv;
  out->first[k] = (on_disc | at_centre) ? disc.inv + disc.inv_du * du + disc.inv_dv * dv : 0.0F;
  out->columns[k] = columns, out->rows[k] = rows;
  out->kind[k] = visible * (dot != 0 ? kDot : tile != 0 ? kTile : kLarge);
}

// A chunk's discs by kind. Bit 8i + g is disc 8g + i: so those that follow one another lie apart, and what
// one of them writes need not have arrived when the next one reads its pixels.
struct DiscSets {
  std::uint64_t dots = 0, tiles = 0, larges = 0;
};

LOOPSIFT_INLINE DiscSets sets_of(const std::int32_t* kind) {
  IntLanes bits = {};
  for (int g = 0; g < kLanes; ++g) {
    IntLanes group;
    std::memcpy(&group, kind + g * kLanes, sizeof(group));
    bits |= group << g;
  }
  DiscSets sets;
  for (int i = 0; i < kLanes; ++i) {
    const auto lane = static_cast<std::uint64_t>(bits[i]);
    sets.dots |= (lane & 0xffU) << (8 * i);
    sets.tiles |= (lane >> 8U & 0xffU) << (8 * i);
    sets.larges |= (lane >> 16U & 0xffU) << (8 * i);
  }
  return sets;
}

LOOPSIFT_INLINE int first_of(std::uint64_t set) {
  const int bit = __builtin_ctzll(set);
  return kLanes * (bit % kLanes) + bit / kLanes;
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
LOOPSIFT_INLINE void splat_tile(const ProjectedChunk& p, int k, float* image, int stride) {
  constexpr Lanes kColumn = {0, 1, 2, 3, 0, 1, 2, 3}, kRow = {0, 0, 0, 0, 1, 1, 1, 1};
  float *const top = image + p.offset[k], *const bottom = top + stride;
  HalfLanes first, second;
  std::memcpy(&first, top, sizeof(first));
  std::memcpy(&second, bottom, sizeof(second));
  const Lanes before = __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
  const Lanes after = splat(p, k, kColumn + p.du[k], kRow + p.dv[k], before);
  first = __builtin_shufflevector(after, after, 0, 1, 2, 3);
  second = __builtin_shufflevector(after, after, 4, 5, 6, 7);
  std::memcpy(top, &first, sizeof(first));
  std::memcpy(bottom, &second, sizeof(second));
}

// Eight pixels of a row at once.
LOOPSIFT_INLINE void splat_rows(const ProjectedChunk& p, int k, float* image, int stride) {
  constexpr Lanes kColumn = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int row = 0; row < p.rows[k]; ++row) {
    const Lanes dv = Lanes{} + (p.dv[k] + static_cast<float>(row));
    for (int column = 0; column < p.columns[k]; column += kLanes) {
      float* const at = image + p.offset[k] + row * stride + column;
      Lanes pixels;
      std::memcpy(&pixels, at, sizeof(pixels));
      pixels = splat(p, k, kColumn + (p.du[k] + static_cast<float>(column)), dv, pixels);
      std::memcpy(at, &pixels, sizeof(pixels));
    }
  }
}

// Vectorised over the discs up to where they are drawn; then those of a kind one after the other.
LOOPSIFT_WIDE_SIMD void render_chunk(const float* x, const float* y, const float* z, const float* nx,
                                     const float* ny, const float* nz, const float* radius, int n,
                                     const RenderView& view, float* image, int stride) {
  ProjectedChunk p;
  for (int k = 0; k < n; ++k)
    place(project(x[k], y[k], z[k], nx[k], ny[k], nz[k], radius[k], view), radius[k], view, stride, k, &p);
  std::fill(p.kind + n, p.kind + kChunkSize, 0);
  const DiscSets sets = sets_of(p.kind);
  for (std::uint64_t dots = sets.dots; dots != 0; dots &= dots - 1) {
    const int k = first_of(dots);
    float* const pixel = image + p.offset[k];
    *pixel = std::max(*pixel, p.first[k]);
  }
  for (std::uint64_t tiles = sets.tiles; tiles != 0; tiles &= tiles - 1)
    splat_tile(p, first_of(tiles), image, stride);
  for (std::uint64_t larges = sets.larges; larges != 0; larges &= larges - 1)
    splat_rows(p, first_of(larges), image, stride);
}

}  // namespace

Frustum::Frustum(const PinholeCamera& camera, float min_depth_m, float max_depth_m)
    : min_depth_m_(min_depth_m), max_depth_m_(max_depth_m) {
  // Planes through the optical centre and the edges of the image; their normals point out of it.
  const float left = -(camera.cx + 0.5F), right = static_cast<float>(camera.width) - 0.5F - camera.cx;
  const float top = -(camera.cy + 0.5F), bottom = static_cast<float>(camera.height) - 0.5F - camera.cy;
  sides_.row(0) = Eigen::RowVector3f(-camera.fx, 0, left).normalized();
  sides_.row(1) = Eigen::RowVector3f(camera.fx, 0, -right).normalized();
  sides_.row(2) = Eigen::RowVector3f(0, -camera.fy, top).normalized();
  sides_.row(3) = Eigen::RowVector3f(0, camera.fy, -bottom).normalized();
}

bool Frustum::meets(const Eigen::Vector3f& center, float radius) const {
  return center.z() + radius >= min_depth_m_ && center.z() - radius <= max_depth_m_ &&
         (sides_ * center).maxCoeff() <= radius;
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
  const Frustum frustum(camera, min_depth_m, max_depth_m);
  for (const SurfelChunk& chunk : surfels.chunks) {
    if (!frustum.meets(T * chunk.center, chunk.radius)) continue;
    const std::uint32_t o = chunk.begin;
    render_chunk(&surfels.x[o], &surfels.y[o], &surfels.z[o], &surfels.nx[o], &surfels.ny[o], &surfels.nz[o],
                 &surfels.radius[o], static_cast<int>(chunk.size), view, inverse_depth.data,
                 inverse_depth.stride);
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
