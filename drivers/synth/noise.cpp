// SPDX-License-Identifier: MIT
#include "drivers/synth/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/synth/random.hpp"

namespace loopsift {
namespace {

constexpr float kEdge = 0.05F;          // two depths within this (times 1 + z in metres) are one surface
constexpr float kShadowSlackPx = 1.5F;  // steep surfaces are no shadows

bool same_surface(float a, float b) {
  return a > 0.0F && b > 0.0F && std::abs(a - b) < kEdge * (1.0F + std::min(a, b));
}

/// A polynomial of degree three over the image with random coefficients, scaled to a largest value of 1.
std::vector<float> distortion_pattern(const PinholeCamera& camera, std::uint64_t seed) {
  std::array<float, 9> c{};
  for (std::size_t k = 0; k < c.size(); ++k) c[k] = 2.0F * uniform(mix(seed, 1000 + k)) - 1.0F;
  std::vector<float> pattern;
  float largest = 1e-6F;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const float x = 2.0F * static_cast<float>(u) / static_cast<float>(camera.width) - 1.0F;
      const float y = 2.0F * static_cast<float>(v) / static_cast<float>(camera.height) - 1.0F;
      const float p = c[0] * x + c[1] * y + c[2] * x * x + c[3] * x * y + c[4] * y * y + c[5] * x * x * x +
                      c[6] * x * x * y + c[7] * x * y * y + c[8] * y * y * y;
      pattern.push_back(p);
      largest = std::max(largest, std::abs(p));
    }
  for (float& p : pattern) p /= largest;
  return pattern;
}

unsigned char add_noise(unsigned char value, float noise) {
  return static_cast<unsigned char>(std::clamp(static_cast<float>(value) + noise + 0.5F, 0.0F, 255.0F));
}

}  // namespace

NoiseModel::NoiseModel(const PinholeCamera& camera, const NoiseSettings& settings)
    : camera_(camera), settings_(settings), distortion_(distortion_pattern(camera, settings.seed)) {}

/// The depth half a pixel away or so, interpolated within a surface and never across an edge.
float NoiseModel::jittered(const RenderedFrame& frame, int u, int v, std::uint64_t bits) const {
  const float x =
      static_cast<float>(u) + settings_.lateral_sigma_px * gaussian(static_cast<std::uint32_t>(bits));
  const float y =
      static_cast<float>(v) + settings_.lateral_sigma_px * gaussian(static_cast<std::uint32_t>(bits >> 32));
  const int x0 = std::clamp(static_cast<int>(x), 0, camera_.width - 2);
  const int y0 = std::clamp(static_cast<int>(y), 0, camera_.height - 2);
  const float sx = std::clamp(x - static_cast<float>(x0), 0.0F, 1.0F);
  const float sy = std::clamp(y - static_cast<float>(y0), 0.0F, 1.0F);
  const float* d = frame.depth.data() + static_cast<std::ptrdiff_t>(y0) * camera_.width + x0;
  const float a = d[0], b = d[1], c = d[camera_.width], e = d[camera_.width + 1];
  if (!same_surface(a, e) || !same_surface(b, c) || !same_surface(a, b))
    return sy < 0.5F ? (sx < 0.5F ? a : b) : (sx < 0.5F ? c : e);
  return (1.0F - sy) * ((1.0F - sx) * a + sx * b) + sy * ((1.0F - sx) * c + sx * e);
}

/// Whether the pattern's light comes back from this pixel; `chance` is uniform in [0, 1).
bool NoiseModel::keeps(const RenderedFrame& frame, int u, int v, float chance) const {
  const std::ptrdiff_t w = camera_.width, i = v * w + u;
  const float* d = frame.depth.data() + i;
  const float cosine = frame.cosine[static_cast<std::size_t>(i)];
  const float none = settings_.grazing_cosine_none, all = settings_.grazing_cosine_all;
  if (cosine < none + chance * (all - none)) return false;
  const bool inside = u >= 2 && v >= 2 && u < camera_.width - 2 && v < camera_.height - 2;
  const bool at_edge = inside && !(same_surface(d[-2], d[0]) && same_surface(d[2], d[0]) &&
                                   same_surface(d[-2 * w], d[0]) && same_surface(d[2 * w], d[0]));
  return !at_edge || chance >= settings_.edge_dropout;
}

