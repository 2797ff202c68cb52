// SPDX-License-Identifier: MIT
#include "core/posterior/score_surfels.hpp"

#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {

// Bits of the three voxel coordinates interleaved (Morton order), so that sorting by key keeps neighbours
// together.
std::uint64_t spread_bits(std::uint64_t v) {
  v &= 0x7ffffU;  // 19 bits per axis: ±26 km at 10 cm
  v = (v | v << 32U) & 0x1f00000000ffffULL;
  v = (v | v << 16U) & 0x1f0000ff0000ffULL;
  v = (v | v << 8U) & 0x100f00f00f00f00fULL;
  v = (v | v << 4U) & 0x10c30c30c30c30c3ULL;
  return (v | v << 2U) & 0x1249249249249249ULL;
}

// Which of six axis directions the normal is closest to.
std::uint64_t facing(float nx, float ny, float nz) {
  const float ax = std::abs(nx), ay = std::abs(ny), az = std::abs(nz);
  if (ax >= ay && ax >= az) return nx > 0 ? 0 : 1;
  if (ay >= az) return ny > 0 ? 2 : 3;
  return nz > 0 ? 4 : 5;
}

std::uint64_t voxel_key(const SurfelSpan& s, std::size_t k, float inverse_spacing) {
  const auto cell = [inverse_spacing](float v) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v * inverse_spacing)) + (1 << 18));
  };
  const std::uint64_t morton =
      spread_bits(cell(s.x[k])) | spread_bits(cell(s.y[k])) << 1U | spread_bits(cell(s.z[k])) << 2U;
  return morton << 3U | facing(s.nx[k], s.ny[k], s.nz[k]);
}

struct Mean {
  Eigen::Vector3f position = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
  float weight = 0;
};

void write_disc(const Mean& m, float radius_m, std::size_t n, ScoreSurfels* out) {
  const Eigen::Vector3f p = m.position / m.weight, normal = m.normal.normalized();
  out->x[n] = p.x(), out->y[n] = p.y(), out->z[n] = p.z();
  out->nx[n] = normal.x(), out->ny[n] = normal.y(), out->nz[n] = normal.z();
  out->radius[n] = radius_m;
}

void shorten(std::size_t n, ScoreSurfels* s) {
  for (Span<float>* a : {&s->x, &s->y, &s->z, &s->nx, &s->ny, &s->nz, &s->radius}) *a = a->first(n);
  s->chunks = s->chunks.first((n + kChunkSize - 1) / kChunkSize);
}

}  // namespace

void bound_chunks(ScoreSurfels* s) {
  for (std::size_t c = 0; c < s->chunks.size(); ++c) {
    SurfelChunk& chunk = s->chunks[c];
    chunk.begin = static_cast<std::uint32_t>(c * kChunkSize);
    chunk.size = static_cast<std::uint32_t>(std::min(kChunkSize, s->size() - c * kChunkSize));
    chunk.center.setZero();
    const auto position = [&](std::uint32_t k) { return Eigen::Vector3f(s->x[k], s->y[k], s->z[k]); };
    for (std::uint32_t k = chunk.begin; k < chunk.begin + chunk.size; ++k) chunk.center += position(k);
    chunk.center /= static_cast<float>(chunk.size);
    chunk.radius = 0;
    for (std::uint32_t k = chunk.begin; k < chunk.begin + chunk.size; ++k) {
      chunk.radius = std::max(chunk.radius, (position(k) - chunk.center).norm() + s->radius[k]);
    }
  }
}

std::size_t thin(const SurfelSpan& surfels, float spacing_m, float radius_m, ThinScratch* scratch,
                 ScoreSurfels* out) {
  auto& keyed = scratch->keyed;
  keyed.clear();
  keyed.reserve(surfels.size());
  for (std::size_t k = 0; k < surfels.size(); ++k) {
    keyed.emplace_back(voxel_key(surfels, k, 1.0F / spacing_m), static_cast<std::uint32_t>(k));
  }
  std::sort(keyed.begin(), keyed.end());

  std::size_t written = 0, left_out = 0;
  for (std::size_t begin = 0, end = 0; begin < keyed.size(); begin = end) {
    Mean mean;
    for (end = begin; end < keyed.size() && keyed[end].first == keyed[begin].first; ++end) {
      const std::uint32_t k = keyed[end].second;
      const float w = surfels.weight[k];
      mean.position += w * Eigen::Vector3f(surfels.x[k], surfels.y[k], surfels.z[k]);
      mean.normal += w * Eigen::Vector3f(surfels.nx[k], surfels.ny[k], surfels.nz[k]);
      mean.weight += w;
    }
    if (!(mean.weight > 0) || !(mean.normal.squaredNorm() > 0)) continue;
    if (written == out->x.size()) {
      ++left_out;
      continue;
    }
    write_disc(mean, radius_m, written++, out);
  }
  shorten(written, out);
  bound_chunks(out);
  return left_out;
}

}  // namespace loopsift
