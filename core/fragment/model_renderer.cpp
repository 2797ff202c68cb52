// SPDX-License-Identifier: MIT
#include "core/fragment/model_renderer.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/simd.hpp"
#include "core/fragment/surfel_math.hpp"

namespace loopsift {
namespace {

constexpr std::size_t kBatch = 256;     // surfels transformed at a time
constexpr float kGeneration = 1024.0F;  // above any squared pixel distance of a splat
constexpr float kNearest = 0.1F;        // metres; nearer surfels are behind or in the lens
constexpr float kSliver = 0.05F;        // of a view: a part that does not decide how well it is known

// Pixels, depths and splat radii of surfels in the view; radius −1 for what is out of sight or faces away.
struct Batch {
  alignas(32) float z[kBatch], u[kBatch], v[kBatch], radius[kBatch];
};

LOOPSIFT_SIMD void project(const SurfelSpan& s, std::size_t begin, std::size_t count, const PoseFloats& T,
                           const PinholeCamera& camera, Batch& __restrict out) {
  const float *x = s.x.data() + begin, *y = s.y.data() + begin, *z = s.z.data() + begin;
  const float *nx = s.nx.data() + begin, *ny = s.ny.data() + begin, *nz = s.nz.data() + begin;
  const float* radius = s.radius.data() + begin;
  // The view's centre in the surfels' frame: a surfel faces it when n · (c − p) > 0.
  const float cx = -(T.R[0] * T.t[0] + T.R[3] * T.t[1] + T.R[6] * T.t[2]);
  const float cy = -(T.R[1] * T.t[0] + T.R[4] * T.t[1] + T.R[7] * T.t[2]);
  const float cz = -(T.R[2] * T.t[0] + T.R[5] * T.t[1] + T.R[8] * T.t[2]);
  const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
  for (std::size_t i = 0; i < count; ++i) {
    const float px = T.R[0] * x[i] + T.R[1] * y[i] + T.R[2] * z[i] + T.t[0];
    const float py = T.R[3] * x[i] + T.R[4] * y[i] + T.R[5] * z[i] + T.t[1];
    const float pz = T.R[6] * x[i] + T.R[7] * y[i] + T.R[8] * z[i] + T.t[2];
    const float facing = nx[i] * (cx - x[i]) + ny[i] * (cy - y[i]) + nz[i] * (cz - z[i]);
    const float inverse_z = 1.0F / std::max(pz, kNearest);
    const float u = camera.fx * px * inverse_z + camera.cx, v = camera.fy * py * inverse_z + camera.cy;
    const float r = radius[i] * camera.fx * inverse_z;
    const bool seen = (pz > kNearest) & (facing > 0.0F) & (u > -0.5F - r) & (v > -0.5F - r) &
                      (u < width - 0.5F + r) & (v < height - 0.5F + r);
    out.z[i] = pz;
    out.u[i] = u;
    out.v[i] = v;
    out.radius[i] = seen ? r : -1.0F;
  }
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
  const PinholeCamera camera = options.step > 1 ? working.block_averaged(options.step) : working;
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  pixels_ = arena.carve<Pixel>("fragment/model view", pixels);
  layers_ = arena.carve<Layer>("fragment/model view", static_cast<std::size_t>(options.fragments) + 1);
  for (Span<float>* image : {&x_, &y_, &z_, &nx_, &ny_, &nz_})
    *image = arena.carve<float>("fragment/model view", pixels);
  const auto view = [&](const Span<float>& image) {
    return ImageView<const float>(image.data(), camera.width, camera.height);
  };
  view_ = {camera, Se3(), view(x_), view(y_), view(z_), view(nx_), view(ny_), view(nz_)};
}

const ModelView& ModelRenderer::render(Span<const Fragment> closed, const SurfelSpan& active,
                                       const Se3& T_odom_active, const Se3& T_odom_view,
                                       float active_unknown) {
  view_.T_odom_view = T_odom_view;
  std::fill(pixels_.begin(), pixels_.end(), Pixel{});
  const Se3 T_view_odom = T_odom_view.inverse();
  const std::size_t reach = std::min(closed.size(), static_cast<std::size_t>(options_.fragments));
  for (std::size_t k = 0; k < reach; ++k) {
    const Fragment& fragment = closed[closed.size() - reach + k];
    layers_[k] = {fragment.surfels, Se3f(T_view_odom * fragment.T_odom_fragment), fragment.disparity_unknown,
                  0};
  }
  layers_[reach] = {active, Se3f(T_view_odom * T_odom_active), active_unknown, 0};
  for (std::size_t k = 0; k <= reach; ++k) splat(layers_[k], static_cast<std::uint32_t>(k));
  resolve();
  view_.disparity_unknown = least_known(reach + 1);
  return view_;
}

void ModelRenderer::splat(const Layer& layer, std::uint32_t index) {
  const PoseFloats pose(layer.T_view_surfels);
  const PinholeCamera camera = view_.camera;
  const float limit = static_cast<float>(options_.max_splat_radius), same = options_.same_surface_m;
  const float generation = kGeneration * static_cast<float>(index);
  Batch batch;
  for (std::size_t begin = 0; begin < layer.surfels.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, layer.surfels.size() - begin);
    project(layer.surfels, begin, count, pose, camera, batch);
    for (std::size_t i = 0; i < count; ++i) {
      if (batch.radius[i] < 0.0F) continue;
      const float u = batch.u[i], v = batch.v[i], z = batch.z[i], r = std::min(batch.radius[i], limit);
      const int x0 = std::max(0, static_cast<int>(u - r + 0.5F));
      const int x1 = std::min(camera.width - 1, static_cast<int>(u + r + 0.5F));
      const int y0 = std::max(0, static_cast<int>(v - r + 0.5F));
      const int y1 = std::min(camera.height - 1, static_cast<int>(v + r + 0.5F));
      for (int y = y0; y <= y1; ++y) {
        Pixel* row = pixels_.data() + static_cast<std::ptrdiff_t>(y) * camera.width;
        const float dv = static_cast<float>(y) - v;
        for (int x = x0; x <= x1; ++x) {
          const float du = static_cast<float>(x) - u, priority = generation + du * du + dv * dv;
          const float other = row[x].z;
          // Clearly in front, or on the same surface but of an older fragment or nearer to the pixel.
          if (other == 0.0F || z < other - same || (z <= other + same && priority < row[x].priority))
            row[x] = {z, priority, index, static_cast<std::uint32_t>(begin + i)};
        }
      }
    }
  }
}

void ModelRenderer::resolve() {
  for (std::size_t k = 0; k < pixels_.size(); ++k) {
    const Pixel& pixel = pixels_[k];
    z_[k] = pixel.z;
    if (pixel.z == 0.0F) continue;
    Layer& layer = layers_[pixel.layer];
    ++layer.pixels;
    const SurfelSpan& s = layer.surfels;
    const std::size_t i = pixel.surfel;
    const Eigen::Vector3f p = layer.T_view_surfels * Eigen::Vector3f(s.x[i], s.y[i], s.z[i]);
    const Eigen::Vector3f n = layer.T_view_surfels.R * Eigen::Vector3f(s.nx[i], s.ny[i], s.nz[i]);
    x_[k] = p.x();
    y_[k] = p.y();
    nx_[k] = n.x();
    ny_[k] = n.y();
    nz_[k] = n.z();
  }
}

// Of the parts that are more than a sliver of the view.
float ModelRenderer::least_known(std::size_t layers) const {
  int seen = 0;
  for (std::size_t k = 0; k < layers; ++k) seen += layers_[k].pixels;
  float unknown = 0.0F;
  for (std::size_t k = 0; k < layers; ++k)
    if (static_cast<float>(layers_[k].pixels) > kSliver * static_cast<float>(seen))
      unknown = std::max(unknown, layers_[k].disparity_unknown);
  return unknown;
}

}  // namespace loopsift
