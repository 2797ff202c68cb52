// SPDX-License-Identifier: MIT
// A smooth error of the camera's inverse depth over its image, as uncalibrated structured-light cameras have
// it (Herrera et al. 2012; Teichman et al. 2013): 1/z ← 1/z + D(u, v), D a polynomial of degree three.
#pragma once
#include <Eigen/Core>

#include "core/geometry/camera.hpp"
#include "core/geometry/image.hpp"

namespace loopsift {

inline constexpr int kDisparityTerms = 9;

/// Coefficients of D in 1/m. Its constant part is left out: it cannot be told from the scale of the world.
using DisparityCoefficients = Eigen::Matrix<double, kDisparityTerms, 1>;

/// The terms at image coordinates x, y from −1 to 1: x, y, x², xy, y², x³, x²y, xy², y³.
inline void disparity_terms(float x, float y, float* terms) {
  const float values[kDisparityTerms] = {x,         y,         x * x,     x * y,    y * y,
                                         x * x * x, x * x * y, x * y * y, y * y * y};
  for (int k = 0; k < kDisparityTerms; ++k) terms[k] = values[k];
}

/// Pixel to image coordinates from −1 to 1, the same for all pyramid levels.
inline float image_coordinate(int pixel, int size) {
  return (2.0F * static_cast<float>(pixel) + 1.0F) / static_cast<float>(size) - 1.0F;
}

/// D of every pixel. Never allocates.
void draw_disparity(const DisparityCoefficients& coefficients, const ImageView<float>& out);
/// z ← z / (1 + z D), 0 stays 0. Images of the same size. Never allocates; vectorised.
void correct_depth(const ImageView<const float>& disparity, const ImageView<float>& depth_m);

}  // namespace loopsift
