// SPDX-License-Identifier: MIT
#include "core/fragment/model_renderer.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/simd.hpp"

namespace loopsift {
namespace {

constexpr std::size_t kBatch = 256;     // surfels transformed at a time
constexpr float kGeneration = 1024.0F;  // above any squared pixel distance of a splat
constexpr float kNearest = 0.1F;        // metres; nearer surfels are behind or in the lens

// Surfels in the view: positions, normals, pixels and splat radii; radius −1 for what is out of sight.
struct Batch {
  alignas(32) float x[kBatch], y[kBatch], z[kBatch], nx[kBatch], ny[kBatch], nz[kBatch];
  alignas(32) float u[kBatch], v[kBatch], radius[kBatch];
};

struct Pose {
  float R[9], t[3];
};

LOOPSIFT_SIMD void transform(const SurfelSpan& s, std::size_t begin, std::size_t count, const Pose& T,
                             const PinholeCamera& camera, Batch& __restrict out) {
  const float *x = s.x.data() + begin, *y = s.y.data() + begin, *z = s.z.data() + begin;
  const float *nx = s.nx.data() + begin, *ny = s.ny.data() + begin, *nz = s.nz.data() + begin;
  const float* radius = s.radius.data() + begin;
  const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
  for (std::size_t i = 0; i < count; ++i) {
    const float px = T.R[0] * x[i] + T.R[1] * y[i] + T.R[2] * z[i] + T.t[0];
    const float py = T.R[3] * x[i] + T.R[4] * y[i] + T.R[5] * z[i] + T.t[1];
    const float pz = T.R[6] * x[i] + T.R[7] * y[i] + T.R[8] * z[i] + T.t[2];
    const float mx = T.R[0] * nx[i] + T.R[1] * ny[i] + T.R[2] * nz[i];
    const float my = T.R[3] * nx[i] + T.R[4] * ny[i] + T.R[5] * nz[i];
    const float mz = T.R[6] * nx[i] + T.R[7] * ny[i] + T.R[8] * nz[i];
    const float inverse_z = 1.0F / std::max(pz, kNearest);
    const float u = camera.fx * px * inverse_z + camera.cx, v = camera.fy * py * inverse_z + camera.cy;
    const float r = radius[i] * camera.fx * inverse_z;
    const bool seen = (pz > kNearest) & (mx * px + my * py + mz * pz < 0.0F) & (u > -0.5F - r) &
                      (v > -0.5F - r) & (u < width - 0.5F + r) & (v < height - 0.5F + r);
    out.x[i] = px;
    out.y[i] = py;
    out.z[i] = pz;
    out.nx[i] = mx;
    out.ny[i] = my;
    out.nz[i] = mz;
    out.u[i] = u;
    out.v[i] = v;
    out.radius[i] = seen ? r : -1.0F;
  }
}

Pose to_pose(const Se3& T) {
  Pose pose{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.R[3 * r + c] = static_cast<float>(T.rotation()(r, c));
    pose.t[r] = static_cast<float>(T.translation()[r]);
  }
  return pose;
}

}  // namespace

Status validate(const ModelOptions& o) {
  const auto out_of_range = [](const char* key, const char* range) {
    return Error{ErrorCode::kUsage, std::string("model.") + key + " must be " + range};
  };
  if (o.fragments < 0) return out_of_range("fragments", "0 or more");
  if (o.step < 1) return out_of_range("step", "1 or more");
  if (!(o.same_surface_m > 0)) return out_of_range("same_surface_m", "more than 0");
  if (o.max_splat_radius < 0 || o.max_splat_radius > 16)
    return out_of_range("max_splat_radius", "from 0 to 16");
  return {};
}

ModelRenderer::ModelRenderer(const ModelOptions& options, const PinholeCamera& working, Arena& arena)
    : options_(options) {
  const PinholeCamera camera = working.block_averaged(options.step);
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  for (Span<float>* image : {&x_, &y_, &z_, &nx_, &ny_, &nz_, &priority_})
    *image = arena.carve<float>("fragment/model view", pixels);
  const auto view = [&](const Span<float>& image) {
    return ImageView<const float>(image.data(), camera.width, camera.height);
  };
  view_ = {camera, Se3(), view(x_), view(y_), view(z_), view(nx_), view(ny_), view(nz_)};
}

const ModelView& ModelRenderer::render(Span<const Fragment> closed, const SurfelSpan& active,
                                       const Se3& T_odom_active, const Se3& T_odom_view) {
  view_.T_odom_view = T_odom_view;
  std::fill(z_.begin(), z_.end(), 0.0F);
  const Se3 T_view_odom = T_odom_view.inverse();
  const std::size_t reach = std::min(closed.size(), static_cast<std::size_t>(options_.fragments));
  float generation = 0.0F;
  for (std::size_t f = closed.size() - reach; f < closed.size(); ++f, generation += kGeneration)
    splat(closed[f].surfels, T_view_odom * closed[f].T_odom_fragment, generation);
  splat(active, T_view_odom * T_odom_active, generation);
  return view_;
}

void ModelRenderer::splat(const SurfelSpan& surfels, const Se3& T_view_surfels, float generation) {
  const Pose pose = to_pose(T_view_surfels);
  const PinholeCamera camera = view_.camera;
  Batch batch;
  const auto limit = static_cast<float>(options_.max_splat_radius);
  for (std::size_t begin = 0; begin < surfels.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, surfels.size() - begin);
    transform(surfels, begin, count, pose, camera, batch);
    for (std::size_t i = 0; i < count; ++i) {
      if (batch.radius[i] < 0.0F) continue;
      const float r = std::min(batch.radius[i], limit);
      const int x0 = std::max(0, static_cast<int>(std::lround(batch.u[i] - r)));
      const int x1 = std::min(camera.width - 1, static_cast<int>(std::lround(batch.u[i] + r)));
      const int y0 = std::max(0, static_cast<int>(std::lround(batch.v[i] - r)));
      const int y1 = std::min(camera.height - 1, static_cast<int>(std::lround(batch.v[i] + r)));
      for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
          const float du = static_cast<float>(x) - batch.u[i], dv = static_cast<float>(y) - batch.v[i];
          const float priority = generation + du * du + dv * dv;
          const std::size_t k = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                                static_cast<std::size_t>(x);
          if (!stands_before(batch.z[i], priority, k)) continue;
          x_[k] = batch.x[i];
          y_[k] = batch.y[i];
          z_[k] = batch.z[i];
          nx_[k] = batch.nx[i];
          ny_[k] = batch.ny[i];
          nz_[k] = batch.nz[i];
          priority_[k] = priority;
        }
      }
    }
  }
}

bool ModelRenderer::stands_before(float z, float priority, std::size_t pixel) const {
  const float other = z_[pixel];
  if (other == 0.0F || z < other - options_.same_surface_m) return true;
  return z <= other + options_.same_surface_m && priority < priority_[pixel];
}

}  // namespace loopsift
