// SPDX-License-Identifier: MIT
#include "core/posterior/residual_rows.hpp"

#include "core/base/simd.hpp"

namespace loopsift {

LOOPSIFT_SIMD PixelSum squared_row(const float* own, const float* other, const float* depth, int n) {
  float residuals = 0, pixels = 0;
#pragma omp simd reduction(+ : residuals, pixels)
  for (int x = 0; x < n; ++x) {
    float counts = 0;
    const float e = residual(std::max(own[x], other[x]), depth[x], &counts);
    residuals += e * e;
    pixels += counts;
  }
  return {static_cast<double>(residuals), static_cast<double>(pixels)};
}

LOOPSIFT_SIMD PixelSum absolute_row(const float* own, const float* other, const float* depth, int n) {
  float residuals = 0, pixels = 0;
#pragma omp simd reduction(+ : residuals, pixels)
  for (int x = 0; x < n; ++x) {
    float counts = 0;
    residuals += residual(std::max(own[x], other[x]), depth[x], &counts);
    pixels += counts;
  }
  return {static_cast<double>(residuals), static_cast<double>(pixels)};
}

LOOPSIFT_SIMD void keep_row(const float* own, const float* other, const float* depth, int n, float* kept) {
#pragma omp simd
  for (int x = 0; x < n; ++x) {
    float counts = 0;
    const float e = residual(std::max(own[x], other[x]), depth[x], &counts);
    kept[x] = other[x] > 0.0F ? e : kept[x];
  }
}

LOOPSIFT_SIMD PixelSum supported_row(const float* own, const float* other, const float* depth,
                                     const float* kept, int n) {
  float residuals = 0, pixels = 0;
#pragma omp simd reduction(+ : residuals, pixels)
  for (int x = 0; x < n; ++x) {
    float counts = 0;
    const float e = residual(std::max(own[x], other[x]), depth[x], &counts);
    const bool keeps = (kept[x] >= 0.0F) & (other[x] <= 0.0F);
    residuals += keeps ? kept[x] : e;
    pixels += (keeps & (depth[x] > 0.0F)) ? 1.0F : counts;
  }
  return {static_cast<double>(residuals), static_cast<double>(pixels)};
}

LOOPSIFT_SIMD PixelSum compare_row(const float* own, const float* first, const float* second,
                                   const float* depth, int n) {
  float difference = 0, pixels = 0;
#pragma omp simd reduction(+ : difference, pixels)
  for (int x = 0; x < n; ++x) {
    float counts = 0, ignored = 0;
    const float a = residual(std::max(own[x], first[x]), depth[x], &counts);
    const float b = residual(std::max(own[x], second[x]), depth[x], &ignored);
    const bool both = (first[x] > 0.0F) & (second[x] > 0.0F);
    difference += both ? a - b : 0.0F;
    pixels += counts;
  }
  return {static_cast<double>(difference), static_cast<double>(pixels)};
}

}  // namespace loopsift
