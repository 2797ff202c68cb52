// SPDX-License-Identifier: MIT
// Handling all arrays of a SurfelSpan alike.
#pragma once
#include <string>

#include "core/base/arena.hpp"
#include "core/fragment/fragment.hpp"

namespace loopsift {

/// `count` surfels from the arena.
[[nodiscard]] SurfelSpan carve_surfels(Arena& arena, const std::string& owner, std::size_t count);
/// The elements [first, first + count) of every array.
[[nodiscard]] SurfelSpan slice(const SurfelSpan& surfels, std::size_t first, std::size_t count);
/// All elements of source to the beginning of target, which is as large or larger.
void copy_surfel_arrays(const SurfelSpan& source, const SurfelSpan& target);
/// Element `from` over element `to`.
void move_surfel(const SurfelSpan& surfels, std::size_t from, std::size_t to);

}  // namespace loopsift
