// SPDX-License-Identifier: MIT
// Sums of JᵀWJ, JᵀWr and scalars over pixels, in vector lanes: what the tracking kernels share.
#pragma once
#include <cstddef>

namespace loopsift {

inline constexpr int kLanes = 8;    ///< of the accumulators: one AVX2 register
inline constexpr int kBlock = 160;  ///< pixels whose intermediate values stay in the first cache level

/// Number of sums of a system with `columns` unknowns: the upper triangle, the right-hand side, and scalars.
constexpr int sum_count(int columns, int scalars) { return columns * (columns + 1) / 2 + columns + scalars; }

/// Adds Σ w J_a J_c (a ≤ c, row by row) and Σ w J_a r of `count` pixels (a multiple of kLanes) to the first
/// sums. To be inlined into a function with run-time dispatch.
template <int kColumns>
[[gnu::always_inline]] inline void accumulate_system(const float (*J)[kBlock], const float* r, const float* w,
                                                     int count, float (*__restrict sums)[kLanes]) {
  constexpr int kTriangle = kColumns * (kColumns + 1) / 2;
  for (int i = 0; i < count; i += kLanes) {
    int term = 0;
    for (int a = 0; a < kColumns; ++a) {
      float wj[kLanes];
      for (int l = 0; l < kLanes; ++l) wj[l] = w[i + l] * J[a][i + l];
      for (int c = a; c < kColumns; ++c, ++term)
        for (int l = 0; l < kLanes; ++l) sums[term][l] += wj[l] * J[c][i + l];
      for (int l = 0; l < kLanes; ++l) sums[kTriangle + a][l] += wj[l] * r[i + l];
    }
  }
}

/// Single-precision sums of one row go into double-precision ones, so that 10⁵ pixels cost no digits.
inline void add_sums(const float (*sums)[kLanes], int count, double* total) {
  for (int k = 0; k < count; ++k)
    for (int l = 0; l < kLanes; ++l) total[k] += static_cast<double>(sums[k][l]);
}

}  // namespace loopsift
