// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/disc_set.hpp"

#include <algorithm>

namespace loopsift::tool {
namespace {

std::array<Span<float>*, 7> columns_of(ScoreSurfels* discs) {
  return {&discs->x, &discs->y, &discs->z, &discs->nx, &discs->ny, &discs->nz, &discs->radius};
}

}  // namespace

DiscSet::DiscSet(std::size_t capacity)
    : values_(7 * capacity), chunks_((capacity + kChunkSize - 1) / kChunkSize) {
  float* next = values_.data();
  for (Span<float>* column : columns_of(&discs_)) {
    *column = {next, capacity};
    next += capacity;
  }
  discs_.chunks = chunks_;
}

DiscSet DiscSet::of(const std::array<Span<const float>, 7>& columns) {
  DiscSet set(columns[0].size());
  const auto targets = columns_of(&set.discs_);
  for (std::size_t c = 0; c < columns.size(); ++c)
    std::copy(columns[c].begin(), columns[c].end(), targets[c]->begin());
  bound_chunks(&set.discs_);
  return set;
}

DiscSet DiscSet::of(const SurfelSpan& s) {
  return of(std::array<Span<const float>, 7>{s.x, s.y, s.z, s.nx, s.ny, s.nz, s.radius});
}

DiscSet DiscSet::thinned(const SurfelSpan& surfels, const PosteriorOptions& options) {
  DiscSet set(static_cast<std::size_t>(options.max_discs_per_fragment));
  ThinScratch scratch;
  (void)thin(surfels, options.disc_spacing_m, options.disc_radius_m, &scratch, &set.discs_);
  return set;
}

}  // namespace loopsift::tool
