// SPDX-License-Identifier: MIT
// The surfels that scoring renders: a fragment thinned to about one disc per voxel, in structure-of-arrays
// form, sorted so that runs of kChunkSize lie close together and can be culled by one bounding sphere.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/span.hpp"
#include "core/fragment/fragment.hpp"

namespace loopsift {

constexpr std::size_t kChunkSize = 64;

/// Bounding sphere of up to kChunkSize consecutive discs, fragment frame, metres.
struct SurfelChunk {
  Eigen::Vector3f center = Eigen::Vector3f::Zero();
  float radius = 0;
  std::uint32_t begin = 0;
  std::uint32_t size = 0;
};

/// Discs of one fragment; positions in metres and unit normals in the fragment frame. Owns nothing.
struct ScoreSurfels {
  Span<float> x, y, z, nx, ny, nz;
  Span<float> radius;  ///< disc radius, metres
  Span<SurfelChunk> chunks;
  [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// Fills surfels->chunks, ⌈size / kChunkSize⌉ of them, with the bounding spheres of its discs.
void bound_chunks(ScoreSurfels* surfels);

/// Scratch of thin(), reused from call to call.
struct ThinScratch {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
};

/// One disc per voxel of edge spacing_m and facing (the dominant axis of the normal, so that the two sides of
/// a thin thing stay apart): weighted mean position and normal, radius radius_m. Writes at most out's
/// capacity; whole discs past it are left out. Deterministic. `out` spans give the capacity and are shortened
/// to what was written. Back thread.
/// @return how many discs did not fit.
[[nodiscard]] std::size_t thin(const SurfelSpan& surfels, float spacing_m, float radius_m,
                               ThinScratch* scratch, ScoreSurfels* out);

}  // namespace loopsift
