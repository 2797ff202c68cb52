// SPDX-License-Identifier: MIT
// Small pieces that the surfel kernels share.
#pragma once
#include <cstdint>

#include "core/geometry/se3.hpp"

namespace loopsift {

/// A rigid motion as plain floats, rows first: what a vectorised loop keeps in registers.
struct PoseFloats {
  float R[9], t[3];
  explicit PoseFloats(const Se3f& T) : R{}, t{} {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) R[3 * r + c] = T.R(r, c);
      t[r] = T.t[r];
    }
  }
};

/// Mean of two colours 0x00RRGGBB, the first with weight a (0 … 1), the second with weight 1 − a.
[[nodiscard]] inline std::uint32_t blend_rgb(std::uint32_t first, std::uint32_t second, float a) {
  std::uint32_t out = 0;
  for (const int shift : {16, 8, 0}) {
    const auto c1 = static_cast<float>(first >> shift & 0xFFU);
    const auto c2 = static_cast<float>(second >> shift & 0xFFU);
    out |= static_cast<std::uint32_t>(a * c1 + (1.0F - a) * c2 + 0.5F) << shift;
  }
  return out;
}

}  // namespace loopsift
