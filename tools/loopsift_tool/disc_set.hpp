// SPDX-License-Identifier: MIT
// Surfels as the discs that the posterior renders, with memory of their own. Desk code: allocates.
#pragma once
#include <array>
#include <vector>

#include "core/posterior/map_scorer.hpp"
#include "core/posterior/score_surfels.hpp"

namespace loopsift::tool {

class DiscSet {
 public:
  /// All surfels, each with its own radius: columns x y z nx ny nz radius of one size, metres.
  [[nodiscard]] static DiscSet of(const std::array<Span<const float>, 7>& columns);
  [[nodiscard]] static DiscSet of(const SurfelSpan& surfels);
  /// Thinned as for scoring.
  [[nodiscard]] static DiscSet thinned(const SurfelSpan& surfels, const PosteriorOptions& options);

  DiscSet(DiscSet&&) = default;
  DiscSet& operator=(DiscSet&&) = default;
  DiscSet(const DiscSet&) = delete;
  DiscSet& operator=(const DiscSet&) = delete;
  ~DiscSet() = default;

  [[nodiscard]] const ScoreSurfels& discs() const { return discs_; }

 private:
  explicit DiscSet(std::size_t capacity);
  std::vector<float> values_;
  std::vector<SurfelChunk> chunks_;
  ScoreSurfels discs_;  // points into both
};

}  // namespace loopsift::tool
