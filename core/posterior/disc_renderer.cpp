// SPDX-License-Identifier: MIT
#include "core/posterior/disc_renderer.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "core/base/simd.hpp"

namespace loopsift {
namespace {

#define LOOPSIFT_INLINE inline __attribute__((always_inline))  // into both clones of the dispatched function

constexpr int kLanes = 8;

// A chunk's discs in the camera frame, ready to be splatted.
struct ProjectedChunk {
  alignas(64) float u[kChunkSize], v[kChunkSize];            // centre, pixels
  alignas(64) float inv[kChunkSize];                         // inverse depth at the centre
  alignas(64) float inv_du[kChunkSize], inv_dv[kChunkSize];  // its slope per pixel
  alignas(64) float uu[kChunkSize], uv[kChunkSize],
      vv[kChunkSize];  // |X(u,v) − p|² / radius² as a quadratic form
  alignas(64) float half_u[kChunkSize],
      half_v[kChunkSize];  // of the disc's bounding box, pixels; < 0: not visible
};

struct RenderView {
  float R[9], t[3];
  float fx, fy, cx, cy, width, height;
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
    const float inv_du = mx * inverse_d / view.fx, inv_dv = my * inverse_d / view.fy;
    const float zu = -depth * depth * inv_du, zv = -depth * depth * inv_dv;  // dz per pixel
    const float xu = depth / view.fx + a * zu, yu = b * zu;                  // d(x,y) per pixel in u
    const float xv = a * zv, yv = depth / view.fy + b * zv;                  // and in v
    const float scale = 1.0F / (radius[k] * radius[k]);
    const float uu = scale * (xu * xu + yu * yu + zu * zu), uv = scale * (xu * xv + yu * yv + zu * zv);
    const float vv = scale * (xv * xv + yv * yv + zv * zv);
    const float inverse_determinant = 1.0F / std::max(uu * vv - uv * uv, 1e-12F);
    const float half_u = std::max(0.5F, std::sqrt(vv * inverse_determinant));
    const float half_v = std::max(0.5F, std::sqrt(uu * inverse_determinant));
    const float u = view.fx * a + view.cx, v = view.fy * b + view.cy;
    const bool visible = faces & (pz > view.min_depth_m) & (pz < view.max_depth_m) & (u + half_u > -0.5F) &
                         (v + half_v > -0.5F) & (u - half_u < view.width) & (v - half_v < view.height);
    out->u[k] = u, out->v[k] = v, out->inv[k] = inv;
    out->inv_du[k] = inv_du, out->inv_dv[k] = inv_dv;
    out->uu[k] = uu, out->uv[k] = uv, out->vv[k] = vv;
    out->half_u[k] = visible ? half_u : -1.0F, out->half_v[k] = half_v;
  }
}

// Eight pixels at a time: past the box the quadratic form masks, past the row the image's padding takes the
// writes.
LOOPSIFT_INLINE void splat(const ProjectedChunk& p, int k, const ImageView<float>& image) {
  const float u = p.u[k], v = p.v[k], inv = p.inv[k], inv_du = p.inv_du[k], inv_dv = p.inv_dv[k];
  const float uu = p.uu[k], uv = 2.0F * p.uv[k], vv = p.vv[k];
  const int x0 = std::max(0, static_cast<int>(std::ceil(u - p.half_u[k])));
  const int x1 = std::min(image.width - 1, static_cast<int>(std::floor(u + p.half_u[k])));
  const int y0 = std::max(0, static_cast<int>(std::ceil(v - p.half_v[k])));
  const int y1 = std::min(image.height - 1, static_cast<int>(std::floor(v + p.half_v[k])));
  for (int y = y0; y <= y1; ++y) {
    const float dv = static_cast<float>(y) - v;
    for (int x = x0; x <= x1; x += kLanes) {
      float* pixels = image.row(y) + x;
#pragma omp simd simdlen(8)
      for (int lane = 0; lane < kLanes; ++lane) {
        const float du = static_cast<float>(x + lane) - u;
        const float value = inv + inv_du * du + inv_dv * dv;
        const float distance2 = uu * du * du + uv * du * dv + vv * dv * dv;
        const bool inside = distance2 <= 1.0F || std::max(std::abs(du), std::abs(dv)) <= 0.5F;
        const float before = pixels[lane];
        pixels[lane] = inside ? std::max(value, before) : before;
      }
    }
  }
}

LOOPSIFT_SIMD void render_chunk(const float* x, const float* y, const float* z, const float* nx,
                                const float* ny, const float* nz, const float* radius, int n,
                                const RenderView& view, const ImageView<float>& image) {
  ProjectedChunk p;
  project_chunk(x, y, z, nx, ny, nz, radius, n, view, &p);
  for (int k = 0; k < n; ++k) {
    if (p.half_u[k] >= 0.0F) splat(p, k, image);
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
