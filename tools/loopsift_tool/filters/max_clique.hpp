// SPDX-License-Identifier: MIT
// A largest set of mutually adjacent vertices. Branch and bound with greedy colouring as the bound (Tomita &
// Seki, An efficient branch-and-bound algorithm for finding a maximum clique, DMTCS 2003). Desk code:
// allocates, deterministic.
#pragma once
#include <cstdint>
#include <vector>

namespace loopsift::tool {

struct MaxClique {
  std::vector<int> members;  ///< in rising order
  bool proven = true;        ///< false: the budget ran out; this is the largest one found until then
};

/// `adjacent` is square and symmetric; its diagonal is ignored. `budget` bounds the branches looked at. Of
/// several largest cliques always the same one.
[[nodiscard]] MaxClique max_clique(const std::vector<std::vector<bool>>& adjacent, std::int64_t budget);

}  // namespace loopsift::tool