float NoiseModel::distorted(float depth, int u, int v) const {
  return settings_.distortion ? depth * (1.0F + settings_.distortion_per_m * depth * distortion(u, v))
                              : depth;
}

void NoiseModel::row_with_noise(const RenderedFrame& frame, std::uint64_t salt, int v,
                                std::uint16_t* out) const {
  const float fb = camera_.fx * settings_.baseline_m;
  const float steps_per_px = 1.0F / settings_.disparity_step_px;
  const auto units_per_m = static_cast<float>(1.0 / settings_.depth_unit_m);
  const float* exact = frame.depth.data() + static_cast<std::ptrdiff_t>(v) * camera_.width;
  float lit_to = -1e9F;  // the projector's rays up to this column have met a surface further left
  for (int u = 0; u < camera_.width; ++u) {
    out[u] = 0;
    if (exact[u] <= 0.0F) continue;
    const float projector_column = static_cast<float>(u) + fb / exact[u];
    const bool shadowed = projector_column < lit_to - kShadowSlackPx;
    lit_to = std::max(lit_to, projector_column);
    const std::uint64_t bits = mix(salt, static_cast<std::uint64_t>(v * camera_.width + u));
    const std::uint64_t more = mix(bits, 1);
    if (shadowed || !keeps(frame, u, v, uniform(more))) continue;
    const float depth = distorted(jittered(frame, u, v, bits), u, v);
    if (!(depth > 0.0F)) continue;
    const float steps = steps_per_px * fb / depth +
                        settings_.disparity_sigma_steps * gaussian(static_cast<std::uint32_t>(more));
    const float measured =
        steps_per_px * fb / static_cast<float>(std::max(1, static_cast<int>(steps + 0.5F)));
    if (measured < settings_.min_depth_m || measured > settings_.max_depth_m) continue;
    out[u] = static_cast<std::uint16_t>(std::min(65535.0F, measured * units_per_m + 0.5F));
  }
}

void NoiseModel::apply_depth(const RenderedFrame& frame, std::uint64_t frame_number,
                             ImageView<std::uint16_t> out) const {
  const std::uint64_t salt = mix(settings_.seed, 2 * frame_number);
  const auto units_per_m = static_cast<float>(1.0 / settings_.depth_unit_m);
  for (int v = 0; v < camera_.height; ++v) {
    if (settings_.noise) {
      row_with_noise(frame, salt, v, out.row(v));
      continue;
    }
    const float* exact = frame.depth.data() + static_cast<std::ptrdiff_t>(v) * camera_.width;
    for (int u = 0; u < camera_.width; ++u) {
      const float raw = distorted(exact[u], u, v) * units_per_m + 0.5F;
      out(u, v) = raw < 65535.0F ? static_cast<std::uint16_t>(raw) : 0;
    }
  }
}

void NoiseModel::apply_color(const RenderedFrame& frame, std::uint64_t frame_number,
                             ImageView<Rgb8> out) const {
  const std::uint64_t salt = mix(settings_.seed, 2 * frame_number + 1);
  for (int v = 0; v < camera_.height; ++v)
    for (int u = 0; u < camera_.width; ++u) {
      const auto i = static_cast<std::size_t>(v * camera_.width + u);
      Rgb8 c = frame.color[i];
      if (settings_.noise) {
        const std::uint64_t bits = mix(salt, i), more = mix(bits, 1);
        c.r = add_noise(c.r, settings_.color_sigma * gaussian(static_cast<std::uint32_t>(bits)));
        c.g = add_noise(c.g, settings_.color_sigma * gaussian(static_cast<std::uint32_t>(bits >> 32)));
        c.b = add_noise(c.b, settings_.color_sigma * gaussian(static_cast<std::uint32_t>(more)));
      }
      out(u, v) = c;
    }
}

}  // namespace loopsift
