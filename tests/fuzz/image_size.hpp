// SPDX-License-Identifier: MIT
#pragma once

namespace loopsift::fuzz {

/// Of the corpus and of what the fuzzed decoders expect: small, so that many are tried.
inline constexpr int kWidth = 24, kHeight = 16;

}  // namespace loopsift::fuzz
