// SPDX-License-Identifier: MIT
// What images may be at most.
#pragma once

namespace loopsift {

/// Images of any source have at most so many pixels on a side: whoever says more (a damaged file, a
/// stranger's message) does not get the memory for it.
constexpr int kLargestSide = 8192;

}  // namespace loopsift
