// SPDX-License-Identifier: MIT
// Wrong loops of the kinds that proposers make. Desk code: allocates, the same for the same seed.
#pragma once
#include <vector>

#include "tools/loopsift_tool/comparison/truth.hpp"

namespace loopsift::tool {

/// `count` false loops, in equal shares on average: the true motion of one pair of fragments put to another
/// pair; a true one turned by 30–90° and moved by 0.3–1 m; a near miss, 0.25–0.6 m and up to 8° off. All are
/// more than 0.2 m or 12° off the truth. Each carries the information of one of `loops`, and an id above all
/// of theirs. Errors: no loop to take after, fewer than four fragments, no true pose for one of them.
[[nodiscard]] Expected<std::vector<Loop>> make_false_loops(const std::vector<Loop>& loops, const Truth& truth,
                                                           Span<const Fragment> fragments, int count,
                                                           unsigned seed);

}  // namespace loopsift::tool
