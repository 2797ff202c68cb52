// SPDX-License-Identifier: MIT
#include "core/frame/disparity_correction.hpp"

#include "core/base/simd.hpp"

namespace loopsift {
namespace {

LOOPSIFT_SIMD void correct_row(const float* disparity, int width, float* __restrict depth) {
  for (int x = 0; x < width; ++x) depth[x] = depth[x] / (1.0F + depth[x] * disparity[x]);
}

}  // namespace

void draw_disparity(const DisparityCoefficients& coefficients, const ImageView<float>& out) {
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) {
      float terms[kDisparityTerms];
      disparity_terms(image_coordinate(u, out.width), image_coordinate(v, out.height), terms);
      float sum = 0.0F;
      for (int k = 0; k < kDisparityTerms; ++k) sum += static_cast<float>(coefficients[k]) * terms[k];
      out(u, v) = sum;
    }
  }
}

void correct_depth(const ImageView<const float>& disparity, const ImageView<float>& depth_m) {
  for (int y = 0; y < depth_m.height; ++y) correct_row(disparity.row(y), depth_m.width, depth_m.row(y));
}

}  // namespace loopsift
