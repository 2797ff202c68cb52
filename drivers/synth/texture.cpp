// SPDX-License-Identifier: MIT
#include "drivers/synth/texture.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "drivers/synth/random.hpp"

namespace loopsift {
namespace {

constexpr int kSize = 256;  // texels along one period
constexpr int kPatterns = 6;

float smooth(float t) { return t * t * (3.0F - 2.0F * t); }

/// Lattice noise in [0, 1] with `cells_x` × `cells_y` cells per period.
float lattice_noise(float x, float y, int cells_x, int cells_y, std::uint64_t salt) {
  const float fx = x * static_cast<float>(cells_x), fy = y * static_cast<float>(cells_y);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const float sx = smooth(fx - static_cast<float>(ix)), sy = smooth(fy - static_cast<float>(iy));
  const auto corner = [&](int dx, int dy) {
    const auto cx = static_cast<std::uint64_t>((ix + dx) % cells_x);
    const auto cy = static_cast<std::uint64_t>((iy + dy) % cells_y);
    return uniform(mix(salt, cy * 4096 + cx));
  };
  const float top = corner(0, 0) + sx * (corner(1, 0) - corner(0, 0));
  const float bottom = corner(0, 1) + sx * (corner(1, 1) - corner(0, 1));
  return top + sy * (bottom - top);
}

float mottled(float x, float y) {
  return 0.45F * lattice_noise(x, y, 6, 6, 1) + 0.33F * lattice_noise(x, y, 14, 14, 2) +
         0.22F * lattice_noise(x, y, 30, 30, 3);
}

float wood(float x, float y) {
  return 0.6F * lattice_noise(x, y, 2, 24, 4) + 0.4F * lattice_noise(x, y, 5, 60, 5);
}

float tiles(float x, float y) {
  const float fx = x * 4.0F, fy = y * 4.0F;
  const float dx = fx - std::floor(fx), dy = fy - std::floor(fy);
  if (dx < 0.04F || dy < 0.04F) return 1.0F;
  const auto cell = static_cast<std::uint64_t>(static_cast<int>(fx) * 16 + static_cast<int>(fy));
  return 0.45F * uniform(mix(6, cell)) + 0.25F * lattice_noise(x, y, 28, 28, 7);
}

float stripes(float x, float y) {
  return 0.5F + 0.35F * std::sin(6.2831853F * 5.0F * x) +
         0.15F * (2.0F * lattice_noise(x, y, 24, 24, 8) - 1.0F);
}

float picture(float x, float y) {
  const float v = 0.6F * lattice_noise(x, y, 5, 5, 9) + 0.4F * lattice_noise(x, y, 17, 17, 10);
  return std::min(1.0F, std::max(0.0F, (v - 0.25F) * 2.0F));
}

using Table = std::vector<float>;

std::array<Table, kPatterns> make_tables() {
  std::array<Table, kPatterns> tables;
  constexpr std::array<float (*)(float, float), kPatterns> kFunctions = {nullptr, mottled, wood,
                                                                         tiles,   stripes, picture};
  for (std::size_t k = 1; k < kPatterns; ++k) {
    tables[k].resize(kSize * kSize);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        tables[k][static_cast<std::size_t>(y * kSize + x)] =
            kFunctions[k](static_cast<float>(x) / kSize, static_cast<float>(y) / kSize);
  }
  return tables;
}

/// Bilinear and periodic; x, y in periods, above −kLift.
float lookup(const Table& table, float x, float y) {
  constexpr float kLift = 64.0F;  // makes the cast to int round down
  const float fx = (x + kLift) * kSize, fy = (y + kLift) * kSize;
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const float sx = fx - static_cast<float>(ix), sy = fy - static_cast<float>(iy);
  const auto at = [&](int dx, int dy) {
    return table[static_cast<std::size_t>(((iy + dy) & (kSize - 1)) * kSize + ((ix + dx) & (kSize - 1)))];
  };
  const float top = at(0, 0) + sx * (at(1, 0) - at(0, 0));
  const float bottom = at(0, 1) + sx * (at(1, 1) - at(0, 1));
  return top + sy * (bottom - top);
}

}  // namespace

Eigen::Vector3f sample_material(const Material& material, float u_m, float v_m) {
  if (material.pattern == Pattern::kPlain) return material.base;
  static const std::array<Table, kPatterns> tables = make_tables();
  const Table& table = tables[static_cast<std::size_t>(material.pattern)];
  const float x = u_m / material.tile_m, y = v_m / material.tile_m;
  Eigen::Vector3f blend = Eigen::Vector3f::Constant(lookup(table, x, y));
  if (material.pattern == Pattern::kPicture) {
    blend.y() = lookup(table, x + 0.37F, y + 0.11F);
    blend.z() = lookup(table, x + 0.71F, y + 0.53F);
  }
  return material.base + blend.cwiseProduct(material.accent - material.base);
}

}  // namespace loopsift
