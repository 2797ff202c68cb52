// SPDX-License-Identifier: MIT
// Whether one map predicts the views better than another, from as few of them as tell.
//
// In: the reference map, and the other map. Out: an estimate of how much the sum
// over all views falls, and its standard error. Views around which nothing moved are left out, as their part
// is the same in both; of the others at most max_views are rendered, evenly spread, and they stand for the
// rest. The order is the same for all comparisons, so that a view rendered for one is there for the next.
// Rendering ends early once the gain, were it even one standard error better than it looks, would not be
// significant at the end. So a comparison costs as many views as its outcome is close, whatever the size of
// the map. Thread: back. Reuses its buffers. Deterministic.
#pragma once
#include <cstdint>
#include <vector>

#include "core/posterior/map_likelihood.hpp"

namespace loopsift {

struct ViewComparison {
  double gain = 0;            ///< m², how much lower the second map's score is, prior included
  double standard_error = 0;  ///< of gain; the views are the samples
  int views = 0;              ///< rendered
  /// The one-standard-error rule (Breiman et al., Classification and Regression Trees, 1984, 3.4.3): the
  /// simpler model, here the one without the loop, unless the gain is more than its standard error.
  [[nodiscard]] bool significant() const { return gain > standard_error; }
};

/// How far a comparison may go.
struct ComparisonLimits {
  int max_views = 0;       ///< 0: all that may differ
  bool stop_early = true;  ///< end once it cannot become significant
};

class ViewComparer {
 public:
  /// The reference map with the one at T_after, whose score without its views is prior_gain lower.
  [[nodiscard]] ViewComparison compare(MapLikelihood* likelihood, Reference reference,
                                       Span<const Se3> T_after, double prior_gain,
                                       const ComparisonLimits& limits);

 private:
  void spread_views(std::size_t view_count);

  std::vector<std::uint16_t> views_;
  std::vector<std::uint8_t> is_chosen_;
};

/// A number of step lengths coprime to n that visits 0 … n−1 evenly spread at every stage: n times the golden
/// ratio.
[[nodiscard]] std::size_t spreading_stride(std::size_t n);

}  // namespace loopsift
