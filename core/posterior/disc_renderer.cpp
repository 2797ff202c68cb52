// SPDX-License-Identifier: MIT
#include "core/posterior/disc_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/simd.hpp"

namespace loopsift {
namespace {

// A chunk's discs in the camera frame, ready to be splatted.
struct ProjectedChunk {
  alignas(64) float u[kChunkSize], v[kChunkSize];            // centre, pixels
  alignas(64) float inv[kChunkSize];                         // inverse depth at the centre
  alignas(64) float inv_du[kChunkSize], inv_dv[kChunkSize];  // its slope per pixel
  alignas(64) float a[kChunkSize], b[kChunkSize];            // centre ray (a, b, 1)
  alignas(64) std::int32_t visible[kChunkSize];
};

struct RenderRange {
  float min_depth_m, max_depth_m;
};

// Vectorised over the chunk: transforms, projects, and finds the plane's inverse-depth slope.
LOOPSIFT_SIMD void project_chunk(const float* x, const float* y, const float* z, const float* nx,
                                 const float* ny, const float* nz, int n, const float* R, const float* t,
                                 const float* K, RenderRange range, ProjectedChunk* out) {
  const float fx = K[0], fy = K[1], cx = K[2], cy = K[3];
  for (int k = 0; k < n; ++k) {
    const float px = R[0] * x[k] + R[1] * y[k] + R[2] * z[k] + t[0];
    const float py = R[3] * x[k] + R[4] * y[k] + R[5] * z[k] + t[1];
    const float pz = R[6] * x[k] + R[7] * y[k] + R[8] * z[k] + t[2];
    const float mx = R[0] * nx[k] + R[1] * ny[k] + R[2] * nz[k];
    const float my = R[3] * nx[k] + R[4] * ny[k] + R[5] * nz[k];
    const float mz = R[6] * nx[k] + R[7] * ny[k] + R[8] * nz[k];
    const float inv = 1.0F / std::max(pz, 1e-3F);
    const float a = px * inv, b = py * inv;
    const float d = mx * px + my * py + mz * pz;  // n·p: negative where the disc faces the camera
    const float limit = kGrazingCosine * kGrazingCosine * (px * px + py * py + pz * pz);
    const bool faces = (d < 0.0F) & (d * d > limit);
    const float inverse_d = 1.0F / (faces ? d : -1.0F);
    out->u[k] = fx * a + cx;
    out->v[k] = fy * b + cy;
    out->inv[k] = inv;
    out->inv_du[k] = mx * inverse_d / fx;
    out->inv_dv[k] = my * inverse_d / fy;
    out->a[k] = a;
    out->b[k] = b;
    out->visible[k] = static_cast<std::int32_t>(faces & (pz > range.min_depth_m) & (pz < range.max_depth_m));
  }
}

// |X(u,v) − p|² as a quadratic form of the pixel offset, to first order in the offset.
struct DiscMetric {
  float uu, uv, vv;
};

DiscMetric disc_metric(float z, float a, float b, float inv_du, float inv_dv, float fx, float fy) {
  const float zu = -z * z * inv_du, zv = -z * z * inv_dv;  // dz per pixel
  const float xu = z / fx + a * zu, yu = b * zu;           // d(x,y) per pixel in u
  const float xv = a * zv, yv = z / fy + b * zv;           // and in v
  return {xu * xu + yu * yu + zu * zu, xu * xv + yu * yv + zu * zv, xv * xv + yv * yv + zv * zv};
}

void splat(float u, float v, float inv, float inv_du, float inv_dv, const DiscMetric& m, float radius,
           const ImageView<float>& image) {
  const float r2 = radius * radius;
  const float determinant = std::max(m.uu * m.vv - m.uv * m.uv, 1e-20F);
  const float half_u = std::sqrt(r2 * m.vv / determinant), half_v = std::sqrt(r2 * m.uu / determinant);
  const int x0 = std::max(0, static_cast<int>(std::ceil(u - half_u)));
  const int x1 = std::min(image.width - 1, static_cast<int>(std::floor(u + half_u)));
  const int y0 = std::max(0, static_cast<int>(std::ceil(v - half_v)));
  const int y1 = std::min(image.height - 1, static_cast<int>(std::floor(v + half_v)));
  for (int y = y0; y <= y1; ++y) {
    float* row = image.row(y);
    const float dv = static_cast<float>(y) - v;
    for (int x = x0; x <= x1; ++x) {
      const float du = static_cast<float>(x) - u;
      const float value = inv + inv_du * du + inv_dv * dv;
      const bool inside = m.uu * du * du + 2.0F * m.uv * du * dv + m.vv * dv * dv <= r2;
      row[x] = inside && value > row[x] ? value : row[x];
    }
  }
  const int xc = static_cast<int>(std::lround(u)), yc = static_cast<int>(std::lround(v));
  if (xc >= 0 && yc >= 0 && xc < image.width && yc < image.height) {
    float& center = image.row(yc)[xc];
    const float value = inv + inv_du * (static_cast<float>(xc) - u) + inv_dv * (static_cast<float>(yc) - v);
    center = std::max(center, value);
  }
}

// False where the sphere lies wholly outside the view frustum (its four side planes, and the depth range).
bool in_frustum(const Eigen::Vector3f& c, float r, const PinholeCamera& camera, RenderRange range) {
  if (c.z() + r < range.min_depth_m || c.z() - r > range.max_depth_m) return false;
  const auto outside = [r](float along, float across, float f, float edge) {
    // Plane through the optical centre and the image edge at `edge` pixels from the principal point.
    return along * edge - across * f > r * std::sqrt(f * f + edge * edge);
  };
  const float left = -(camera.cx + 0.5F), right = static_cast<float>(camera.width) - 0.5F - camera.cx;
  const float top = -(camera.cy + 0.5F), bottom = static_cast<float>(camera.height) - 0.5F - camera.cy;
  return !outside(c.z(), c.x(), camera.fx, left) && !outside(-c.z(), -c.x(), camera.fx, right) &&
         !outside(c.z(), c.y(), camera.fy, top) && !outside(-c.z(), -c.y(), camera.fy, bottom);
}

}  // namespace

void render_discs(const ScoreSurfels& surfels, const Se3& T_camera_fragment, const PinholeCamera& camera,
                  float min_depth_m, float max_depth_m, const ImageView<float>& inverse_depth) {
  const Se3f T(T_camera_fragment);
  const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> R = T.R;
  const float K[4] = {camera.fx, camera.fy, camera.cx, camera.cy};
  const RenderRange range{min_depth_m, max_depth_m};
  ProjectedChunk p;
  for (const SurfelChunk& chunk : surfels.chunks) {
    if (!in_frustum(T * chunk.center, chunk.radius, camera, range)) continue;
    const std::uint32_t o = chunk.begin;
    project_chunk(&surfels.x[o], &surfels.y[o], &surfels.z[o], &surfels.nx[o], &surfels.ny[o], &surfels.nz[o],
                  static_cast<int>(chunk.size), R.data(), T.t.data(), K, range, &p);
    for (std::uint32_t k = 0; k < chunk.size; ++k) {
      if (p.visible[k] == 0) continue;
      const DiscMetric m =
          disc_metric(1.0F / p.inv[k], p.a[k], p.b[k], p.inv_du[k], p.inv_dv[k], camera.fx, camera.fy);
      splat(p.u[k], p.v[k], p.inv[k], p.inv_du[k], p.inv_dv[k], m, surfels.radius[o + k], inverse_depth);
    }
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
        const bool center = x == static_cast<int>(std::lround(u)) && y == static_cast<int>(std::lround(v));
        if (!(z > 0) || (!center && (z * ray - p).norm() > surfels.radius[k])) continue;
        inverse_depth(x, y) = std::max(inverse_depth(x, y), 1.0F / z);
      }
    }
  }
}

}  // namespace loopsift
