// SPDX-License-Identifier: MIT
#include "core/fragment/active_surfels.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/simd.hpp"
#include "core/fragment/surfel_math.hpp"
#include "core/odometry/icp.hpp"

namespace loopsift {
namespace {

constexpr float kNearest = 0.1F;         // metres; nearer surfels are not drawn
constexpr int kRemovalPeriod = 10;       // frames between removals
constexpr float kSeenThroughSigmas = 5;  // a surfel this far before the measurement is not there

// Depths and nearest pixels of all surfels; pixel −1 for what is out of sight or faces away.
LOOPSIFT_SIMD void project(const SurfelSpan& s, const PoseFloats& T, const PinholeCamera& camera,
                           float* __restrict depth, std::int32_t* __restrict pixel) {
  const float *x = s.x.data(), *y = s.y.data(), *z = s.z.data();
  const float *nx = s.nx.data(), *ny = s.ny.data(), *nz = s.nz.data();
  // The camera's centre in the surfels' frame: a surfel faces it when n · (c − p) > 0.
  const float cx = -(T.R[0] * T.t[0] + T.R[3] * T.t[1] + T.R[6] * T.t[2]);
  const float cy = -(T.R[1] * T.t[0] + T.R[4] * T.t[1] + T.R[7] * T.t[2]);
  const float cz = -(T.R[2] * T.t[0] + T.R[5] * T.t[1] + T.R[8] * T.t[2]);
  const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
  const std::size_t count = s.size();
  for (std::size_t i = 0; i < count; ++i) {
    const float px = T.R[0] * x[i] + T.R[1] * y[i] + T.R[2] * z[i] + T.t[0];
    const float py = T.R[3] * x[i] + T.R[4] * y[i] + T.R[5] * z[i] + T.t[1];
    const float pz = T.R[6] * x[i] + T.R[7] * y[i] + T.R[8] * z[i] + T.t[2];
    const float facing = nx[i] * (cx - x[i]) + ny[i] * (cy - y[i]) + nz[i] * (cz - z[i]);
    const float inverse_z = 1.0F / std::max(pz, kNearest);
    const float u = camera.fx * px * inverse_z + camera.cx + 0.5F;
    const float v = camera.fy * py * inverse_z + camera.cy + 0.5F;
    const bool seen =
        (pz > kNearest) & (facing > 0.0F) & (u >= 0.0F) & (v >= 0.0F) & (u < width) & (v < height);
    const float su = seen ? u : 0.0F, sv = seen ? v : 0.0F;
    const std::int32_t at = static_cast<std::int32_t>(sv) * camera.width + static_cast<std::int32_t>(su);
    depth[i] = pz;
    pixel[i] = seen ? at : -1;
  }
}

// Colour behind a working pixel; the colour image is taken to show what the depth image shows.
std::uint32_t color_at(const Frame& frame, const PinholeCamera& camera, int x, int y) {
  if (frame.color.empty()) return 0x808080U;
  const int u = (2 * x + 1) * frame.color.width / (2 * camera.width);
  const int v = (2 * y + 1) * frame.color.height / (2 * camera.height);
  const Rgb8 c = frame.color(u, v);
  return static_cast<std::uint32_t>(c.r) << 16 | static_cast<std::uint32_t>(c.g) << 8 | c.b;
}

}  // namespace

ActiveSurfels::ActiveSurfels(const FragmentOptions& options, const PinholeCamera& working, Arena& arena)
    : options_(options), camera_(working) {
  const auto capacity = static_cast<std::size_t>(options.active_capacity);
  const auto pixels = static_cast<std::size_t>(working.width) * static_cast<std::size_t>(working.height);
  surfels_ = carve_surfels(arena, "fragment/active surfels", capacity);
  seen_ = arena.carve<std::uint16_t>("fragment/active surfels", capacity);
  index_ = arena.carve<std::int32_t>("fragment/index map", pixels);
  index_depth_ = arena.carve<float>("fragment/index map", pixels);
  projected_ = arena.carve<float>("fragment/index map", capacity);
  pixel_ = arena.carve<std::int32_t>("fragment/index map", capacity);
}

void ActiveSurfels::fuse(const Frame& frame, const Se3& T_fragment_camera) {
  draw_index_map(T_fragment_camera);
  const Se3f T(T_fragment_camera);
  for (int y = 1; y < camera_.height - 1; ++y)
    for (int x = 1; x < camera_.width - 1; ++x) fuse_pixel(frame, T, x, y);
  high_water_ = std::max(high_water_, count_);
  if (frame_ % kRemovalPeriod == 0) remove_unconfirmed();
  ++frame_;
}

void ActiveSurfels::draw_index_map(const Se3& T_fragment_camera) {
  std::fill(index_.begin(), index_.end(), -1);
  project(surfels(), PoseFloats(Se3f(T_fragment_camera.inverse())), camera_, projected_.data(),
          pixel_.data());
  for (std::size_t i = 0; i < count_; ++i) {
    if (pixel_[i] < 0) continue;
    const auto k = static_cast<std::size_t>(pixel_[i]);
    if (index_[k] >= 0 && index_depth_[k] <= projected_[i]) continue;
    index_[k] = static_cast<std::int32_t>(i);
    index_depth_[k] = projected_[i];
  }
}

void ActiveSurfels::fuse_pixel(const Frame& frame, const Se3f& T_fragment_camera, int x, int y) {
  const FrameLevel& level = frame.levels[0];
  const float z = level.depth_m(x, y);
  if (z <= 0.0F) return;
  wear_down(frame, x, y);
  const Eigen::Vector3f normal(level.nx(x, y), level.ny(x, y), level.nz(x, y));
  const Eigen::Vector3f point = camera_.unproject(static_cast<float>(x), static_cast<float>(y), z);
  const float cosine = -normal.dot(point) / point.norm();
  if (cosine < options_.min_view_cosine) return;  // also where there is no normal
  const float sigma = depth_sigma(z, options_.noise_floor_m, options_.noise_slope);
  const float relative = options_.noise_floor_m / sigma;
  Measurement m;
  m.point = T_fragment_camera * point;
  m.normal = T_fragment_camera.R * normal;
  m.depth = z;
  m.weight = relative * relative;
  m.radius =
      0.7071F * z / (camera_.fx * std::max(cosine, 0.5F));  // Keller et al. 2013, half a pixel's diagonal
  m.rgb = color_at(frame, camera_, x, y);
  m.frame = frame_;
  const std::int32_t surfel = find(x, y, z, m.normal);
  if (surfel >= 0) {
    update(static_cast<std::size_t>(surfel), m);
  } else {
    add(m);
  }
}

// The pixel's own surfel if it agrees, else a neighbour's: side neighbours before diagonal ones.
std::int32_t ActiveSurfels::find(int x, int y, float depth, const Eigen::Vector3f& normal) const {
  static constexpr int kOffsets[9][2] = {{0, 0},   {-1, 0}, {1, 0},  {0, -1}, {0, 1},
                                         {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
  const float reach =
      options_.merge_distance_sigmas * depth_sigma(depth, options_.noise_floor_m, options_.noise_slope) +
      depth / camera_.fx;
  for (const auto& offset : kOffsets) {
    const std::size_t k = static_cast<std::size_t>(y + offset[1]) * static_cast<std::size_t>(camera_.width) +
                          static_cast<std::size_t>(x + offset[0]);
    const std::int32_t i = index_[k];
    if (i < 0 || std::fabs(index_depth_[k] - depth) > reach) continue;
    const auto s = static_cast<std::size_t>(i);
    const float cosine =
        surfels_.nx[s] * normal.x() + surfels_.ny[s] * normal.y() + surfels_.nz[s] * normal.z();
    if (cosine > options_.min_normal_cosine) return i;
  }
  return -1;
}

// Weighted means; the position moves along the normal only, so that surfels do not crowd together sideways.
void ActiveSurfels::update(std::size_t s, const Measurement& m) {
  const float old = surfels_.weight[s], sum = old + m.weight, a = old / sum, b = m.weight / sum;
  const Eigen::Vector3f normal(surfels_.nx[s], surfels_.ny[s], surfels_.nz[s]);
  const Eigen::Vector3f position(surfels_.x[s], surfels_.y[s], surfels_.z[s]);
  const Eigen::Vector3f moved = position + b * normal.dot(m.point - position) * normal;
  const Eigen::Vector3f turned = (a * normal + b * m.normal).normalized();
  surfels_.x[s] = moved.x();
  surfels_.y[s] = moved.y();
  surfels_.z[s] = moved.z();
  surfels_.nx[s] = turned.x();
  surfels_.ny[s] = turned.y();
  surfels_.nz[s] = turned.z();
  surfels_.radius[s] = std::min(surfels_.radius[s], m.radius);
  surfels_.rgb[s] = blend_rgb(surfels_.rgb[s], m.rgb, a);
  surfels_.weight[s] = sum;
  if (surfels_.last_frame[s] != m.frame && seen_[s] < 65535) ++seen_[s];
  surfels_.last_frame[s] = m.frame;
}

void ActiveSurfels::add(const Measurement& m) {
  if (count_ == surfels_.size()) {
    ++refused_;
    return;
  }
  const std::size_t s = count_++;
  surfels_.x[s] = m.point.x();
  surfels_.y[s] = m.point.y();
  surfels_.z[s] = m.point.z();
  surfels_.nx[s] = m.normal.x();
  surfels_.ny[s] = m.normal.y();
  surfels_.nz[s] = m.normal.z();
  surfels_.radius[s] = m.radius;
  surfels_.weight[s] = m.weight;
  surfels_.rgb[s] = m.rgb;
  surfels_.first_frame[s] = surfels_.last_frame[s] = m.frame;
  seen_[s] = 1;
}

// The camera sees through the surfel of this pixel when all nine pixels around it measure farther away. Its
// confidence halves each time; at the end of its count it is gone at the next removal.
void ActiveSurfels::wear_down(const Frame& frame, int x, int y) {
  const std::size_t k =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) + static_cast<std::size_t>(x);
  if (index_[k] < 0) return;
  const float z = frame.levels[0].depth_m(x, y);
  const float limit = index_depth_[k] +
                      kSeenThroughSigmas * depth_sigma(z, options_.noise_floor_m, options_.noise_slope) +
                      0.02F * z;
  if (z <= limit) return;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (frame.levels[0].depth_m(x + dx, y + dy) <= limit) return;  // also where nothing was measured
  const auto s = static_cast<std::size_t>(index_[k]);
  surfels_.weight[s] *= 0.5F;
  if (seen_[s] > 0) --seen_[s];
}

template <class Keep>
void ActiveSurfels::compact(Keep keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!keep(i)) continue;
    if (kept != i) {
      move_surfel(surfels_, i, kept);
      seen_[kept] = seen_[i];
    }
    ++kept;
  }
  count_ = kept;
}

void ActiveSurfels::remove_unconfirmed() {
  compact([&](std::size_t i) {
    const bool young = frame_ - surfels_.first_frame[i] < options_.max_unconfirmed_frames;
    return seen_[i] > 0 && (young || seen_[i] >= options_.min_frames_seen);
  });
}

void ActiveSurfels::drop_seldom_seen(int min_frames) {
  compact([&](std::size_t i) { return seen_[i] >= min_frames; });
}

}  // namespace loopsift
