// SPDX-License-Identifier: MIT
// Sifting under a time limit: whenever it is stopped there is a map, the best of the loops decided so far.
// Desk code: one thread.
#pragma once
#include <cstddef>
#include <functional>

#include "core/pipeline/back_end.hpp"

namespace loopsift::tool {

/// Takes the loops in portions, in their order; each portion is scored, decided and its map published before
/// the next one comes in. Once all are decided and time is left, the batch algorithm on all of them. Past the
/// limit it stops as soon as what is accepted is published; loops not looked at by then are handed to the
/// back end and stay pending. `seconds_left` is asked between the steps of sifting; not above 0: stop. `show`
/// is told how many loops are decided, of how many.
/// @return whether the result is that of the batch algorithm.
bool sift_within(const std::function<double()>& seconds_left, Span<const Loop> loops, BackEnd* back_end,
                 const std::function<void(std::size_t, std::size_t)>& show);

}  // namespace loopsift::tool
