// SPDX-License-Identifier: MIT
#include "core/fragment/thinner.hpp"

#include <algorithm>
#include <cmath>

#include "core/fragment/surfel_arrays.hpp"
#include "core/fragment/surfel_math.hpp"

namespace loopsift {
namespace {

std::size_t table_size(std::size_t capacity) {
  std::size_t size = 64;
  while (size < 2 * capacity) size *= 2;
  return size;
}

// Dominant axis of a normal, with its sign: 0 … 5.
std::uint64_t side_of(float nx, float ny, float nz) {
  const float ax = std::fabs(nx), ay = std::fabs(ny), az = std::fabs(nz);
  if (ax >= ay && ax >= az) return nx > 0 ? 0 : 1;
  if (ay >= az) return ny > 0 ? 2 : 3;
  return nz > 0 ? 4 : 5;
}

// 20 bits per axis (± 10 km at 2 cm), 3 for the side, and one that makes it non-zero.
std::uint64_t key_of(const SurfelSpan& s, std::size_t i, float inverse_cell) {
  const auto cell = [&](float v) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v * inverse_cell)) + (1 << 19)) &
           0xFFFFFU;
  };
  return cell(s.x[i]) << 44 | cell(s.y[i]) << 24 | cell(s.z[i]) << 4 |
         side_of(s.nx[i], s.ny[i], s.nz[i]) << 1 | 1U;
}

std::uint64_t mix(std::uint64_t v) {  // Steele et al. 2014, SplitMix64
  v = (v ^ (v >> 30)) * 0xBF58476D1CE4E5B9ULL;
  v = (v ^ (v >> 27)) * 0x94D049BB133111EBULL;
  return v ^ (v >> 31);
}

// Surfel `from` into surfel `to`; normals stay sums until finish().
void merge(const SurfelSpan& s, std::size_t from, std::size_t to) {
  const float sum = s.weight[to] + s.weight[from], a = s.weight[to] / sum, b = s.weight[from] / sum;
  for (const Span<float>* v : {&s.x, &s.y, &s.z, &s.nx, &s.ny, &s.nz})
    (*v)[to] = a * (*v)[to] + b * (*v)[from];
  s.radius[to] = std::max(s.radius[to], s.radius[from]);
  s.rgb[to] = blend_rgb(s.rgb[to], s.rgb[from], a);
  s.weight[to] = sum;
  s.first_frame[to] = std::min(s.first_frame[to], s.first_frame[from]);
  s.last_frame[to] = std::max(s.last_frame[to], s.last_frame[from]);
}

void normalize(const SurfelSpan& s, std::size_t i) {
  const float inverse = 1.0F / std::sqrt(s.nx[i] * s.nx[i] + s.ny[i] * s.ny[i] + s.nz[i] * s.nz[i]);
  s.nx[i] *= inverse;
  s.ny[i] *= inverse;
  s.nz[i] *= inverse;
}

}  // namespace

Thinner::Thinner(std::size_t capacity, Arena& arena)
    : cells_(arena.carve<Cell>("fragment/thinning", table_size(capacity))) {}

SurfelSpan Thinner::thin(const SurfelSpan& surfels, float cell_m, std::size_t max_surfels) {
  constexpr int kAttempts = 12;
  std::size_t count = thin_once(surfels, cell_m);
  for (int i = 0; i < kAttempts && count > max_surfels; ++i) {
    cell_m *= 1.4142136F;
    count = thin_once(slice(surfels, 0, count), cell_m);
  }
  return slice(surfels, 0, std::min(count, max_surfels));
}

std::size_t Thinner::thin_once(const SurfelSpan& surfels, float cell_m) {
  std::fill(cells_.begin(), cells_.end(), Cell{0, 0});
  const float inverse_cell = 1.0F / cell_m;
  std::size_t kept = 0;  // never past i: in place
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    const std::uint64_t key = key_of(surfels, i, inverse_cell);
    Cell& cell = cell_of(key);
    if (cell.key == key) {
      merge(surfels, i, static_cast<std::size_t>(cell.surfel));
      continue;
    }
    cell = {key, static_cast<std::int32_t>(kept)};
    if (kept != i) move_surfel(surfels, i, kept);
    ++kept;
  }
  for (std::size_t i = 0; i < kept; ++i) {
    normalize(surfels, i);
    surfels.radius[i] =
        std::max(surfels.radius[i], 0.87F * cell_m);  // half the cell's diagonal: discs overlap
  }
  return kept;
}

Thinner::Cell& Thinner::cell_of(std::uint64_t key) {
  const std::size_t mask = cells_.size() - 1;
  std::size_t at = mix(key) & mask;
  while (cells_[at].key != 0 && cells_[at].key != key) at = (at + 1) & mask;
  return cells_[at];
}

}  // namespace loopsift
