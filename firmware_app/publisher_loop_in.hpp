// SPDX-License-Identifier: MIT
// The gate for loops of other programs (LOOPSIFT_LOOP_IN): bytes from anyone in, a sound loop or nothing out.
// Never allocates.
#pragma once
#include <cstddef>

#include "core/pipeline/outside_loops.hpp"

namespace loopsift {

/// False, and nothing is written, when the bytes are no loopsift.loop_in_t, or what they say is no rigid
/// motion, or its covariance is not positive definite.
[[nodiscard]] bool parse_loop_in(const void* bytes, std::size_t size, OutsideLoop* loop);

}  // namespace loopsift
