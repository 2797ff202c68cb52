// SPDX-License-Identifier: MIT
// Intensity images for the photometric term: the logarithm of the luminance, so that a change of exposure is
// one number added to the whole image. No allocation; vectorised with run-time dispatch.
#pragma once
#include "core/geometry/image.hpp"

namespace loopsift {

/// Brightness is ln(luminance + kDarkLevel): below this level (of 255) sensor noise weighs less and less.
inline constexpr float kDarkLevel = 16.0F;

/// Mean luminance ((r + 2g + b) / 4) of the block of colour pixels behind each output pixel, as ln(mean +
/// kDarkLevel). The colour image is taken to show what the output image shows; it must not be smaller, and a
/// block is at most 64 pixels wide and high.
void reduce_color(const ImageView<const Rgb8>& color, const ImageView<float>& out);
/// Means of 2 × 2 blocks.
void halve_intensity(const ImageView<const float>& intensity, const ImageView<float>& out);

}  // namespace loopsift
