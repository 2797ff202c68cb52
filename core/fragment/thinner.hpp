// SPDX-License-Identifier: MIT
// Thins surfels to about one per cubic cell and side: those of a cell whose normals share their dominant axis
// and its sign become their weighted mean. Two sides of a thin thing stay two surfels.
#pragma once
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/fragment/fragment.hpp"

namespace loopsift {

/// Thread: front. No allocation after construction.
class Thinner {
 public:
  /// For up to `capacity` surfels.
  Thinner(std::size_t capacity, Arena& arena);
  /// In place; returns the first, surviving part of `surfels`. cell_m is widened by √2 until at most
  /// max_surfels are left (deterministic; what then is still too many is cut off).
  SurfelSpan thin(const SurfelSpan& surfels, float cell_m, std::size_t max_surfels);

 private:
  struct Cell {
    std::uint64_t key;  // 0: empty
    std::int32_t surfel;
  };
  std::size_t thin_once(const SurfelSpan& surfels, float cell_m);
  Cell& cell_of(std::uint64_t key);

  Span<Cell> cells_;  // open addressing; a power of two, at least twice the capacity
};

}  // namespace loopsift
