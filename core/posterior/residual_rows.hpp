// SPDX-License-Identifier: MIT
// Residuals of predicted against measured depth, a row of pixels at a time, vectorised. Predictions are
// inverse depth, 1/m; measurements metres; 0 where there is none. Sums run in single precision over a row
// only, in a fixed order. Never allocates.
#pragma once
#include <algorithm>
#include <cmath>

namespace loopsift {

// |1/inverse − measured|, 0 where one of the two is missing; *counts says whether the pixel is in Ω.
inline __attribute__((always_inline)) float residual(float inverse, float measured, float* counts) {
  const bool valid = (inverse > 0.0F) & (measured > 0.0F);
  const float e = std::abs(1.0F / (inverse > 0.0F ? inverse : 1.0F) - measured);
  *counts = valid ? 1.0F : 0.0F;
  return valid ? e : 0.0F;
}

struct PixelSum {
  double residuals = 0;
  double pixels = 0;
  [[nodiscard]] double mean() const { return pixels > 0 ? residuals / pixels : 0.0; }
};

/// Σ e² of the nearer of two predictions.
PixelSum squared_row(const float* own, const float* other, const float* depth, int n);
/// Σ |e| of the nearer of two predictions.
PixelSum absolute_row(const float* own, const float* other, const float* depth, int n);
/// |e| of the pixels that `other` predicts, into kept; 0 where nothing was measured.
void keep_row(const float* own, const float* other, const float* depth, int n, float* kept);
/// Σ |e|; a pixel with a residual kept (≥ 0) that `other` no longer predicts counts with that.
PixelSum supported_row(const float* own, const float* other, const float* depth, const float* kept, int n);
/// Σ (|e_first| − |e_second|) over the pixels that both predict; `pixels` are those that count for the first.
PixelSum compare_row(const float* own, const float* first, const float* second, const float* depth, int n);

template <class Row>
double mean_over_rows(int height, const Row& row) {
  PixelSum sum;
  for (int y = 0; y < height; ++y) {
    const PixelSum r = row(y);
    sum.residuals += r.residuals;
    sum.pixels += r.pixels;
  }
  return sum.mean();
}

}  // namespace loopsift
